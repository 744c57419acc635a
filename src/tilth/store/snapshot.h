// A world at one moment, as far as it changed since the last one: what is committed to its store.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tilth/ground/page.h"
#include "tilth/ground/undo_history.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// A stamp that waits for its tile to be loaded, and the stroke it belongs to (0: none).
struct WaitingStamp {
    StampRecord record;
    std::uint64_t stroke = 0;
    std::uint32_t position = 0;  ///< among the stroke's records
};

/// The edit that it was when it was issued; without its stroke where `history` has forgotten that.
inline GroundEdit edit_of(const WaitingStamp& stamp, const UndoHistory& history) {
    return {.record = stamp.record,
            .stroke = stamp.stroke == 0 ? nullptr : history.find(stamp.stroke),
            .position = stamp.position};
}

struct TileSnapshot {
    TileIndex tile;
    bool has_codes = false;             ///< `pages` are all of it; else the store has its codes already
    std::vector<Page> pages;            ///< shares: given back on the thread that took the snapshot
    std::vector<WaitingStamp> waiting;  ///< all that wait for it
};

struct HistorySnapshot {
    std::vector<std::uint64_t> done, undone;  ///< numbers of all strokes, the oldest first
    std::uint64_t next_number = 1;
    std::vector<Stroke> changed;  ///< since the last snapshot
};

/// All of it is of the moment after edit `edits` and before the next.
struct Snapshot {
    std::uint64_t edits = 0;
    std::uint64_t next_sequence = 1;
    std::vector<Page> coarse;  ///< pages of the coarse map that were written, copies
    std::vector<TileSnapshot> tiles;
    HistorySnapshot history;
};

}  // namespace tilth
