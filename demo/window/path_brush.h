// Stamps along a dragged path: spaced by distance, whatever the frame rate.
#pragma once

#include <optional>
#include <vector>

#include "tilth/world/grid.h"

namespace tilth::demo {

class PathBrush {
public:
    /// The button went down at `at`: a stamp there, and the path starts.
    std::vector<WorldPos> press(WorldPos at) {
        last_ = at;
        return {at};
    }
    /// The cursor is at `at` now. Returns the stamps that are due, each `spacing_m` after the one before.
    std::vector<WorldPos> drag(WorldPos at, double spacing_m);
    void release() { last_.reset(); }

private:
    std::optional<WorldPos> last_;  ///< of the last stamp
};

}  // namespace tilth::demo
