// Which slopes a change of heights makes stale. Pure.
#pragma once

#include <cstdint>

#include "tilth/world/texel_rects.h"

namespace tilth {

/// Stencil of the slopes: how many posts a slope reads on either side.
enum class SlopeStencil : std::uint8_t {
    Central,  ///< two neighbours on each axis, error h^2 / 6 max|h'''|
    Fourth,   ///< four neighbours on each axis, error h^4 / 30 max|h'''''|
};

/// Posts a slope reads on either side; at the border central differences read one.
constexpr std::int32_t stencil_reach(SlopeStencil stencil) { return stencil == SlopeStencil::Central ? 1 : 2; }

/// The slopes that read a post of `changed`, clipped to the map.
constexpr TexelRect stale_slopes(const TexelRect& changed, const TexelRect& map, SlopeStencil stencil) {
    return changed.empty() ? TexelRect{} : intersection(expanded(changed, stencil_reach(stencil)), map);
}

/// The texels of mip level `level` whose posts (i << level, j << level) lie in `posts`. May be empty.
constexpr TexelRect mip_texels(const TexelRect& posts, std::int32_t level) {
    const auto up = [level](std::int32_t post) { return (post + (1 << level) - 1) >> level; };
    return {{up(posts.min.x), up(posts.min.z)}, {up(posts.max.x), up(posts.max.z)}};
}

}  // namespace tilth
