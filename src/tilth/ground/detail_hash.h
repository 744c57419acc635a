// The detail map's part of the state hash, tile by tile.
#pragma once

#include <span>
#include <vector>

#include "tilth/core/hash.h"
#include "tilth/ground/page.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// Adds the pages of one tile that are not all zero code (2^31), in the order of (page z, page x), each as its four
/// indices (tile z, tile x, page z, page x; 64 bits, pages counted within the tile) and its codes. The hash of a map is
/// that of its tiles in the order of (tile z, tile x). `pages` may come in any order.
void add_tile_to_hash(StateHasher& hasher, TileIndex tile, std::int32_t tile_size, std::vector<Page> pages);

}  // namespace tilth
