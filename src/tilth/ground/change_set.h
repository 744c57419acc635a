// What a frame changed: the one feed for those who follow the ground (physics, navigation, plants, a network).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "tilth/ground/code_range.h"
#include "tilth/ground/stamp.h"
#include "tilth/world/texel.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// A rectangle of one map, or of one tile of the detail map, that changed. The ranges are never narrower than the
/// truth: exact where the codes are in memory, bounds where the GPU alone has them, all codes for a tile that is
/// neither (its stamps are applied when it is loaded).
struct Change {
    MapKind map = MapKind::Coarse;
    TileIndex tile;  ///< of the detail map
    TexelRect rect;  ///< texels of the map; only the tile's own, no apron
    CodeRange before, after;
    std::uint64_t first_sequence = 0, last_sequence = 0;  ///< of the stamps that did it, or that were undone
};

/// Gathers the changes of a frame. Rectangles of one tile that meet become one, as do those of a tile with many.
class ChangeSet {
public:
    /// `before`: of `rect`, before the change.
    void note(MapKind map, TileIndex tile, const TexelRect& rect, CodeRange before, std::uint64_t first_sequence,
              std::uint64_t last_sequence);
    /// Once all of a map's changes are made: `after(change)` gives the range of its rectangle now.
    template <class After>
    void finish(MapKind map, const After& after) {
        for (std::size_t i = 0; i < changes_.size(); ++i) {
            Change& change = changes_[i];
            if (change.map != map) continue;
            change.after = after(change);
            if (is_joined_[i]) change.before.include(change.after);  // of what lies between the joined rectangles
        }
    }
    [[nodiscard]] const std::vector<Change>& changes() const { return changes_; }
    void clear() { changes_.clear(), is_joined_.clear(), by_tile_.clear(); }

private:
    std::vector<Change> changes_;
    std::vector<bool> is_joined_;
    std::map<std::pair<MapKind, TileIndex>, std::vector<std::size_t>> by_tile_;
};

}  // namespace tilth
