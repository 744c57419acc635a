// Which texels of a map a region of the world holds.
#pragma once

#include <array>

#include "tilth/world/grid.h"

namespace tilth::demo {

/// The texels whose positions lie inside the rectangle between two corners (in any order), borders included, clipped
/// to the map. A border that misses a texel by a millionth of the spacing still counts: positions are rounded.
TexelRect texels_in(const GridSpec& grid, const std::array<WorldPos, 2>& corners);

}  // namespace tilth::demo
