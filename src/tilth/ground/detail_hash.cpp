#include "tilth/ground/detail_hash.h"

#include <algorithm>

#include "tilth/ground/detail_field.h"

namespace tilth {

void add_tile_to_hash(StateHasher& hasher, TileIndex tile, std::int32_t tile_size, std::vector<Page> pages) {
    std::sort(pages.begin(), pages.end(), [](const Page& a, const Page& b) {
        return a.index.z != b.index.z ? a.index.z < b.index.z : a.index.x < b.index.x;
    });
    const std::int64_t a_side = tile_size / kPageTexels;
    for (const Page& page : pages) {
        if (is_untouched(*page.codes)) continue;
        hasher.add_i64(tile.z);
        hasher.add_i64(tile.x);
        hasher.add_i64(page.index.z - tile.z * a_side);
        hasher.add_i64(page.index.x - tile.x * a_side);
        hasher.add_u32(*page.codes);
    }
}

}  // namespace tilth
