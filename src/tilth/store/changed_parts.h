// What of a ground the next snapshot has to hold.
#pragma once

#include <set>

#include "tilth/ground/ground.h"
#include "tilth/ground/undo_history.h"
#include "tilth/store/snapshot.h"

namespace tilth {

/// Pages of the coarse map and tiles of the detail map that changed since the last snapshot. Threads: one.
class ChangedParts {
public:
    /// `follows_tiles`: all of the detail map is in the ground. Else it is a cache's affair, and left out here.
    explicit ChangedParts(bool follows_tiles) : follows_tiles_(follows_tiles) {}

    /// An edit that is about to be applied.
    void note(const Ground& ground, const GroundEdit& edit);
    void note(const std::set<TileIndex>& tiles) { tiles_.insert(tiles.begin(), tiles.end()); }
    [[nodiscard]] bool has_coarse() const { return !coarse_.empty(); }

    /// Moves the coarse pages, copied, into a snapshot.
    void take_coarse(const Ground& ground, Snapshot& snapshot);
    /// The tiles: shares of their pages.
    void take_tiles(const Ground& ground, Snapshot& snapshot);
    /// A snapshot that did not become durable: what it held is changed still.
    void put_back(const Snapshot& snapshot);

private:
    bool follows_tiles_;
    std::set<PageIndex> coarse_;
    std::set<TileIndex> tiles_;
};

}  // namespace tilth
