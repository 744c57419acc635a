#include "tilth/store/snapshot_writer.h"

#include <algorithm>

#include "tilth/store/world_blobs.h"

namespace tilth {

Result<void> SnapshotWriter::write(const Snapshot& snapshot) {
    for (const Page& page : snapshot.coarse)
        if (const Result<void> saved = pages_.save_coarse(page); !saved) return saved;
    for (const TileSnapshot& tile : snapshot.tiles) {
        if (tile.has_codes)
            if (const Result<void> saved = pages_.save(tile.tile, tile.pages); !saved) return saved;
        if (const Result<void> written = write_waiting(tile); !written) return written;
    }
    if (const auto torn = pages_.torn())
        return Error{ErrorCode::FileWrite, text(name_, ": tile (", torn->x, ", ", torn->z,
                                                ") was saved in part, for an error; the snapshot must have it again")};
    if (const Result<void> written = write_history(snapshot); !written) return written;
    Result<void> committed = blobs_.commit(snapshot.edits);
    if (!committed) pages_.commit_failed();
    return committed;
}

Result<void> SnapshotWriter::write_waiting(const TileSnapshot& tile) {
    const BlobKey key = key_of_waiting(tile.tile);
    if (!tile.waiting.empty()) {
        waiting_tiles_.insert(tile.tile);
        return blobs_.put(key, encode_waiting(tile.waiting));
    }
    if (!waiting_tiles_.contains(tile.tile)) return {};
    if (const Result<void> erased = blobs_.erase(key); !erased) return erased;
    waiting_tiles_.erase(tile.tile);
    return {};
}

Result<void> SnapshotWriter::write_history(const Snapshot& snapshot) {
    const HistorySnapshot& history = snapshot.history;
    for (const Stroke& stroke : history.changed) {
        const auto parts = encode_stroke(stroke, precision_);
        std::uint32_t& known = stroke_parts_[stroke.number];
        known = std::max(known, static_cast<std::uint32_t>(parts.size()));
        for (std::uint32_t i = 0; i < parts.size(); ++i)
            if (const Result<void> put = blobs_.put(key_of_stroke(stroke.number, i), parts[i]); !put) return put;
    }
    std::set<std::uint64_t> listed(history.done.begin(), history.done.end());
    listed.insert(history.undone.begin(), history.undone.end());
    for (auto stroke = stroke_parts_.begin(); stroke != stroke_parts_.end();) {
        if (listed.contains(stroke->first)) {
            ++stroke;
            continue;
        }
        for (; stroke->second > 0; --stroke->second)
            if (const Result<void> erased = blobs_.erase(key_of_stroke(stroke->first, stroke->second - 1)); !erased)
                return erased;
        stroke = stroke_parts_.erase(stroke);
    }
    return blobs_.put(kCountersKey, encode_counters({.next_sequence = snapshot.next_sequence,
                                                     .next_stroke = history.next_number,
                                                     .done = history.done,
                                                     .undone = history.undone}));
}

}  // namespace tilth
