// Stamps on a map of which only a part is in memory.
#include <algorithm>
#include <utility>

#include "tilth/cache/page_runs.h"
#include "tilth/cache/tile_cache.h"
#include "tilth/ground/before_image.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/world/texel_rects.h"

namespace tilth {
namespace {

template <class Condition>
bool any_of(const TileWindow& window, const Condition& condition) {
    bool found = false;
    for_each_tile(window, [&](TileIndex index) { found = found || condition(index); });
    return found;
}

void count(gl::StageStats& deform, const ApplyResult& result) {
    deform.texels += result.texels;
    deform.saturated += result.saturated;
}

}  // namespace

TileCache::Task TileCache::task_of(const GroundEdit& edit) const {
    if (edit.kind == GroundEdit::Kind::Undo) return undo_task_of(edit);
    Task task{.stamp = {edit, prepare(edit.record, ground_.map(MapKind::Detail), ground_.shapes())}};
    const PreparedStamp& stamp = task.stamp.prepared;
    if (!stamp.rect().empty())
        task.window = tiles_storing(grid_, stamp.reads_own_texel_only() ? stamp.rect() : expanded(stamp.rect(), 1));
    return task;
}

/// Calls `visit(index)` for each tile that a task waits for.
template <class Visit>
void TileCache::for_each_tile_of(const Task& task, const Visit& visit) const {
    for (const auto& [index, stamps] : task.undone) visit(index);
    for_each_tile(task.window, visit);
}

Result<void> TileCache::apply(std::span<const GroundEdit> edits, gl::StageStats& deform) {
    gpu_outcome_ = {};
    awaited_.clear();
    for (std::size_t left = deferred_.size(); left > 0; --left) {
        Task task = std::move(deferred_.front());
        deferred_.pop_front();
        run_or_wait(std::move(task), deform);
    }
    for (const GroundEdit& edit : edits) {
        Task task = task_of(edit);
        if (!task.undone.empty() || task.window.count() > 0) run_or_wait(std::move(task), deform);
    }
    flush_gpu(deform);
    flush_fills();
    if (settings_.publish_changes)
        changes_.finish(MapKind::Detail, [&](const Change& change) { return range_now(change.tile, change.rect); });
    return gpu_outcome_;
}

CodeRange TileCache::range_now(TileIndex index, const TexelRect& rect) const {
    const Tile* tile = find(index);
    if (tile == nullptr) return {kMidCode, kMidCode};
    if (!tile->hot) return kAllCodes;
    return on_gpu(*tile) ? textures_.bounds(index, rect) : range_in(field_, rect);
}

/// Before a stamp is applied to `rect`, or taken back there.
void TileCache::note_change(const StampRecord& record, const TexelRect& rect, const TileWindow& window) {
    if (!settings_.publish_changes) return;
    for_each_tile(window, [&](TileIndex index) {
        const TexelRect part = intersection(grid_.inside(index), rect);
        if (!part.empty())
            changes_.note(MapKind::Detail, index, part, range_now(index, part), record.sequence, record.sequence);
    });
}

void TileCache::run_or_wait(Task task, gl::StageStats& deform) {
    const bool is_undo = task.stamp.edit.kind == GroundEdit::Kind::Undo;
    if (!must_wait(task)) {
        if (is_undo) return execute_undo(task, deform);
        if (task.stamp.prepared.reads_own_texel_only()) return execute(task, deform);
        if (execute_smooth(task, deform)) return;
    } else if (is_undo && cancel_waiting(task)) {
        return;
    }
    for_each_tile_of(task, [&](TileIndex index) { awaited_.insert(index); });
    deferred_.push_back(std::move(task));
}

bool TileCache::must_wait(const Task& task) {
    bool waits = false;
    const bool is_undo = task.stamp.edit.kind == GroundEdit::Kind::Undo;
    for_each_tile_of(task, [&](TileIndex index) {
        const Tile* tile = is_undo ? find(index) : nullptr;
        waits = waits || awaited_.contains(index) || (tile != nullptr && !tile->hot);
    });
    return waits || (!is_undo && !task.stamp.prepared.reads_own_texel_only() && !smooth_is_ready(task));
}

/// Every tile that it reads or changes is hot, or was never touched; and all are ahead on the GPU, or none is.
bool TileCache::smooth_is_ready(const Task& task) {
    if (any_of(task.window, [&](TileIndex index) {
            const Tile* tile = find(index);
            return tile != nullptr && !tile->hot;
        }))
        return false;
    if (!any_of(task.window, [&](TileIndex index) {
            const Tile* tile = find(index);
            return tile == nullptr ? interest(index) == Interest::None : !on_gpu(*tile);
        }))
        return true;
    bool ready = true;
    for_each_tile(task.window, [&](TileIndex index) {
        Tile* tile = find(index);
        if (tile == nullptr || !on_gpu(*tile)) return;
        if (gpu_tiles_.contains(index) || !tile->newer.empty() || !tile->reading.empty()) ready = false;
        if (!gpu_tiles_.contains(index)) begin_read_back(index, *tile);
    });
    return ready;
}

/// The tile's entry, made if no stamp had ever reached it: then it is hot at once where a viewer is near.
TileCache::Tile& TileCache::touched(TileIndex index, bool inside) {
    const auto [found, inserted] = tiles_.try_emplace(index);
    Tile& tile = found->second;
    const bool is_new = inserted || tile.clean, is_first = is_new || tile.suspected;
    tile.clean = tile.suspected = false;
    if (is_new && interest(index) != Interest::None) make_fresh(index, tile);
    if (is_first || inside) tile.was_changed();
    return tile;
}

/// Hot without a load: neither it nor its apron ever held anything.
void TileCache::make_fresh(TileIndex index, Tile& tile) {
    tile.hot = true;
    tile.state = TileState::Uploading;
    live_.insert(index);
    // Where another must make way first, `transfer` sees to it: stamps of this frame may be on their way to that one.
    gl::CacheStats none;
    if (interest(index) < Interest::Loaded || is_full() || !acquire(index, tile, none)) return;
    tile.to_fill.clear();
    tile.current = true;
    tile.state = TileState::Resident;
}

void TileCache::execute(const Task& task, gl::StageStats& deform) {
    const PreparedStamp& stamp = task.stamp.prepared;
    const TexelRect rect = stamp.rect();
    const auto part = [&](TileIndex index) { return intersection(grid_.inside(index), rect); };
    note_change(task.stamp.edit.record, rect, task.window);
    // All tiles first: one that becomes hot makes guests of its neighbours' pages.
    for_each_tile(task.window, [&](TileIndex index) { touched(index, !part(index).empty()); });
    if (task.stamp.edit.stroke != nullptr)
        for_each_tile(task.window, [&](TileIndex index) { keep_images_of(task.stamp, index, deform); });
    bool drawn = false;
    for_each_tile(task.window, [&](TileIndex index) {
        const TexelRect inside = part(index);
        Tile& tile = *find(index);
        if (!tile.hot) {
            if (inside.empty()) return;
            tile.pending.push_back(task.stamp);
            ++pending_;
            if (tile.pending.size() >= settings_.most_pending) crowded_.insert(index);
            apply_to_guests(stamp, index);
        } else if (on_gpu(tile)) {
            drawn = true;
            gpu_tiles_.insert(index);
            add_pages(tile.newer, inside);
        } else if (!inside.empty()) {
            count(deform, apply_stamp(stamp, field_, inside));
        }
    });
    if (drawn) gpu_batch_.push_back(task.stamp);
    for_each_tile(task.window, [&](TileIndex index) {
        Tile& tile = *find(index);
        if (!on_gpu(tile)) refill(index, tile, rect);
    });
}

void TileCache::apply_to_guests(const PreparedStamp& stamp, TileIndex cold) {
    if (!any_of({{cold.x - 1, cold.z - 1}, {cold.x + 1, cold.z + 1}}, [&](TileIndex index) { return is_hot(index); }))
        return;
    const TexelRect inside = intersection(grid_.inside(cold), stamp.rect());
    for_each_page(pages_of(inside), [&](PageIndex page) {
        if (is_hot(page)) apply_stamp(stamp, field_, intersection(texels_of(page), inside));
    });
}

/// The field has new codes in `rect`, which the tile's textures lack.
void TileCache::refill(TileIndex index, Tile& tile, const TexelRect& rect) {
    if (!tile.has_textures) return;
    const TexelRect stored = intersection(rect, grid_.stored(index));
    if (stored.empty()) return;
    if (tile.current)
        fills_[index].push_back(stored);
    else
        add_pages(tile.to_fill, stored);
}

void TileCache::flush_fills() {
    for (const auto& [index, rects] : fills_)
        for (const TexelRect& rect : disjoint(rects)) textures_.fill(index, rect, field_, false);
    fills_.clear();
}

// ---- smooth ----

/// False when it has to wait after all.
bool TileCache::execute_smooth(const Task& task, gl::StageStats& deform) {
    // Nothing lies there: nothing changes.
    if (!any_of(task.window, [&](TileIndex index) { return find(index) != nullptr; })) return true;
    flush_gpu(deform);
    const PreparedStamp& stamp = task.stamp.prepared;
    bool all_on_gpu = true;
    for_each_tile(task.window, [&](TileIndex index) {
        Tile& tile = touched(index, true);
        if (!tile.hot) make_fresh(index, tile);  // untouched, and no viewer near
        all_on_gpu = all_on_gpu && on_gpu(tile);
    });
    if (!all_on_gpu && !smooth_is_ready(task)) return false;  // a tile got no textures: the others are read back first
    note_change(task.stamp.edit.record, stamp.rect(), task.window);
    if (task.stamp.edit.stroke != nullptr)
        for_each_tile(task.window, [&](TileIndex index) { keep_images_of(task.stamp, index, deform); });
    if (!all_on_gpu) {
        smooth_on_cpu(task, deform);
        return true;
    }
    std::vector<TileIndex> tiles;
    for_each_tile(task.window, [&](TileIndex index) { tiles.push_back(index); });
    std::size_t applied = 0;
    const PreparedStamp stamps[] = {stamp};
    const Result<void> drawn = textures_.stamp(stamps, tiles, applied);
    if (!drawn && applied == 0) {
        gpu_outcome_ = drawn.error();
        ++deform.fallbacks;
        smooth_on_cpu(task, deform);
        return true;
    }
    const TexelRect rect = stamp.rect();
    for (const TileIndex to : tiles)
        for (const TileIndex from : tiles) {
            const TexelRect shared = intersection(intersection(rect, grid_.interior(from)), grid_.stored(to));
            if (from != to && !shared.empty()) textures_.exchange(from, to, shared);
        }
    for (const TileIndex index : tiles) add_pages(find(index)->newer, intersection(rect, grid_.inside(index)));
    return true;
}

void TileCache::smooth_on_cpu(const Task& task, gl::StageStats& deform) {
    for_each_tile(task.window, [&](TileIndex index) {
        Tile& tile = *find(index);
        if (!tile.newer.empty() || !tile.reading.empty()) read_back_now(index, tile);  // after a failed pass only
    });
    const PreparedStamp& stamp = task.stamp.prepared;
    count(deform, apply_stamp(stamp, field_, grid_.map));
    for_each_tile(task.window, [&](TileIndex index) { refill(index, *find(index), stamp.rect()); });
    flush_fills();  // before anything is drawn over it
}

// ---- the gpu executor ----

/// Draws the batch; where a stamp may saturate whose undo would need images then, in parts.
void TileCache::flush_gpu(gl::StageStats& deform) {
    const std::vector<TileIndex> tiles(gpu_tiles_.begin(), gpu_tiles_.end());
    std::vector<PreparedStamp> stamps;
    for (const Stamp& stamp : gpu_batch_) stamps.push_back(stamp.prepared);
    for (std::size_t done = 0; done < stamps.size();) {
        std::size_t end = stamps.size();
        if (std::any_of(gpu_batch_.begin() + static_cast<std::ptrdiff_t>(done), gpu_batch_.end(),
                        [&](const Stamp& stamp) { return wants_images(stamp); })) {
            const std::size_t first = done + textures_.first_that_may_saturate(std::span(stamps).subspan(done), tiles);
            if (first > done && first < end && wants_images(gpu_batch_[first])) {
                end = first;
            } else if (first < end) {
                if (wants_images(gpu_batch_[first])) keep_saturating_images(gpu_batch_[first], deform);
                end = first + 1;
            }
        }
        std::size_t applied = 0;
        const Result<void> drawn = textures_.stamp(std::span(stamps).subspan(done, end - done), tiles, applied);
        done += applied;
        if (!drawn) {
            gpu_outcome_ = drawn.error();
            deform.fallbacks += stamps.size() - done;
            apply_batch_on_cpu(done, deform);
            break;
        }
    }
    gpu_batch_.clear();
    gpu_tiles_.clear();
}

/// What the GPU refused: its tiles are read back, stamped here and filled again.
void TileCache::apply_batch_on_cpu(std::size_t first, gl::StageStats& deform) {
    for (const TileIndex index : gpu_tiles_) {
        Tile& tile = *find(index);
        read_back_now(index, tile);
        const TexelRect inside = grid_.inside(index);
        for (std::size_t i = first; i < gpu_batch_.size(); ++i) {
            const Stamp& stamp = gpu_batch_[i];
            keep_images(stamp.edit, stamp.prepared, inside, field_, ground_.map(MapKind::Detail), ground_.shapes());
            count(deform, apply_stamp(stamp.prepared, field_, inside));
        }
    }
    for (const TileIndex index : gpu_tiles_)
        for (std::size_t i = first; i < gpu_batch_.size(); ++i)
            refill(index, *find(index), gpu_batch_[i].prepared.rect());
    flush_fills();
}

}  // namespace tilth
