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
    const int shift = std::max(exponent, -13);                        // the half's unit in the last place is 2^(shift - 11)
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
    return {shared::slope_along(fourth ? along_x(-2) : 0, along_x(-1), along_x(1), fourth ? along_x(2) : 0, post.x, last_x, fourth, per_m),
            shared::slope_along(fourth ? along_z(-2) : 0, along_z(-1), along_z(1), fourth ? along_z(2) : 0, post.z, last_z, fourth, per_m)};
}

void upload_slopes(std::span<const TexelRect> changed, const HeightField& heights, const SlopeSettings& settings,
                   SlopeMap& slopes, gl::StageStats& derive, gl::StageStats& mips, gl::TransferStats& transfer) {
    std::vector<TexelRect> stale;
    for (const TexelRect& rect : changed) stale.push_back(stale_slopes(rect, heights.rect(), settings.stencil));
    std::vector<std::uint8_t> bytes;
    std::vector<std::uint16_t> halves;
    for (const TexelRect& posts : disjoint(stale)) {
        for (std::int32_t level = 0; level < SlopeMap::kLevels; ++level) {
            const TexelRect texels = mip_texels(posts, level);
            if (texels.empty()) continue;
            bytes.clear();
            halves.clear();
            for (std::int32_t z = texels.min.z; z < texels.max.z; ++z)
                for (std::int32_t x = texels.min.x; x < texels.max.x; ++x) {
                    const Slope slope = slope_at(heights, {x << level, z << level}, settings);
                    if (slopes.format() == SlopeFormat::rg16f) {
                        halves.push_back(half_of(slope.x));
                        halves.push_back(half_of(slope.z));
                        continue;
                    }
                    const float size = std::sqrt(slope.x * slope.x + slope.z * slope.z);
                    bytes.push_back(static_cast<std::uint8_t>(shared::slope_byte(slope.x, size)));
                    bytes.push_back(static_cast<std::uint8_t>(shared::slope_byte(slope.z, size)));
                }
            const bool half = slopes.format() == SlopeFormat::rg16f;
            slopes.texture().upload(level, gl_rect(texels), half ? static_cast<const void*>(halves.data()) : bytes.data());
            const std::uint64_t moved = half ? halves.size() * sizeof(std::uint16_t) : bytes.size();
            gl::StageStats& stage = level == 0 ? derive : mips;
            stage.texels += static_cast<std::uint64_t>(texels.count());
            stage.bytes += moved;
            transfer.bytes_up += moved;
        }
    }
}

}  // namespace tilth
