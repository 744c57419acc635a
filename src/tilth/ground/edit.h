// Edits: the events of a world's history, in the order in which they happened.
#pragma once

#include <cstdint>

#include "tilth/ground/stamp.h"

namespace tilth {

enum class EditKind : std::uint8_t {
    Stamp,
    Undo,  ///< of the last stroke that is not undone
    Redo,  ///< of the last stroke that was undone, and nothing stamped since
};

/// What the journal keeps. Everything else follows from it: whoever does the same edits in the same order on the same
/// original heights has the same ground.
struct Edit {
    EditKind kind = EditKind::Stamp;
    bool begins_stroke = true;  ///< a stamp: what is undone together begins here
    StampRecord record;         ///< a stamp's; of undo and redo: only `sequence`, that of the stroke's first stamp

    friend bool operator==(const Edit&, const Edit&) = default;
};

}  // namespace tilth
