// Lists of texel rectangles. Pure.
#pragma once

#include <span>
#include <vector>

#include "tilth/world/texel.h"

namespace tilth {

/// Disjoint rectangles that cover the same texels as `rects`, so that nothing is done twice where they overlap.
/// Cost: grows with the square of the number of rectangles that overlap; beyond 256 rectangles their bounds per 64 x 64
/// block are taken instead, which may add texels of those blocks but never lose one.
std::vector<TexelRect> disjoint(std::span<const TexelRect> rects);

/// Appends `rect` without the texels of `hole` to `out`: up to four disjoint rectangles, two if both are of one size.
void subtract(const TexelRect& rect, const TexelRect& hole, std::vector<TexelRect>& out);

}  // namespace tilth
