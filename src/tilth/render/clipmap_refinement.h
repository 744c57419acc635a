// Where a clipmap is drawn one level finer than its rings say, because the ground is rough there. Pure.
//
// A ring's block may be drawn with the vertices of the next finer level. A vertex p of it stands at
//     base(p) + w(p) (own height(p) - base(p)),     base = the ring's own (morphed) surface
// where w is a continuous function of position and viewer: bilinear between nodes every 32 units of the ring's level,
// and faded out towards the ring's two borders (`shared/clipmap_morph.glsl`). Blocks that touch no node above 0 are not
// refined, so w is 0 on every border between refined and unrefined ground, and nothing jumps when a block changes
// sides: silhouettes gain a level, and there is neither crack nor pop.
#pragma once

#include <cstdint>
#include <vector>

#include "tilth/render/camera.h"
#include "tilth/render/clipmap_layout.h"
#include "tilth/render/height_bounds.h"
#include "tilth/render/view.h"
#include "tilth/world/grid.h"
#include "tilth/world/height_codec.h"

namespace tilth {

inline constexpr std::int32_t kNodeUnits = 32;  ///< level units between two nodes

/// The nodes of one level that lie about its window: node (x, z) stands at unit (32 x, 32 z).
struct NodeGrid {
    std::int32_t min_x = 0, min_z = 0, width = 0, depth = 0;
    std::int32_t first = 0;  ///< index of its first weight
};

struct ClipmapRefinement {
    std::vector<NodeGrid> grids;  ///< level by level; that of level 0 is empty
    std::vector<float> weights;   ///< 0..1, row by row

    /// Whether any weight above 0 reaches into the quads of `block`.
    [[nodiscard]] bool touches(const ClipmapBlock& block) const;
    /// w at a post of `level`, without the fading at the ring's borders.
    [[nodiscard]] float weight_at(std::int32_t level, std::int32_t x, std::int32_t z) const;
};

/// What the nodes are computed from: a map, possibly repeated by reflection.
struct RefinementInput {
    const GridSpec& grid;
    const HeightCodec& codec;
    bool mirrored = false;
    const HeightBounds& bounds;
};

/// Weights for one viewer: 0 where the finer level would move no vertex near the node by `refine_above_px` pixels, 1
/// from twice that on. A few thousand look-ups.
ClipmapRefinement clipmap_refinement(const ClipmapSettings& settings, const ClipmapLayout& layout, const Camera& camera,
                                     const RefinementInput& input);

/// A block as it is drawn: its vertices are those of `block.level`, its surface is that of `base_level`.
struct DrawnBlock {
    ClipmapBlock block;
    std::int32_t base_level = 0;  ///< block.level, or one more if refined
};

/// What is drawn for a layout: refined blocks are cut in four; stitches along their borders to unrefined ground are
/// added to those of the layout. None where ground ends (there w is not 0 and a stitch would be a fin): `last_x`,
/// `last_z` are the map's last posts, as the layout was made for.
struct DrawnBlocks {
    std::vector<DrawnBlock> blocks, stitches;
};
DrawnBlocks drawn_blocks(const ClipmapLayout& layout, const ClipmapRefinement& refinement, std::int32_t last_x,
                         std::int32_t last_z);

}  // namespace tilth
