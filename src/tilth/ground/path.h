// Stamps along a polyline: footprints, ruts, tyre tracks.
#pragma once

#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/stamp.h"

namespace tilth {

/// A row of equal stamps, spaced by distance (never by time or frame).
struct PathRequest {
    StampRequest stamp;            ///< `centre` is ignored; `rotation_rad` is added to the path's direction
    std::vector<WorldPos> points;  ///< at least one; repeated points are skipped
    double spacing_m = 0.75;       ///< > 0, along the path
    double alternate_m = 0.0;      ///< >= 0: metres left and right of the path in turn, mirrored in turn
};

/// The stamps of a path: one at its start, then every `spacing_m` along it, each turned so that what its image shows at
/// +x lies ahead, mirrored or not: on a path `mirror` changes left and right, as of a pair of boots. With `alternate_m`
/// the first lies on the left (mirrored = as asked), the next on the right with `mirror` turned round. Keys count up
/// from `stamp.key` if it is given. Fails with the field's name on values out of range, and beyond a million stamps.
Result<std::vector<StampRequest>> stamps_along(const PathRequest& path);

}  // namespace tilth
