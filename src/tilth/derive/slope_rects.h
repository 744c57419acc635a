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

/// The texels whose slopes follow from the codes of `held`, a part of `map`: those whose stencil stays in it, or leaves
/// the map. Of a tile with an apron of `stencil_reach` + 1: the interior and one texel around it.
constexpr TexelRect derivable_slopes(const TexelRect& held, const TexelRect& map, SlopeStencil stencil) {
    const std::int32_t reach = stencil_reach(stencil);
    return {{held.min.x == map.min.x ? held.min.x : held.min.x + reach,
             held.min.z == map.min.z ? held.min.z : held.min.z + reach},
            {held.max.x == map.max.x ? held.max.x : held.max.x - reach,
             held.max.z == map.max.z ? held.max.z : held.max.z - reach}};
}

/// The slopes of a tile that holds `held` and that a change of `changed` makes stale.
constexpr TexelRect stale_slopes(const TexelRect& changed, const TexelRect& held, const TexelRect& map,
                                 SlopeStencil stencil) {
    return intersection(stale_slopes(intersection(changed, held), held, stencil), derivable_slopes(held, map, stencil));
}

/// The texels of mip level `level` whose posts (i << level, j << level) lie in `posts`. May be empty.
constexpr TexelRect mip_texels(const TexelRect& posts, std::int32_t level) {
    const auto up = [level](std::int32_t post) { return (post + (1 << level) - 1) >> level; };
    return {{up(posts.min.x), up(posts.min.z)}, {up(posts.max.x), up(posts.max.z)}};
}

}  // namespace tilth
