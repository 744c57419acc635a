// What the tests of the ground share: small worlds, maps and records.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "tilth/ground/ground.h"
#include "tilth/source/analytic_sources.h"

namespace tilth::test {

/// A flat world at 10 m; `size` posts a side.
inline std::unique_ptr<Ground> flat_ground(std::int32_t size, const GroundSettings& settings = {},
                                           double height_m = 10) {
    Result<std::unique_ptr<Ground>> made = Ground::create(std::make_shared<FlatSource>(size, height_m), settings);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
    return made.ok() ? *std::move(made) : nullptr;
}

/// The record of a request that must be good.
inline StampRecord issued(Ground& ground, const StampRequest& request) {
    const Result<StampRecord> record = ground.issue(request);
    EXPECT_TRUE(record.ok()) << (record.ok() ? "" : record.error().message);
    return record.ok() ? *record : StampRecord{};
}
inline ApplyResult stamp(Ground& ground, const StampRequest& request) { return ground.apply(issued(ground, request)); }

constexpr ShapeId builtin(BuiltinProfile profile) { return {static_cast<std::uint32_t>(profile)}; }
inline constexpr BuiltinProfile kAllProfiles[] = {BuiltinProfile::Gaussian,   BuiltinProfile::Cone,
                                                  BuiltinProfile::Paraboloid, BuiltinProfile::Cosine,
                                                  BuiltinProfile::Crater,     BuiltinProfile::Disc};
inline constexpr HeightPrecision kBothPrecisions[] = {HeightPrecision::bits32, HeightPrecision::bits16};

/// A detail-like map of `size` texels a side, origin 0, spacing a power of two.
inline MapGeometry map_of(std::int32_t size, HeightPrecision precision = HeightPrecision::bits32,
                          double spacing_m = 1.0) {
    return {.kind = MapKind::Detail,
            .grid = {.spacing_m = spacing_m, .width = size, .depth = size},
            .codec = HeightCodec::detail(),
            .precision = precision};
}

/// A record at `x`, `z` texels of `map_of(..)` with spacing 1, without a world.
inline StampRecord record_at(double x_texels, double z_texels, double radius_texels, std::uint32_t amplitude,
                             ShapeId shape, StampRule rule = StampRule::Add) {
    StampRecord record{.map = MapKind::Detail, .rule = rule};
    record.centre_x = std::llround(x_texels * 16777216.0);
    record.centre_z = std::llround(z_texels * 16777216.0);
    record.radius = static_cast<std::uint32_t>(std::lround(radius_texels * 262144));
    record.amplitude = amplitude;
    record.level = kMidCode;
    record.shape = shape.value;
    return record;
}

/// Sum over the field of code - 2^31.
inline std::int64_t volume(const HeightField& field) {
    std::int64_t sum = 0;
    for (const std::uint32_t code : field.codes()) sum += std::int64_t{code} - std::int64_t{kMidCode};
    return sum;
}

/// Three user shapes: an image that has no symmetry, a signed baked one, and a signed profile.
struct UserShapes {
    ShapeId image, baked, profile;
    explicit UserShapes(ShapeLibrary& shapes) {
        std::vector<std::uint16_t> texels;
        for (int row = 0; row < 5; ++row)
            for (int column = 0; column < 7; ++column)
                texels.push_back(static_cast<std::uint16_t>((row * 7 + column) * 1913 + column * column * 97));
        texels[3] = 65535, texels[9] = 0;
        image = *shapes.add_image("asymmetric", 7, 5, texels);
        baked =
            *shapes.bake("waves", 33, [](double x, double z) { return std::sin(4 * x + z) * std::cos(3 * z - 0.3); });
        profile = *shapes.add_profile(
            "ripple", [](double t) { return std::cos(14 * t) * (1 - t); }, 1.25);
    }
};

}  // namespace tilth::test
