#include "tilth/ground/prepared_stamp.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tilth/core/checks.h"
#include "tilth/ground/cpu_kernels.h"
#include "tilth/ground/turn.h"

namespace tilth {
namespace {

__extension__ using Int128 = __int128;

constexpr std::int64_t kFineRadius = 256;                   // steps of a record's radius in a sub-texel
constexpr std::int64_t kSub = 1024;                         // sub-texels a texel
constexpr std::uint32_t kResidueRadius = 256 * 1024;        // largest zero-volume stamp whose residue is returned
constexpr std::int64_t kFarTexels = std::int64_t{1} << 30;  // further centres cannot touch a map

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
    return a / b - ((a % b != 0) && ((a < 0) != (b < 0)) ? 1 : 0);
}

std::int64_t rounded_div(Int128 a, Int128 b) {  // b > 0, half away from zero
    return static_cast<std::int64_t>(a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b));
}

// The one rule by which a map derives its own sub-texel centre: IEEE doubles, no fused operations.
std::int64_t sub_texels(std::int64_t fixed, double origin, double spacing_m) {
    const double metres = static_cast<double>(fixed) / 16777216.0 - origin;
    return static_cast<std::int64_t>(std::floor(metres / spacing_m * static_cast<double>(kSub) + 0.5));
}

// Widens a radius below the shape's least one; for add the amplitude shrinks so that the volume stays. The record's
// radius is finer than the map's sub-texels, so that this holds for stamps of a twentieth of a texel too.
void set_radius(StampParams& s, const StampRecord& record, const Shape& shape) {
    const auto least = static_cast<std::int64_t>(shape.least_radius_texels * static_cast<double>(kSub)) * kFineRadius;
    const std::int64_t radius = std::max<std::int64_t>(record.radius, 1);
    s.radius = static_cast<std::uint32_t>((std::max(radius, least) + kFineRadius / 2) / kFineRadius);
    if (radius < least && record.rule == StampRule::Add)
        s.amplitude =
            static_cast<std::uint32_t>(rounded_div(Int128{s.amplitude} * radius * radius, Int128{least} * least));
}

// The place of one axis of an image: where the centre texel falls and how far a texel of the map steps in x and z.
// Positions have as many fraction bits as the size leaves in 30 bits.
struct ImageAxis {
    std::uint32_t bits;
    std::int32_t centre, per_x, per_z;
};

ImageAxis image_axis(const StampParams& s, std::int32_t size, std::int32_t direction_x, std::int32_t direction_z) {
    ImageAxis axis{.bits = 30u - static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint32_t>(size) - 1u))};
    // Pixels a texel of the map: size / (2 radius); the directions are sines and cosines with 30 fraction bits.
    const auto step = [&](std::int32_t direction) {
        const Int128 scaled = Int128{direction} * size * (kSub / 2) * (Int128{1} << axis.bits);
        return static_cast<std::int32_t>(rounded_div(scaled, Int128{s.radius} << 30));
    };
    axis.per_x = step(direction_x);
    axis.per_z = step(direction_z);
    const std::int64_t middle = (std::int64_t{size - 1} << axis.bits) / 2;
    const std::int64_t shift = std::int64_t{s.offset_x} * axis.per_x + std::int64_t{s.offset_z} * axis.per_z;
    axis.centre = static_cast<std::int32_t>(middle - rounded_div(shift, kSub));
    return axis;
}

void set_image_matrix(StampParams& s, const StampRecord& record, const Shape& shape) {
    const SineCosine turn = sine_cosine(record.rotation);
    const std::int32_t flip = record.mirror != 0 ? -1 : 1;
    const ImageAxis u = image_axis(s, shape.width, flip * turn.cosine, -flip * turn.sine);
    const ImageAxis v = image_axis(s, shape.height, turn.sine, turn.cosine);
    s.image_width = static_cast<std::uint32_t>(shape.width);
    s.image_height = static_cast<std::uint32_t>(shape.height);
    s.u_bits = u.bits, s.u_centre = u.centre, s.u_per_x = u.per_x, s.u_per_z = u.per_z;
    s.v_bits = v.bits, s.v_centre = v.centre, s.v_per_x = v.per_x, s.v_per_z = v.per_z;
}

// The texels whose centre lies less than `reach` sub-texels from the stamp's centre on either axis.
TexelRect unclipped_rect(const StampParams& s, std::int64_t reach_x, std::int64_t reach_z) {
    const auto first = [](int centre, int offset, std::int64_t reach) {
        return static_cast<std::int32_t>(centre - floor_div(reach - offset, kSub));
    };
    const auto end = [](int centre, int offset, std::int64_t reach) {
        return static_cast<std::int32_t>(centre + floor_div(offset + reach, kSub) + 1);
    };
    return {{first(s.centre_x, s.offset_x, reach_x), first(s.centre_z, s.offset_z, reach_z)},
            {end(s.centre_x, s.offset_x, reach_x), end(s.centre_z, s.offset_z, reach_z)}};
}

void set_residue(StampParams& s, const Shape& shape, const TexelRect& whole) {
    std::int64_t sum = 0;
    for (std::int32_t z = whole.min.z; z < whole.max.z; ++z)
        for (std::int32_t x = whole.min.x; x < whole.max.x; x += kKernelTexels)
            sum += cpu_kernels().sum_row({.stamp = &s,
                                          .weights = shape.weights.data(),
                                          .x = x,
                                          .z = z,
                                          .count = std::min(kKernelTexels, whole.max.x - x)});
    TILTH_ASSERT(sum > -0xffffffffll && sum < 0xffffffffll, "a zero-volume stamp's residue exceeds the range");
    if (sum > 0) s.flags |= STAMP_RESIDUE_NEGATIVE;
    s.residue = static_cast<std::uint32_t>(sum > 0 ? sum : -sum);
}

}  // namespace

PreparedStamp prepare(const StampRecord& record, const MapGeometry& map, const ShapeLibrary& shapes) {
    const Shape& shape = shapes.shape({record.shape});
    PreparedStamp prepared{.params = {}, .shape = &shape};
    StampParams& s = prepared.params;
    s.amplitude = record.amplitude;
    s.level = record.level;
    s.key = record.key;
    s.flags = static_cast<std::uint32_t>(record.rule) | (shape.is_image ? STAMP_IMAGE : 0u) |
              (record.negative != 0 ? STAMP_NEGATIVE : 0u) |
              (map.precision == HeightPrecision::bits16 ? STAMP_BITS16 : 0u);
    set_radius(s, record, shape);
    s.radius_shift = static_cast<std::uint32_t>(std::countl_zero(s.radius));
    s.radius_reciprocal = static_cast<std::uint32_t>(((std::uint64_t{1} << 63) - 1) / (s.radius << s.radius_shift));

    const std::int64_t sub_x = sub_texels(record.centre_x, map.grid.origin.x, map.grid.spacing_m);
    const std::int64_t sub_z = sub_texels(record.centre_z, map.grid.origin.z, map.grid.spacing_m);
    const std::int64_t texel_x = floor_div(sub_x + kSub / 2, kSub), texel_z = floor_div(sub_z + kSub / 2, kSub);
    if (std::max(std::abs(texel_x), std::abs(texel_z)) > kFarTexels) return prepared;  // empty rectangle
    s.centre_x = static_cast<std::int32_t>(texel_x);
    s.centre_z = static_cast<std::int32_t>(texel_z);
    s.offset_x = static_cast<std::int32_t>(sub_x - texel_x * kSub);
    s.offset_z = static_cast<std::int32_t>(sub_z - texel_z * kSub);

    std::int64_t reach = s.radius;
    if (shape.is_image) {
        set_image_matrix(s, record, shape);
        const SineCosine turn = sine_cosine(record.rotation);
        const std::int64_t spread = std::int64_t{std::abs(turn.sine)} + std::abs(turn.cosine);
        reach = ((reach * spread) >> 30) + kSub;  // the turned square's half extent; a texel for rounded steps
    }
    const TexelRect whole = unclipped_rect(s, reach, reach);
    if (shape.zero_volume && record.rule == StampRule::Add && s.radius <= kResidueRadius) set_residue(s, shape, whole);
    const TexelRect clipped = intersection(whole, map.grid.rect());
    if (!clipped.empty()) {
        s.min_x = clipped.min.x, s.min_z = clipped.min.z;
        s.max_x = clipped.max.x, s.max_z = clipped.max.z;
    }
    return prepared;
}

}  // namespace tilth
