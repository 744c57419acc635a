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
    const Result<void> stamped = apply({}, deform);
    FrameBudget budget = without_limit();
    const std::uint64_t missing = stats.missing_active;
    transfer(budget, stats, deform);
    stats.missing_active = missing;  // of frames alone
    return stamped;
}

/// Goes on until `reached`. Fails with the store's error when one of `tiles` cannot be had. `NoTextures`: what is left
/// waits for textures that are not to be had.
Result<TileCache::Waited> TileCache::wait_until(const std::function<bool()>& reached, const std::set<TileIndex>& tiles,
                                                gl::CacheStats& stats, gl::StageStats& deform) {
    constexpr int kPatience = 16;                             // rounds in which nothing is on its way
    for (auto& [index, tile] : tiles_) tile.retry_at_ms = 0;  // whoever waits asks again at once
    const auto under_way = [&](TileIndex index) {
        const Tile& tile = *find(index);
        return tile.arriving || !tile.reading.empty() || (tile.has_textures && !tile.to_fill.empty()) ||
               (!tile.newer.empty() && (tile.yielding || awaited_.contains(index) || tile.state == TileState::Saving));
    };
    for (int idle = 0; !reached();) {
        if (const Result<void> stepped = step(stats, deform); !stepped) return stepped.error();
        if (reached()) break;
        for (const TileIndex index : tiles)
            if (const Tile* tile = find(index); tile != nullptr && tile->retry_at_ms > now_ms_) return tile->trouble;
        if (const std::shared_ptr<DiskRequest> done = worker_.wait()) {
            deliver(done, stats);
            idle = 0;
            continue;
        }
        textures_.finish();
        idle = std::any_of(live_.begin(), live_.end(), under_way) ? 0 : idle + 1;
        if (idle > kPatience) return Waited::NoTextures;
    }
    return Waited::Reached;
}

Result<void> TileCache::settle(gl::CacheStats& stats, gl::StageStats& deform) {
    std::set<TileIndex> wanted = awaited_;
    for (const ViewerTiles& viewer : viewers_)
        for_each_tile(viewer.loaded, [&](TileIndex index) {
            if (find(index) != nullptr) wanted.insert(index);
        });
    const Result<Waited> waited = wait_until(
        [&] {
            return deferred_.empty() && std::all_of(wanted.begin(), wanted.end(), [&](TileIndex index) {
                       const Tile* tile = find(index);
                       return tile == nullptr || tile->current || interest(index) < Interest::Loaded;
                   });
        },
        wanted, stats, deform);
    if (!waited) return waited.error();
    return {};  // those that find no textures are not drawn, by the host's own bound
}

Result<void> TileCache::require(std::span<const TileIndex> tiles, gl::CacheStats& stats, gl::StageStats& deform) {
    required_.clear();
    for (const TileIndex index : tiles)
        if (find(index) != nullptr) required_.insert(index);
    std::set<TileIndex> needed = required_;
    needed.insert(awaited_.begin(), awaited_.end());
    const Result<Waited> waited = wait_until(
        [&] {
            return deferred_.empty() && std::all_of(required_.begin(), required_.end(), [&](TileIndex index) {
                       return find(index) == nullptr || is_hot(index);
                   });
        },
        needed, stats, deform);
    for (const TileIndex index : required_)
        if (Tile* tile = find(index); tile != nullptr && tile->hot) read_back_now(index, *tile);
    required_.clear();
    if (!waited) return waited.error();
    TILTH_ASSERT(*waited == Waited::Reached, "codes wait for textures");
    return {};
}

bool TileCache::is_in_field(TileIndex index) const {
    const Tile* tile = find(index);
    return tile == nullptr || (tile->hot && tile->newer.empty() && tile->reading.empty() && !awaited_.contains(index));
}

Result<std::uint64_t> TileCache::hash(gl::CacheStats& stats, gl::StageStats& deform) {
    const Result<Waited> waited = wait_until([&] { return deferred_.empty(); }, std::set(awaited_), stats, deform);
    if (!waited) return waited.error();
    TILTH_ASSERT(*waited == Waited::Reached, "stamps wait for textures");
    std::vector<TileIndex> order;
    for (const auto& [index, tile] : tiles_)
        if (!tile.clean) order.push_back(index);
    std::sort(order.begin(), order.end(), [](TileIndex a, TileIndex b) { return a.z != b.z ? a.z < b.z : a.x < b.x; });
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
            wait_for(request, stats);
            if (!request->outcome) return request->outcome.error();
            for (Page& page : request->pieces.front().loaded) codes.put(std::move(page));
        }
        for (const Stamp& stamp : tile.pending) apply_stamp(stamp.prepared, codes, grid_.inside(index));
        add_tile_to_hash(hasher, index, grid_.size, codes.pages_in(pages));
    }
    return hasher.digest();
}

/// The field holds what the tile's textures hold. Waits for the GPU.
void TileCache::read_back_now(TileIndex index, Tile& tile) {
    // What is on its way comes first, lest it overwrite what is read here; a large one takes several rounds of the
    // ring.
    gl::CacheStats none;
    const bool yielding = std::exchange(tile.yielding, false);
    while (!tile.reading.empty()) {
        textures_.finish();
        poll_read_back(index, tile, none);
    }
    tile.yielding = yielding;
    if (tile.newer.empty()) return;
    textures_.read_back_now(index, rects_of(tile.newer, grid_.inside(index)), field_);
    refill_neighbours(index, std::exchange(tile.newer, {}));
}

}  // namespace tilth
