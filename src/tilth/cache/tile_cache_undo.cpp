// Undo on a map of which only a part is in memory.
#include <algorithm>
#include <utility>

#include "tilth/cache/tile_cache.h"
#include "tilth/ground/before_image.h"

namespace tilth {

TileCache::Task TileCache::undo_task_of(const GroundEdit& edit) const {
    Task task{.stamp = {.edit = edit}};
    for (const StampRecord& record : edit.stroke->records) {
        if (record.map != MapKind::Detail) continue;
        const PreparedStamp stamp = prepare(record, ground_.map(MapKind::Detail), ground_.shapes());
        for_each_tile(tiles_of(grid_, stamp.rect()), [&](TileIndex index) { ++task.undone[index]; });
    }
    return task;
}

/// An `add` whose images, if it needs any, are only known to be needed when it is drawn.
bool TileCache::wants_images(const Stamp& stamp) const {
    return stamp.edit.stroke != nullptr && !stamp.edit.stroke->forgotten && stamp.prepared.rule() == StampRule::Add;
}

/// What undoing a stamp will need of one tile, before it is applied there.
void TileCache::keep_images_of(const Stamp& stamp, TileIndex index, gl::StageStats& deform) {
    const Stroke& stroke = *stamp.edit.stroke;
    const TexelRect clip = intersection(grid_.inside(index), stamp.prepared.rect());
    if (stroke.forgotten || clip.empty()) return;
    Tile& tile = *find(index);
    if (!tile.hot) return;  // when it arrives: of its guests only the apron's texels are sure to be right
    if (on_gpu(tile)) {
        if (stamp.prepared.rule() == StampRule::Add) return;  // `flush_gpu` knows the bounds
        bool is_behind = false;
        for_each_page(pages_of(clip), [&](PageIndex page) {
            is_behind = is_behind ||
                        (!stroke.detail.contains(page) && (tile.newer.contains(page) || tile.reading.contains(page)));
        });
        if (is_behind) {
            flush_gpu(deform);
            read_back_now(index, tile);
            ++deform.fallbacks;
        }
    }
    keep_images(stamp.edit, stamp.prepared, clip, field_, ground_.map(MapKind::Detail), ground_.shapes());
}

/// The same for an `add` on the GPU, just before it is drawn.
void TileCache::keep_saturating_images(const Stamp& stamp, gl::StageStats& deform) {
    for (const TileIndex index : gpu_tiles_) {
        const TexelRect clip = intersection(grid_.inside(index), stamp.prepared.rect());
        if (clip.empty()) continue;
        Tile& tile = *find(index);
        const std::set<PageIndex> newer = tile.newer;
        if (!newer.empty() || !tile.reading.empty()) {
            read_back_now(index, tile);
            ++deform.fallbacks;
        }
        tile.newer = newer;  // those that the batch is about to draw are among them
        keep_images(stamp.edit, stamp.prepared, clip, field_, ground_.map(MapKind::Detail), ground_.shapes());
    }
}

/// Whether all of the stroke's `stamps` on this tile still wait for it, and have been seen by nobody.
bool TileCache::waits_with_all(const Stroke& stroke, std::size_t stamps, TileIndex index) const {
    const Tile* tile = find(index);
    bool is_alone = tile != nullptr && !tile->hot && !tile->arriving && !awaited_.contains(index);
    for_each_neighbour(index, [&](TileIndex at) {
        const Tile* neighbour = find(at);
        is_alone = is_alone && (neighbour == nullptr || (!neighbour->hot && !neighbour->arriving));
    });
    return is_alone && stamps == static_cast<std::size_t>(std::count_if(
                                     tile->pending.begin(), tile->pending.end(),
                                     [&](const Stamp& stamp) { return stamp.edit.stroke.get() == &stroke; }));
}

void TileCache::note_undo(const Task& undo) {
    if (!settings_.publish_changes) return;
    for (const StampRecord& record : undo.stamp.edit.stroke->records) {
        if (record.map != MapKind::Detail) continue;
        const TexelRect rect = prepare(record, ground_.map(MapKind::Detail), ground_.shapes()).rect();
        note_change(record, rect, tiles_of(grid_, rect));
    }
}

/// Takes a stroke that nowhere was applied off the lists: nothing has to be loaded for that.
bool TileCache::cancel_waiting(const Task& undo) {
    for (const auto& [index, stamps] : undo.undone)
        if (!waits_with_all(*undo.stamp.edit.stroke, stamps, index)) return false;
    note_undo(undo);
    for (const auto& [index, stamps] : undo.undone) {
        Tile& tile = *find(index);
        pending_ -= std::erase_if(tile.pending,
                                  [&](const Stamp& stamp) { return stamp.edit.stroke == undo.stamp.edit.stroke; });
        tile.was_changed();
    }
    return true;
}

/// All tiles are hot. `add` is taken back by its opposite, then pages are put back that need more than that.
void TileCache::execute_undo(const Task& undo, gl::StageStats& deform) {
    const Stroke& stroke = *undo.stamp.edit.stroke;
    note_undo(undo);
    for (const StampRecord& record : undoing_records(stroke)) {
        if (record.map != MapKind::Detail) continue;
        const Task opposite = task_of({.record = record, .stroke = nullptr});
        if (opposite.window.count() > 0) execute(opposite, deform);
    }
    flush_gpu(deform);
    flush_fills();
    for (const auto& [page, codes] : stroke.detail) {
        const TexelRect rect = intersection(texels_of(page), grid_.map);
        const TileIndex owner = grid_.tile_of(rect.min);
        Tile& tile = touched(owner, true);
        if (!tile.reading.empty()) read_back_now(owner, tile);  // or it would arrive over this
        put_image(field_, page, codes);
        tile.newer.erase(page);
        for_each_tile(tiles_storing(grid_, rect), [&](TileIndex index) {
            if (Tile* const reached = find(index)) refill(index, *reached, rect);
        });
    }
    flush_fills();
}

}  // namespace tilth
