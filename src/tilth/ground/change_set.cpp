#include "tilth/ground/change_set.h"

#include <algorithm>

namespace tilth {
namespace {

constexpr std::size_t kMostRects = 16;  // of one tile: beyond them the last one grows

}  // namespace

void ChangeSet::note(MapKind map, TileIndex tile, const TexelRect& rect, CodeRange before, std::uint64_t first_sequence,
                     std::uint64_t last_sequence) {
    std::vector<std::size_t>& of_tile = by_tile_[{map, tile}];
    auto at = std::find_if(of_tile.begin(), of_tile.end(),
                           [&](std::size_t i) { return !intersection(changes_[i].rect, rect).empty(); });
    if (at == of_tile.end() && of_tile.size() >= kMostRects) --at;
    if (at == of_tile.end()) {
        of_tile.push_back(changes_.size());
        changes_.push_back({.map = map,
                            .tile = tile,
                            .rect = rect,
                            .before = before,
                            .after = {},
                            .first_sequence = first_sequence,
                            .last_sequence = last_sequence});
        is_joined_.push_back(false);
        return;
    }
    Change& change = changes_[*at];
    if (change.rect != rect) is_joined_[*at] = true;
    change.rect = bounds_of(change.rect, rect);
    change.before.include(before);
    change.first_sequence = std::min(change.first_sequence, first_sequence);
    change.last_sequence = std::max(change.last_sequence, last_sequence);
}

}  // namespace tilth
