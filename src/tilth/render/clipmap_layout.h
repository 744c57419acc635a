// Which posts a geometry clipmap draws: nested windows of quads, cut into blocks. Pure: numbers in, numbers out.
//
//      +-----------------------+   Level l has a vertex every 2^l posts. Its window is (n-1) x (n-1) quads about the
//      |   level 2             |   viewer, its corner on an even vertex, so that it lies on a vertex of level l+1.
//      |   +-----------+       |   Level 0 is the whole window, every other level is a ring round the window before it.
//      |   | level 1   |       |   That window is (n-1)/2 of the ring's quads wide, an odd number, so the ring is one
//      |   |  +-----+  |       |   quad wider on one side or the other, which changes as the viewer moves (the
//      |   |  |  0  |  |       |   "L-trim" of Losasso & Hoppe, Geometry Clipmaps, 2004; here it falls out of cutting
//      |   |  +-----+  |       |   the ring into four rectangles).
//      |   +-----------+       |   Windows are clipped to the map; its last post belongs to every level, so a level's
//      +-----------------------+   last column of quads may be narrower.
#pragma once

#include <cstdint>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/render/view.h"
#include "tilth/world/grid.h"

namespace tilth {

/// Quads a side of the mesh that every block is drawn with.
inline constexpr std::int32_t kBlockQuads = 32;

/// Quads of one level, in units of 2^level posts: vertices x..x+width, z..z+depth. A vertex lies on post
/// min(x << level, last post of the map).
struct ClipmapBlock {
    std::int32_t x = 0, z = 0, width = 0, depth = 0, level = 0;
    friend bool operator==(const ClipmapBlock&, const ClipmapBlock&) = default;
};

/// What to draw for one viewer.
struct ClipmapLayout {
    /// Unclipped windows, level by level.
    std::vector<ClipmapBlock> windows;
    /// Quads, each at most kBlockQuads a side, finest level first. Together they cover every cell of the map within
    /// the coarsest window exactly once.
    std::vector<ClipmapBlock> blocks;
    /// Along each level's outer border where a coarser level follows: segments of width or depth 0, starting on an even
    /// vertex, at most kBlockQuads long. Triangles (2i, 2i+1, 2i+2) of a segment close the T-junctions there, which are
    /// closed mathematically (alpha is 1) but not in floats.
    std::vector<ClipmapBlock> stitches;
};

/// Fails with InvalidArgument naming the field. Allowed: n = 2^k - 1 in 15..1023, levels 1..16, blend 0.02..0.25; the
/// zone is at most (n - 9) / 4 units wide, which is the room there is (`shaders/shared/clipmap_morph.glsl`).
Result<void> check_clipmap(const ClipmapSettings& settings);

/// `viewer` in posts of the map, finite, |coordinate| <= 2^30. The map has posts 0..last_x, 0..last_z. `settings` are
/// checked. Cost: a few microseconds; about (n / 32)^2 * levels blocks.
ClipmapLayout clipmap_layout(const ClipmapSettings& settings, PostPos viewer, std::int32_t last_x, std::int32_t last_z);

}  // namespace tilth
