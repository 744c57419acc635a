// Edits on a ground that is wholly in memory: a server, a tool, a test's reference.
#pragma once

#include <vector>

#include "tilth/ground/apply_result.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/undo_history.h"

namespace tilth {

/// Applies a stamp, keeping what its undo needs; or undoes a stroke. Both maps. The ground has issued or accepted the
/// records. Cost: as `Ground::apply`, and of undo as its stamps, or a copy of its pages.
/// Of an undo, `texels` and `saturated` are those of the stamps taken back (codes that images then replace included),
/// and `rect` is that of the detail map; `changed_by` tells where it changes what.
ApplyResult apply_edit(Ground& ground, const GroundEdit& edit);
/// The part of it that one map has: nothing, for a stamp on the other. `rect` is that map's.
ApplyResult apply_edit(Ground& ground, MapKind map, const GroundEdit& edit);

/// Whether the edit does anything to a map: a stamp to its own, an undo to those of its stroke's stamps.
bool concerns(const GroundEdit& edit, MapKind map);

/// A rectangle of one map that an edit may change.
struct ChangedRect {
    MapKind map = MapKind::Coarse;
    TexelRect rect;              ///< inside the map, not empty
    std::uint64_t sequence = 0;  ///< of the stamp that does it, or that is undone
};
/// One for each stamp that the edit does or undoes, those off their map left out.
std::vector<ChangedRect> changed_by(const Ground& ground, const GroundEdit& edit);

}  // namespace tilth
