#include <algorithm>
#include <cmath>
#include <vector>

#include "tilth/core/shared_glsl.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/pool/gl_rect.h"

namespace tilth {
namespace shared {
#include "shared/slope_math.glsl"
}  // namespace shared

namespace {

/// Half float nearest to a finite float below 65 520, ties to even; larger ones give the largest half.
std::uint16_t half_of(float value) {
    const std::uint16_t sign = std::signbit(value) ? 0x8000 : 0;
    const float size = std::min(std::abs(value), 65504.0f);
    if (size == 0) return sign;
    int exponent = 0;
    std::frexp(size, &exponent);
    const int shift = std::max(exponent, -13);  // the half's unit in the last place is 2^(shift - 11)
    const auto units = static_cast<int>(std::nearbyint(std::ldexp(size, 11 - shift)));  // 0..2048
    return static_cast<std::uint16_t>(sign + units + ((shift + 13) << 10));
}

}  // namespace

Slope slope_at(const CodeView& codes, const TexelRect& map, Texel texel, const SlopeSettings& settings) {
    const bool fourth = settings.stencil == SlopeStencil::Fourth;
    const auto per_m = static_cast<float>(settings.code_quantum_m / settings.spacing_m);
    const TexelRect held = intersection(codes.rect, map);
    const auto along_x = [&](std::int32_t step) {
        return codes.code({std::clamp(texel.x + step, held.min.x, held.max.x - 1), texel.z});
    };
    const auto along_z = [&](std::int32_t step) {
        return codes.code({texel.x, std::clamp(texel.z + step, held.min.z, held.max.z - 1)});
    };
    return {shared::slope_along(along_x(-2), along_x(-1), along_x(1), along_x(2), texel.x - map.min.x, map.width() - 1,
                                fourth, per_m),
            shared::slope_along(along_z(-2), along_z(-1), along_z(1), along_z(2), texel.z - map.min.z, map.depth() - 1,
                                fourth, per_m)};
}

namespace {

/// Slopes of a run of texels of one row, x and z components apart.
struct SlopeRow {
    std::vector<float> x, z;
};

/// The run's texels whose whole stencil lies in the view: the loop that the compiler vectorises.
template <bool Fourth>
void inner_slopes(const CodeView& codes, Texel first, std::int32_t count, float per_m, float* __restrict out_x,
                  float* __restrict out_z) {
    constexpr std::int32_t kReach = Fourth ? 2 : 1;
    const std::uint32_t* here = codes.at(first);
    const std::uint32_t* before = codes.at({first.x, first.z - 1});
    const std::uint32_t* after = codes.at({first.x, first.z + 1});
    const std::uint32_t* before2 = codes.at({first.x, first.z - kReach});
    const std::uint32_t* after2 = codes.at({first.x, first.z + kReach});
    for (std::int32_t i = 0; i < count; ++i) {
        out_x[i] = shared::slope_along(here[i - kReach], here[i - 1], here[i + 1], here[i + kReach], kReach, 2 * kReach,
                                       Fourth, per_m);
        out_z[i] = shared::slope_along(before2[i], before[i], after[i], after2[i], kReach, 2 * kReach, Fourth, per_m);
    }
}

/// Slopes of the texels [min_x, max_x) of row `z`.
void slopes_of_row(const CodeView& codes, const TexelRect& map, std::int32_t z, std::int32_t min_x, std::int32_t max_x,
                   const SlopeSettings& settings, SlopeRow& out) {
    out.x.resize(static_cast<std::size_t>(max_x - min_x));
    out.z.resize(out.x.size());
    const TexelRect inner_texels = expanded(intersection(codes.rect, map), -stencil_reach(settings.stencil));
    std::int32_t inner_min = max_x, inner_max = max_x;
    if (z >= inner_texels.min.z && z < inner_texels.max.z) {
        inner_min = std::min(std::max(min_x, inner_texels.min.x), max_x);
        inner_max = std::max(std::min(max_x, inner_texels.max.x), inner_min);
        const auto per_m = static_cast<float>(settings.code_quantum_m / settings.spacing_m);
        const auto inner = settings.stencil == SlopeStencil::Fourth ? inner_slopes<true> : inner_slopes<false>;
        if (inner_min < inner_max)
            inner(codes, {inner_min, z}, inner_max - inner_min, per_m, out.x.data() + (inner_min - min_x),
                  out.z.data() + (inner_min - min_x));
    }
    const auto at_border = [&](std::int32_t from, std::int32_t to) {
        for (std::int32_t x = from; x < to; ++x) {
            const Slope slope = slope_at(codes, map, {x, z}, settings);
            out.x[static_cast<std::size_t>(x - min_x)] = slope.x;
            out.z[static_cast<std::size_t>(x - min_x)] = slope.z;
        }
    };
    at_border(min_x, inner_min);
    at_border(inner_max, max_x);
}

void store(const SlopeRow& row, std::uint8_t* __restrict out) {  // companded
    const float* x = row.x.data();
    const float* z = row.z.data();
    const std::size_t count = row.x.size();
    for (std::size_t i = 0; i < count; ++i) {
        const float size = std::sqrt(x[i] * x[i] + z[i] * z[i]);
        out[2 * i] = static_cast<std::uint8_t>(shared::slope_byte(x[i], size));
        out[2 * i + 1] = static_cast<std::uint8_t>(shared::slope_byte(z[i], size));
    }
}

void store(const SlopeRow& row, std::uint16_t* out) {  // half floats
    for (std::size_t i = 0; i < row.x.size(); ++i) {
        out[2 * i] = half_of(row.x[i]);
        out[2 * i + 1] = half_of(row.z[i]);
    }
}

/// Slopes of a rectangle of texels as the map stores them: two components of one or two bytes to a texel.
template <class Component>
void store_rect(const TexelRect& texels, const CodeView& codes, const TexelRect& map, const SlopeSettings& settings,
                Component* out) {
    SlopeRow row;
    for (std::int32_t z = texels.min.z; z < texels.max.z; ++z, out += 2 * static_cast<std::size_t>(texels.width())) {
        slopes_of_row(codes, map, z, texels.min.x, texels.max.x, settings, row);
        store(row, out);
    }
}

/// Those of them that a mip level has: every 2^level-th texel of the slope map. `stored` are the slopes of `from`, both
/// rectangles in texels of their level.
template <class Component>
std::vector<Component> sub_sampled(const std::vector<Component>& stored, const TexelRect& from, const TexelRect& texels,
                                   std::int32_t level) {
    std::vector<Component> out;
    out.reserve(2 * static_cast<std::size_t>(texels.count()));
    for (std::int32_t z = texels.min.z; z < texels.max.z; ++z)
        for (std::int32_t x = texels.min.x; x < texels.max.x; ++x) {
            const std::size_t at =
                2 * (static_cast<std::size_t>((z << level) - from.min.z) * static_cast<std::size_t>(from.width()) +
                     static_cast<std::size_t>((x << level) - from.min.x));
            out.push_back(stored[at]);
            out.push_back(stored[at + 1]);
        }
    return out;
}

template <class Component>
void upload_rect(const TexelRect& stale, const CodeView& codes, const TexelRect& map, const SlopeSettings& settings,
                 SlopeMap& slopes, gl::StageStats& derive, gl::StageStats& mips, gl::TransferStats& transfer) {
    std::vector<Component> stored(2 * static_cast<std::size_t>(stale.count()));
    store_rect(stale, codes, map, settings, stored.data());
    const Texel origin = slopes.origin();
    const TexelRect from{{stale.min.x - origin.x, stale.min.z - origin.z},
                         {stale.max.x - origin.x, stale.max.z - origin.z}};
    for (std::int32_t level = 0; level < slopes.levels(); ++level) {
        const TexelRect texels = mip_texels(from, level);
        if (texels.empty()) continue;
        slopes.texture().upload(level, gl_rect(texels),
                                level == 0 ? stored.data() : sub_sampled(stored, from, texels, level).data());
        const auto moved = 2 * sizeof(Component) * static_cast<std::uint64_t>(texels.count());
        gl::StageStats& stage = level == 0 ? derive : mips;
        stage.texels += static_cast<std::uint64_t>(texels.count());
        stage.bytes += moved;
        transfer.bytes_up += moved;
    }
}

}  // namespace

void store_slopes(const TexelRect& texels, const CodeView& codes, const TexelRect& map, const SlopeSettings& settings,
                  SlopeFormat format, void* out) {
    if (format == SlopeFormat::rg16f)
        store_rect(texels, codes, map, settings, static_cast<std::uint16_t*>(out));
    else
        store_rect(texels, codes, map, settings, static_cast<std::uint8_t*>(out));
}

void upload_slopes(std::span<const TexelRect> changed, const CodeView& codes, const TexelRect& map,
                   const SlopeSettings& settings, SlopeMap& slopes, gl::StageStats& derive, gl::StageStats& mips,
                   gl::TransferStats& transfer) {
    const TexelRect held = intersection(slopes.rect(), map);
    std::vector<TexelRect> stale;
    for (const TexelRect& rect : changed) stale.push_back(stale_slopes(rect, held, map, settings.stencil));
    const auto upload = slopes.format() == SlopeFormat::rg16f ? upload_rect<std::uint16_t> : upload_rect<std::uint8_t>;
    for (const TexelRect& texels : disjoint(stale)) {
        TILTH_EXPECTS(intersection(texels, codes.rect) == texels, "slopes of texels that the view does not cover");
        upload(texels, codes, map, settings, slopes, derive, mips, transfer);
    }
}

}  // namespace tilth
