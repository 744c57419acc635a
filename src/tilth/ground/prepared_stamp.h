// From a record to what the executors need: rectangle, reciprocal, image matrix, residue.
#pragma once

#include <span>

#include "tilth/ground/map_geometry.h"
#include "tilth/ground/shape_library.h"
#include "tilth/ground/stamp.h"
#include "tilth/ground/stamp_params.h"
#include "tilth/world/texel.h"

namespace tilth {

/// A stamp ready for its map. Valid as long as the library that its shape lives in.
struct PreparedStamp {
    StampParams params;
    const Shape* shape = nullptr;

    [[nodiscard]] TexelRect rect() const { return {{params.min_x, params.min_z}, {params.max_x, params.max_z}}; }
    [[nodiscard]] StampRule rule() const { return static_cast<StampRule>(params.flags & STAMP_RULE_MASK); }
    /// Its result at a texel depends on that texel alone, so that many may run in one pass.
    [[nodiscard]] bool reads_own_texel_only() const { return rule() != StampRule::Smooth; }
};

/// Integers, and IEEE doubles without fused operations for the centre alone: the same on every machine. Cost: constant,
/// except for zero-volume profiles of up to 256 texels' radius, whose residue costs one pass over the unclipped stamp.
/// `record` was issued for `map` and `shapes`.
PreparedStamp prepare(const StampRecord& record, const MapGeometry& map, const ShapeLibrary& shapes);

}  // namespace tilth
