// The detail map of a world on disk, brought into memory as a whole.
#pragma once

#include <set>

#include "tilth/core/result.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/undo_history.h"
#include "tilth/store/world_folder.h"

namespace tilth {

/// Puts every page of `world` into the ground, then applies the stamps that waited for tiles. `history` is the world's:
/// their strokes keep what undo needs. Returns the tiles that the store now lacks: those that stamps waited for.
Result<std::set<TileIndex>> restore_detail(WorldFolder& world, const RecoveredWorld& recovered,
                                           const UndoHistory& history, Ground& ground);

}  // namespace tilth
