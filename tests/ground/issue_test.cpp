// What the ground refuses: bad requests and settings, with the field's name, before anything is touched.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ground/support.h"
#include "tilth/source/raster_source.h"

namespace tilth {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
const double kNan = std::nan("");

struct Bad {
    const char* field;
    StampRequest request;
};

std::vector<Bad> bad_requests() {
    const StampRequest good{.shape = {0}, .centre = {16, 16}, .radius_m = 2, .amplitude_m = 0.1};
    std::vector<Bad> bad;
    const auto add = [&](const char* field, auto&& change) {
        StampRequest request = good;
        change(request);
        bad.push_back({field, request});
    };
    add("shape", [](StampRequest& r) { r.shape = {6}; });
    add("rule", [](StampRequest& r) { r.rule = static_cast<StampRule>(9); });
    add("map", [](StampRequest& r) { r.map = static_cast<MapChoice>(7); });
    add("shape", [](StampRequest& r) { r.shape = {0xffffffffu}; });
    for (const double v : {kNan, kInf, -kInf, 1.1e10}) {
        add("centre", [&](StampRequest& r) { r.centre.x = v; });
        add("centre", [&](StampRequest& r) { r.centre.z = v; });
    }
    for (const double v : {kNan, kInf, -kInf, 0.0, -0.0, -1.0, 8192.0, 1e300})
        for (const MapChoice map : {MapChoice::Auto, MapChoice::Coarse, MapChoice::Detail})
            add("radius", [&](StampRequest& r) { r.radius_m = v, r.map = map; });
    add("radius", [](StampRequest& r) { r.radius_m = 8192.0 / 3, r.map = MapChoice::Detail; });
    for (const double v : {kNan, kInf, -kInf}) add("rotation", [&](StampRequest& r) { r.rotation_rad = v; });
    for (const double v : {kNan, kInf, -kInf, 16.1, -16.1, 1e300})
        for (const StampRule rule : {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set})
            add("amplitude", [&](StampRequest& r) { r.amplitude_m = v, r.rule = rule; });
    for (const double v : {kNan, kInf, -1e-9, 1.0000001})
        for (const MapChoice map : {MapChoice::Coarse, MapChoice::Detail})
            add("amplitude", [&](StampRequest& r) { r.amplitude_m = v, r.rule = StampRule::Smooth, r.map = map; });
    for (const StampRule rule : {StampRule::Min, StampRule::Max, StampRule::Set}) {
        add("level", [&](StampRequest& r) { r.rule = rule, r.map = MapChoice::Coarse; });
        add("level", [&](StampRequest& r) { r.rule = rule, r.radius_m = 8; });  // auto takes the coarse map
        for (const double v : {kNan, kInf, -kInf, 8.0, -8.01})
            add("level", [&](StampRequest& r) { r.rule = rule, r.level_m = v; });
        for (const double v : {kNan, 10 + 32.0, 10 - 32.01})
            add("level", [&](StampRequest& r) { r.rule = rule, r.map = MapChoice::Coarse, r.level_m = v; });
    }
    return bad;
}

TEST(Issue, RefusesBadFieldsByNameAndChangesNothing) {
    auto ground = test::flat_ground(33);
    const StateHash before = ground->hash();
    for (const Bad& bad : bad_requests()) {
        const Result<StampRecord> result = ground->issue(bad.request);
        ASSERT_FALSE(result.ok()) << bad.field << " radius " << bad.request.radius_m << " amplitude "
                                  << bad.request.amplitude_m;
        EXPECT_EQ(result.error().code, ErrorCode::InvalidArgument);
        EXPECT_EQ(result.error().message.rfind(std::string(bad.field) + ":", 0), 0u) << result.error().message;
    }
    EXPECT_EQ(ground->hash(), before);
    EXPECT_TRUE(ground->detail().pages().empty());
    EXPECT_EQ(test::issued(*ground, {.shape = {0}, .centre = {1, 1}, .amplitude_m = 0.1}).sequence,
              1u);  // none was used
}

TEST(Issue, TakesTheEndsOfTheAllowedRanges) {
    auto ground = test::flat_ground(33);
    const StampRequest good{
        .shape = {5}, .centre = {16, 16}, .radius_m = 2, .amplitude_m = 0.1, .map = MapChoice::Detail};
    const auto taken = [&](auto&& change) {
        StampRequest request = good;
        change(request);
        return test::issued(*ground, request);
    };
    EXPECT_EQ(taken([](StampRequest& r) { r.radius_m = std::nextafter(8192.0 / 3, 0.0) - 1e-6; }).radius,
              (1u << 31) - 1u);
    EXPECT_EQ(taken([](StampRequest& r) { r.amplitude_m = 16 - 0x1p-28; }).amplitude, 0xffffffffu);
    EXPECT_EQ(taken([](StampRequest& r) { r.amplitude_m = -16 + 0x1p-28; }).negative, 1);
    EXPECT_EQ(taken([](StampRequest& r) { r.rule = StampRule::Smooth, r.amplitude_m = 1; }).amplitude, 65536u);
    EXPECT_EQ(taken([](StampRequest& r) { r.rule = StampRule::Min; }).level, kMidCode);  // 0 unless given
    EXPECT_EQ(taken([](StampRequest& r) { r.rule = StampRule::Min, r.level_m = -8.0; }).level, 0u);
    EXPECT_EQ(taken([](StampRequest& r) { r.rule = StampRule::Set, r.level_m = 10, r.map = MapChoice::Coarse; }).level,
              kMidCode);
    EXPECT_EQ(taken([](StampRequest& r) { r.rotation_rad = 1e9; }).sequence, 8u);
    ground->apply(taken([](StampRequest& r) { r.radius_m = 1e-12; }));
    const StampRecord record = taken([](StampRequest& r) {
        r.centre = {-16.5, 0x1p-24}, r.radius_m = 1, r.mirror = true;
    });
    EXPECT_EQ(record.centre_x, -(std::int64_t{33} << 23));
    EXPECT_EQ(record.centre_z, 1);
    EXPECT_EQ(record.radius, 3u << 18);
    EXPECT_EQ(record.amplitude, static_cast<std::uint32_t>(std::lround(0.1 * 0x1p28)));
    EXPECT_EQ(record.mirror, 1);
    EXPECT_EQ(record.shape_hash, ground->shapes().shape({5}).hash);
}

TEST(Issue, AutoIsCoarseFromEightPostsOn) {
    auto ground = test::flat_ground(33, {.spacing_m = 0.5});
    const auto map_of = [](const Ground& g, double radius_m) { return g.settled_map({.radius_m = radius_m}); };
    EXPECT_EQ(map_of(*ground, 4.0), MapKind::Coarse);
    EXPECT_EQ(map_of(*ground, std::nextafter(4.0, 0.0)), MapKind::Detail);
    EXPECT_EQ(map_of(*test::flat_ground(33, {.detail = false}), 0.1), MapKind::Coarse);
    EXPECT_EQ(ground->settled_map({.radius_m = 4, .map = MapChoice::Detail}), MapKind::Detail);
    EXPECT_EQ(ground->settled_map({.radius_m = 1, .map = MapChoice::Coarse}), MapKind::Coarse);
}

TEST(Issue, MapsThatAreNotThereAreRefused) {
    auto plain = test::flat_ground(33, {.detail = false}), mirrored = test::flat_ground(33, {.mirror = true});
    const StampRequest detail{.shape = {0}, .centre = {5, 5}, .amplitude_m = 0.1, .map = MapChoice::Detail};
    StampRequest coarse = detail, large = detail;
    coarse.map = MapChoice::Coarse;
    large.map = MapChoice::Auto, large.radius_m = 8;
    for (const Result<StampRecord>& result : {plain->issue(detail), mirrored->issue(coarse), mirrored->issue(large)}) {
        ASSERT_FALSE(result.ok());
        EXPECT_EQ(result.error().message.rfind("map:", 0), 0u) << result.error().message;
    }
    EXPECT_EQ(test::issued(*mirrored, detail).sequence, 1u);
}

TEST(GroundCreate, RefusesSettingsByName) {
    const auto message = [](const GroundSettings& settings, double low = 0, double high = 10) {
        auto source =
            RasterSource::create(2, 2, {static_cast<float>(low), static_cast<float>(high), 0.0f, 0.0f}, "test");
        EXPECT_TRUE(source.ok());
        const Result<std::unique_ptr<Ground>> made = Ground::create(*std::move(source), settings);
        return made.ok() ? std::string("made") : made.error().message.substr(0, made.error().message.find(':'));
    };
    EXPECT_EQ(message({}), "made");
    for (const double v : {kNan, kInf, 1.1e9}) {
        EXPECT_EQ(message({.origin = {v, 0}}), "origin");
        EXPECT_EQ(message({.origin = {0, -v}}), "origin");
    }
    for (const double v : {kNan, kInf, 0.0, -1.0, 1e-4, 1e6}) EXPECT_EQ(message({.spacing_m = v}), "spacing");
    for (const double v : {kNan, kInf, 0.0, -1.0, 0.3, 0x1p-21, 2048.0})
        EXPECT_EQ(message({.quantum_m = v}), "quantum");
    for (const int v : {0, -1, 65}) EXPECT_EQ(message({.texels_per_post = v}), "texels_per_post");
    for (const int v : {0, -64, 63, 100, 8256}) EXPECT_EQ(message({.tile_size = v}), "tile_size");
    EXPECT_EQ(message({.quantum_m = 0x1p-14}, 0, 4.1), "quantum");  // 4 m of range
    EXPECT_EQ(message({.quantum_m = 0x1p-13}, 0, 4.1), "made");
}

}  // namespace
}  // namespace tilth
