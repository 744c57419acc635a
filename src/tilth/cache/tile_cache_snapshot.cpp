// What of the detail map a store has to commit.
#include <algorithm>
#include <utility>

#include "tilth/cache/tile_cache.h"

namespace tilth {

void TileCache::restore_waiting(const std::map<TileIndex, std::vector<WaitingStamp>>& waiting,
                                const UndoHistory& history) {
    for (const auto& [index, stamps] : waiting) {
        if (!grid_.exists(index) || stamps.empty()) continue;
        Tile& tile = tiles_[index];
        tile.suspected = false;
        tile.modified = true;
        for (const WaitingStamp& stamp : stamps) {
            if (const Result<void> accepted = ground_.accept(stamp.record); !accepted) {
                errors_.push_back({accepted.error().code,
                                   text("stamp ", stamp.record.sequence, ", which waited for detail tile (", index.x,
                                        ", ", index.z, "), is left out: ", accepted.error().message)});
                continue;
            }
            tile.pending.push_back(
                {edit_of(stamp, history), prepare(stamp.record, ground_.map(MapKind::Detail), ground_.shapes())});
        }
        pending_ += tile.pending.size();
        if (tile.pending.size() >= settings_.most_pending) crowded_.insert(index);
        suspect_neighbours(index);
    }
}

void TileCache::prepare_snapshot() {
    for (const TileIndex index : live_)
        if (Tile& tile = *find(index); tile.unsaved) begin_read_back(index, tile);
}

std::size_t TileCache::pages_ahead() const {
    std::size_t pages = 0;
    for (const TileIndex index : live_)
        if (const Tile& tile = *find(index); tile.unsaved) pages += tile.newer.size() + tile.reading.size();
    return pages;
}

std::optional<std::vector<TileSnapshot>> TileCache::snapshot(gl::StageStats& deform) {
    if (!deferred_.empty()) return std::nullopt;
    std::vector<TileSnapshot> all;
    for (auto& [index, tile] : tiles_) {
        if (!tile.unsaved || tile.clean) continue;
        tile.unsaved = false;
        TileSnapshot part{.tile = index, .has_codes = tile.hot};
        if (tile.hot) {
            if (!tile.newer.empty() || !tile.reading.empty()) {
                read_back_now(index, tile);
                ++deform.fallbacks;
            }
            part.pages = field_.pages_in(pages_of(grid_.interior(index)));
        }
        for (const Stamp& stamp : tile.pending) {
            const StrokePtr& stroke = stamp.edit.stroke;
            part.waiting.push_back({stamp.edit.record, stroke == nullptr || stroke->forgotten ? 0 : stroke->number,
                                    static_cast<std::uint32_t>(stamp.edit.position)});
        }
        all.push_back(std::move(part));
    }
    return all;
}

void TileCache::snapshot_failed(std::span<const TileSnapshot> tiles) {
    for (const TileSnapshot& part : tiles)
        if (const auto found = tiles_.find(part.tile); found != tiles_.end()) found->second.unsaved = true;
}

void TileCache::wait_for(const std::shared_ptr<DiskRequest>& request, gl::CacheStats& stats) {
    if (std::find(finished_.begin(), finished_.end(), request) != finished_.end()) return;
    for (std::shared_ptr<DiskRequest> done; done != request;) {
        done = worker_.wait();
        TILTH_ASSERT(done != nullptr, "a request that was never submitted");
        if (done != request || request->kind == DiskRequest::Kind::Work) deliver(done, stats);
    }
}

}  // namespace tilth
