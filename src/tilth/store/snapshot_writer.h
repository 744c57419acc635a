// A snapshot into a world's store: what of it is new, what of the store is old.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "tilth/core/result.h"
#include "tilth/store/blob_store.h"
#include "tilth/store/snapshot.h"
#include "tilth/store/world_pages.h"
#include "tilth/world/height_codec.h"

namespace tilth {

/// Knows which lists of waiting stamps and which strokes the store has, so that it can take away what is no longer
/// wanted. Threads: one at a time.
class SnapshotWriter {
public:
    /// `waiting`: tiles that have a list. `stroke_parts`: strokes that have blobs, and how many. `name`: of the world,
    /// for messages.
    SnapshotWriter(BlobStore& blobs, WorldPages& pages, std::string name, HeightPrecision precision,
                   std::set<TileIndex> waiting, std::map<std::uint64_t, std::uint32_t> stroke_parts)
        : blobs_(blobs),
          pages_(pages),
          name_(std::move(name)),
          precision_(precision),
          waiting_tiles_(std::move(waiting)),
          stroke_parts_(std::move(stroke_parts)) {}

    /// Writes and commits. Fails also where a tile is torn that the snapshot does not have. After an error the store
    /// is as of its last commit on disk (or, where the commit failed late, as of this one, wholly), and in a state that
    /// a larger snapshot puts right, which writes every page again that was saved since the last commit.
    Result<void> write(const Snapshot& snapshot);
    [[nodiscard]] const std::set<TileIndex>& waiting_tiles() const { return waiting_tiles_; }

private:
    Result<void> write_waiting(const TileSnapshot& tile);
    Result<void> write_history(const Snapshot& snapshot);

    BlobStore& blobs_;
    WorldPages& pages_;
    std::string name_;
    HeightPrecision precision_;
    std::set<TileIndex> waiting_tiles_;
    std::map<std::uint64_t, std::uint32_t> stroke_parts_;
};

}  // namespace tilth
