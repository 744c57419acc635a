// Stamps on a map of which only a part is in memory.
#include <algorithm>
#include <utility>

#include "tilth/cache/page_runs.h"
#include "tilth/cache/tile_cache.h"
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

TileCache::Task TileCache::task_of(const StampRecord& record) const {
    Task task{.prepared = prepare(record, ground_.map(MapKind::Detail), ground_.shapes())};
    const TexelRect rect = task.prepared.rect();
    if (!rect.empty())
        task.window = tiles_storing(grid_, task.prepared.reads_own_texel_only() ? rect : expanded(rect, 1));
    return task;
}

Result<void> TileCache::stamp(std::span<const StampRecord> records, gl::StageStats& deform) {
    gpu_outcome_ = {};
    const auto run_or_wait = [&](const Task& task) {
        if (!must_wait(task)) {
            if (task.prepared.reads_own_texel_only()) return execute(task, deform);
            if (execute_smooth(task, deform)) return;
        }
        for_each_tile(task.window, [&](TileIndex index) { awaited_.insert(index); });
        deferred_.push_back(task);
    };
    awaited_.clear();
    for (std::size_t left = deferred_.size(); left > 0; --left) {
        const Task task = deferred_.front();
        deferred_.pop_front();
        run_or_wait(task);
    }
    for (const StampRecord& record : records) {
        const Task task = task_of(record);
        if (!task.prepared.rect().empty()) run_or_wait(task);
    }
    flush_gpu(deform);
    flush_fills();
    return gpu_outcome_;
}

bool TileCache::must_wait(const Task& task) {
    if (any_of(task.window, [&](TileIndex index) { return awaited_.contains(index); })) return true;
    return !task.prepared.reads_own_texel_only() && !smooth_is_ready(task);
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
    if (is_first || inside) tile.modified = tile.changed = true;
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
    const TexelRect rect = task.prepared.rect();
    const auto part = [&](TileIndex index) { return intersection(grid_.inside(index), rect); };
    // All tiles first: one that becomes hot makes guests of its neighbours' pages.
    for_each_tile(task.window, [&](TileIndex index) { touched(index, !part(index).empty()); });
    bool drawn = false;
    for_each_tile(task.window, [&](TileIndex index) {
        const TexelRect inside = part(index);
        Tile& tile = *find(index);
        if (!tile.hot) {
            if (inside.empty()) return;
            tile.pending.push_back(task.prepared);
            if (tile.pending.size() >= settings_.most_pending) crowded_.insert(index);
            apply_to_guests(task.prepared, index);
        } else if (on_gpu(tile)) {
            drawn = true;
            gpu_tiles_.insert(index);
            add_pages(tile.newer, inside);
        } else if (!inside.empty()) {
            count(deform, apply_stamp(task.prepared, field_, inside));
        }
    });
    if (drawn) gpu_batch_.push_back(task.prepared);
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
    bool all_on_gpu = true;
    for_each_tile(task.window, [&](TileIndex index) {
        Tile& tile = touched(index, true);
        if (!tile.hot) make_fresh(index, tile);  // untouched, and no viewer near
        all_on_gpu = all_on_gpu && on_gpu(tile);
    });
    if (!all_on_gpu) {
        if (!smooth_is_ready(task)) return false;  // a tile got no textures: the others are read back first
        smooth_on_cpu(task, deform);
        return true;
    }
    std::vector<TileIndex> tiles;
    for_each_tile(task.window, [&](TileIndex index) { tiles.push_back(index); });
    std::size_t applied = 0;
    const PreparedStamp stamps[] = {task.prepared};
    const Result<void> drawn = textures_.stamp(stamps, tiles, applied);
    if (!drawn && applied == 0) {
        gpu_outcome_ = drawn.error();
        ++deform.fallbacks;
        smooth_on_cpu(task, deform);
        return true;
    }
    const TexelRect rect = task.prepared.rect();
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
    count(deform, apply_stamp(task.prepared, field_, grid_.map));
    for_each_tile(task.window, [&](TileIndex index) { refill(index, *find(index), task.prepared.rect()); });
    flush_fills();  // before anything is drawn over it
}

// ---- the gpu executor ----

void TileCache::flush_gpu(gl::StageStats& deform) {
    if (gpu_batch_.empty()) return;
    const std::vector<TileIndex> tiles(gpu_tiles_.begin(), gpu_tiles_.end());
    std::size_t applied = 0;
    const Result<void> drawn = textures_.stamp(gpu_batch_, tiles, applied);
    if (!drawn) {
        gpu_outcome_ = drawn.error();
        deform.fallbacks += gpu_batch_.size() - applied;
        apply_batch_on_cpu(applied, deform);
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
        for (std::size_t i = first; i < gpu_batch_.size(); ++i)
            count(deform, apply_stamp(gpu_batch_[i], field_, inside));
    }
    for (const TileIndex index : gpu_tiles_)
        for (std::size_t i = first; i < gpu_batch_.size(); ++i) refill(index, *find(index), gpu_batch_[i].rect());
    flush_fills();
}

}  // namespace tilth
