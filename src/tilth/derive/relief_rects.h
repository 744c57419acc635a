// Which texels of a window that follows the viewer are stale, and where they lie in its textures. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tilth/world/texel.h"

namespace tilth {

/// The square of map texels that a window of `size` texels shows for an eye at `texel`: its corner is a multiple of
/// `step`, the eye within half a step of its middle. It may reach beyond the map.
TexelRect relief_square(Texel texel, std::int32_t size, std::int32_t step);

/// What of `now` is not in `before` (same size): at most two disjoint rectangles; all of `now` where they do not meet.
std::vector<TexelRect> newly_covered(const TexelRect& before, const TexelRect& now);

/// Cuts `rect` (map texels, no side longer than `size`) at the multiples of `size`: each part is one rectangle of the
/// texture, whose texel is the map's modulo `size`. At most four.
struct WrappedPart {
    TexelRect map;
    Texel at;  ///< in the texture, of map.min
};
std::vector<WrappedPart> wrapped_parts(const TexelRect& rect, std::int32_t size);

/// Nodes of `2^(level + 1)` cells a side whose range reads a texel of `changed` (nodes include the texels on all four
/// of their sides): map nodes, half-open, as a texel rectangle of the pyramid's level.
TexelRect stale_nodes(const TexelRect& changed, std::int32_t level);

/// Where `rects` lie in a texture of `size` texels a side that repeats: disjoint rectangles of the texture. A side
/// longer than `size` is the whole texture.
std::vector<TexelRect> wrapped_rects(std::span<const TexelRect> rects, std::int32_t size);

/// Takes what of the disjoint `rest` lies in `of` out of it and returns it; `rest` stays disjoint.
std::vector<TexelRect> taken(std::vector<TexelRect>& rest, const TexelRect& of);

}  // namespace tilth
