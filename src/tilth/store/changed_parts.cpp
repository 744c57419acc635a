#include "tilth/store/changed_parts.h"

#include <memory>
#include <utility>

#include "tilth/ground/apply_edit.h"
#include "tilth/ground/before_image.h"

namespace tilth {

void ChangedParts::note(const Ground& ground, const GroundEdit& edit) {
    const bool is_stamp = edit.kind == GroundEdit::Kind::Stamp;
    if (is_stamp && edit.record.map == MapKind::Detail && !follows_tiles_) return;
    const TileGrid grid{.size = ground.settings().tile_size, .map = ground.map(MapKind::Detail).grid.rect()};
    for (const ChangedRect& changed : changed_by(ground, edit)) {
        if (changed.map == MapKind::Coarse)
            for_each_page(pages_of(changed.rect), [&](PageIndex page) { coarse_.insert(page); });
        else if (follows_tiles_)
            for_each_tile(tiles_of(grid, changed.rect), [&](TileIndex tile) { tiles_.insert(tile); });
    }
}

void ChangedParts::take_coarse(const Ground& ground, Snapshot& snapshot) {
    for (const PageIndex page : std::exchange(coarse_, {}))
        snapshot.coarse.push_back({page, std::make_shared<PageCodes>(page_of_field(ground.coarse(), page))});
}

void ChangedParts::take_tiles(const Ground& ground, Snapshot& snapshot) {
    const TileGrid grid{.size = ground.settings().tile_size};
    for (const TileIndex tile : std::exchange(tiles_, {}))
        snapshot.tiles.push_back({.tile = tile,
                                  .has_codes = true,
                                  .pages = ground.detail().pages_in(pages_of(grid.interior(tile))),
                                  .waiting = {}});
}

void ChangedParts::put_back(const Snapshot& snapshot) {
    for (const Page& page : snapshot.coarse) coarse_.insert(page.index);
    if (!follows_tiles_) return;
    for (const TileSnapshot& tile : snapshot.tiles) tiles_.insert(tile.tile);
}

}  // namespace tilth
