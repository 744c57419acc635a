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

Slope slope_at(const HeightField& heights, Texel post, const SlopeSettings& settings) {
    const std::int32_t last_x = heights.width() - 1, last_z = heights.depth() - 1;
    const bool fourth = settings.stencil == SlopeStencil::Fourth;
    const auto per_m = static_cast<float>(settings.code_quantum_m / settings.spacing_m);
    const std::uint32_t* row = heights.row(post.z);
    const auto along_x = [&](std::int32_t step) { return row[std::clamp(post.x + step, 0, last_x)]; };
    const auto along_z = [&](std::int32_t step) { return heights.row(std::clamp(post.z + step, 0, last_z))[post.x]; };
    return {shared::slope_along(along_x(-2), along_x(-1), along_x(1), along_x(2), post.x, last_x, fourth, per_m),
            shared::slope_along(along_z(-2), along_z(-1), along_z(1), along_z(2), post.z, last_z, fourth, per_m)};
}

namespace {

/// Slopes of a run of posts of one row, x and z components apart.
struct SlopeRow {
    std::vector<float> x, z;
};

/// The run's posts whose whole stencil lies in the map: the loop that the compiler vectorises.
template <bool Fourth>
void inner_slopes(const HeightField& heights, Texel first, std::int32_t count, float per_m, float* __restrict out_x,
                  float* __restrict out_z) {
    constexpr std::int32_t kReach = Fourth ? 2 : 1;
    const std::uint32_t* here = heights.row(first.z) + first.x;
    const std::uint32_t* before = heights.row(first.z - 1) + first.x;
    const std::uint32_t* after = heights.row(first.z + 1) + first.x;
    const std::uint32_t* before2 = heights.row(first.z - kReach) + first.x;
    const std::uint32_t* after2 = heights.row(first.z + kReach) + first.x;
    for (std::int32_t i = 0; i < count; ++i) {
        out_x[i] = shared::slope_along(here[i - kReach], here[i - 1], here[i + 1], here[i + kReach], kReach, 2 * kReach,
                                       Fourth, per_m);
        out_z[i] = shared::slope_along(before2[i], before[i], after[i], after2[i], kReach, 2 * kReach, Fourth, per_m);
    }
}

/// Slopes of the posts [min_x, max_x) of row `z`.
void slopes_of_row(const HeightField& heights, std::int32_t z, std::int32_t min_x, std::int32_t max_x,
                   const SlopeSettings& settings, SlopeRow& out) {
    out.x.resize(static_cast<std::size_t>(max_x - min_x));
    out.z.resize(out.x.size());
    const std::int32_t reach = stencil_reach(settings.stencil);
    std::int32_t inner_min = max_x, inner_max = max_x;
    if (z >= reach && z < heights.depth() - reach) {
        inner_min = std::min(std::max(min_x, reach), max_x);
        inner_max = std::max(std::min(max_x, heights.width() - reach), inner_min);
        const auto per_m = static_cast<float>(settings.code_quantum_m / settings.spacing_m);
        const auto inner = settings.stencil == SlopeStencil::Fourth ? inner_slopes<true> : inner_slopes<false>;
        inner(heights, {inner_min, z}, inner_max - inner_min, per_m, out.x.data() + (inner_min - min_x),
              out.z.data() + (inner_min - min_x));
    }
    const auto at_border = [&](std::int32_t from, std::int32_t to) {
        for (std::int32_t x = from; x < to; ++x) {
            const Slope slope = slope_at(heights, {x, z}, settings);
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

/// Slopes of a rectangle of posts as the map stores them: two components of one or two bytes to a post.
template <class Component>
std::vector<Component> stored_slopes(const TexelRect& posts, const HeightField& heights,
                                     const SlopeSettings& settings) {
    const std::size_t row_components = 2 * static_cast<std::size_t>(posts.width());
    std::vector<Component> stored(row_components * static_cast<std::size_t>(posts.depth()));
    SlopeRow row;
    for (std::int32_t z = posts.min.z; z < posts.max.z; ++z) {
        slopes_of_row(heights, z, posts.min.x, posts.max.x, settings, row);
        store(row, stored.data() + static_cast<std::size_t>(z - posts.min.z) * row_components);
    }
    return stored;
}

/// Those of them that a mip level has: every 2^level-th post of the map.
template <class Component>
std::vector<Component> sub_sampled(const std::vector<Component>& stored, const TexelRect& posts,
                                   const TexelRect& texels, std::int32_t level) {
    std::vector<Component> out;
    out.reserve(2 * static_cast<std::size_t>(texels.count()));
    for (std::int32_t z = texels.min.z; z < texels.max.z; ++z)
        for (std::int32_t x = texels.min.x; x < texels.max.x; ++x) {
            const std::size_t at =
                2 * (static_cast<std::size_t>((z << level) - posts.min.z) * static_cast<std::size_t>(posts.width()) +
                     static_cast<std::size_t>((x << level) - posts.min.x));
            out.push_back(stored[at]);
            out.push_back(stored[at + 1]);
        }
    return out;
}

template <class Component>
void upload_rect(const TexelRect& posts, const HeightField& heights, const SlopeSettings& settings, SlopeMap& slopes,
                 gl::StageStats& derive, gl::StageStats& mips, gl::TransferStats& transfer) {
    const std::vector<Component> stored = stored_slopes<Component>(posts, heights, settings);
    for (std::int32_t level = 0; level < SlopeMap::kLevels; ++level) {
        const TexelRect texels = mip_texels(posts, level);
        if (texels.empty()) continue;
        slopes.texture().upload(level, gl_rect(texels),
                                level == 0 ? stored.data() : sub_sampled(stored, posts, texels, level).data());
        const auto moved = 2 * sizeof(Component) * static_cast<std::uint64_t>(texels.count());
        gl::StageStats& stage = level == 0 ? derive : mips;
        stage.texels += static_cast<std::uint64_t>(texels.count());
        stage.bytes += moved;
        transfer.bytes_up += moved;
    }
}

}  // namespace

void upload_slopes(std::span<const TexelRect> changed, const HeightField& heights, const SlopeSettings& settings,
                   SlopeMap& slopes, gl::StageStats& derive, gl::StageStats& mips, gl::TransferStats& transfer) {
    std::vector<TexelRect> stale;
    for (const TexelRect& rect : changed) stale.push_back(stale_slopes(rect, heights.rect(), settings.stencil));
    const auto upload = slopes.format() == SlopeFormat::rg16f ? upload_rect<std::uint16_t> : upload_rect<std::uint8_t>;
    for (const TexelRect& posts : disjoint(stale)) upload(posts, heights, settings, slopes, derive, mips, transfer);
}

}  // namespace tilth
