#include "tilth/store/restore_detail.h"

#include <utility>
#include <vector>

#include "tilth/ground/before_image.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {

Result<std::set<TileIndex>> restore_detail(WorldFolder& world, const RecoveredWorld& recovered,
                                           const UndoHistory& history, Ground& ground) {
    const MapGeometry& map = ground.map(MapKind::Detail);
    const TileGrid grid{.size = ground.settings().tile_size, .map = map.grid.rect()};
    const Result<std::vector<TileIndex>> tiles = world.tiles();
    if (!tiles) return tiles.error();
    for (const TileIndex tile : *tiles) {
        if (!grid.exists(tile)) continue;
        Result<std::vector<Page>> pages = world.load(tile, pages_of(grid.interior(tile)));
        if (!pages) return pages.error();
        for (Page& page : *pages) ground.mutable_detail().put(std::move(page));
    }
    std::set<TileIndex> changed;
    for (const auto& [tile, stamps] : recovered.waiting) {
        if (!grid.exists(tile)) continue;
        for (const WaitingStamp& stamp : stamps) {
            if (const Result<void> accepted = ground.accept(stamp.record); !accepted) return accepted.error();
            const PreparedStamp prepared = prepare(stamp.record, map, ground.shapes());
            keep_images(edit_of(stamp, history), prepared, grid.inside(tile), ground.detail(), map, ground.shapes());
            apply_stamp(prepared, ground.mutable_detail(), grid.inside(tile));
        }
        changed.insert(tile);
    }
    return changed;
}

}  // namespace tilth
