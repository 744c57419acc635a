// What looks at the whole ground, outside frames: it may wait.
#include <algorithm>
#include <functional>
#include <limits>

#include "tilth/cache/page_runs.h"
#include "tilth/cache/tile_cache.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/detail_hash.h"

namespace tilth {
namespace {

FrameBudget without_limit() {
    BudgetSettings settings;
    settings.frame_target_ms = settings.most_ms = 1e12;
    settings.most_bytes = std::numeric_limits<std::uint64_t>::max();
    FrameBudget budget(settings);
    budget.begin_frame(0);
    return budget;
}

}  // namespace

/// What a frame does, without its budget.
Result<void> TileCache::step(gl::CacheStats& stats, gl::StageStats& deform) {
    update(now_ms_, stats);
    const Result<void> stamped = stamp({}, stats, deform);
    FrameBudget budget = without_limit();
    const std::uint64_t missing = stats.missing_active;
    transfer(budget, stats, deform);
    stats.missing_active = missing;  // of frames alone
    return stamped;
}

/// Goes on until `reached`. Fails with the store's error when one of `tiles` cannot be had.
Result<void> TileCache::wait_until(const std::function<bool()>& reached, const std::set<TileIndex>& tiles,
                                   gl::CacheStats& stats, gl::StageStats& deform) {
    for (auto& [index, tile] : tiles_) tile.retry_at_ms = 0;  // whoever waits asks again at once
    for (int idle = 0; !reached();) {
        if (const Result<void> stepped = step(stats, deform); !stepped) return stepped;
        if (reached()) break;
        for (const TileIndex index : tiles)
            if (const Tile* tile = find(index); tile != nullptr && tile->retry_at_ms > now_ms_) return tile->trouble;
        if (const std::shared_ptr<DiskRequest> done = worker_.wait()) {
            deliver(done, stats);
            idle = 0;
        } else {
            textures_.finish();
            if (++idle > 8) break;  // textures that are not to be had: what is left waits for room
        }
    }
    return {};
}

Result<void> TileCache::settle(gl::CacheStats& stats, gl::StageStats& deform) {
    std::set<TileIndex> wanted(awaited_.begin(), awaited_.end());
    for (const ViewerTiles& viewer : viewers_)
        for (std::int32_t z = viewer.loaded.min.z; z <= viewer.loaded.max.z; ++z)
            for (std::int32_t x = viewer.loaded.min.x; x <= viewer.loaded.max.x; ++x)
                if (find({x, z}) != nullptr) wanted.insert({x, z});
    return wait_until(
        [&] {
            return deferred_.empty() && std::all_of(wanted.begin(), wanted.end(), [&](TileIndex index) {
                       return find(index)->current || interest(index) < Interest::Loaded;
                   });
        },
        wanted, stats, deform);
}

Result<void> TileCache::require(std::span<const TileIndex> tiles, gl::CacheStats& stats, gl::StageStats& deform) {
    required_.clear();
    for (const TileIndex index : tiles)
        if (find(index) != nullptr) required_.insert(index);
    std::set<TileIndex> needed = required_;
    needed.insert(awaited_.begin(), awaited_.end());
    const auto reached = [&] {
        return deferred_.empty() &&
               std::all_of(required_.begin(), required_.end(), [&](TileIndex index) { return is_hot(index); });
    };
    Result<void> outcome = wait_until(reached, needed, stats, deform);
    for (const TileIndex index : required_)
        if (Tile& tile = *find(index); tile.hot) read_back_now(index, tile);
    required_.clear();
    return outcome;
}

bool TileCache::is_in_field(TileIndex index) const {
    const Tile* tile = find(index);
    return tile == nullptr || (tile->hot && tile->newer.empty() && tile->reading.empty() && !awaited_.contains(index));
}

Result<std::uint64_t> TileCache::hash(gl::CacheStats& stats, gl::StageStats& deform) {
    if (const Result<void> settled =
            wait_until([&] { return deferred_.empty(); }, std::set(awaited_), stats, deform);
        !settled)
        return settled.error();
    std::vector<TileIndex> order;
    for (const auto& [index, tile] : tiles_) order.push_back(index);
    std::sort(order.begin(), order.end(),
              [](TileIndex a, TileIndex b) { return a.z != b.z ? a.z < b.z : a.x < b.x; });
    const MapGeometry& map = ground_.map(MapKind::Detail);
    StateHasher hasher;
    for (const TileIndex index : order) {
        Tile& tile = *find(index);
        const PageRect pages = pages_of(grid_.interior(index));
        if (tile.hot) {
            read_back_now(index, tile);
            add_tile_to_hash(hasher, index, grid_.size, field_.pages_in(pages));
            continue;
        }
        DetailField codes;
        if (tile.stored) {
            const std::shared_ptr<DiskRequest> request =
                DiskRequest::load(index, {{.tile = index, .pages = pages, .version = tile.version}}, 0);
            worker_.submit(request);
            for (std::shared_ptr<DiskRequest> done; done != request;) {
                done = worker_.wait();
                if (done != request) deliver(done, stats);
            }
            if (!request->outcome) return request->outcome.error();
            for (Page& page : request->pieces.front().loaded) codes.put(std::move(page));
        }
        for (const StampRecord& record : tile.pending)
            apply_stamp(prepare(record, map, ground_.shapes()), codes,
                        intersection(grid_.interior(index), grid_.map));
        add_tile_to_hash(hasher, index, grid_.size, codes.pages_in(pages));
    }
    return hasher.digest();
}

/// The field holds what the tile's textures hold. Waits for the GPU.
void TileCache::read_back_now(TileIndex index, Tile& tile) {
    if (!tile.reading.empty()) {
        // On its way already: let it come, lest it overwrite what is read here.
        textures_.finish();
        gl::CacheStats none;
        const bool yielding = std::exchange(tile.yielding, false);
        poll_read_back(index, tile, none);
        tile.yielding = yielding;
    }
    if (tile.newer.empty()) return;
    textures_.read_back_now(index, rects_of(tile.newer, intersection(grid_.interior(index), grid_.map)), field_);
    tile.newer.clear();
}

}  // namespace tilth
