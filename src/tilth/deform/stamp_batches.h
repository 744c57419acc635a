// Which stamps run in one pass, and over which texels. Pure: no GL.
//
// A rule that reads its own texel alone gives the same bits whether each stamp is a pass or one pass walks through a
// list of stamps at each texel. So consecutive stamps of such rules share a pass. The map is cut into 64 x 64 blocks; a
// block's list names the stamps that touch it, in order, and only the bounds of what they touch in it are drawn.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tilth/world/texel.h"

namespace tilth {

inline constexpr std::int32_t kBlockTexels = 64;

/// What the planner must know of a stamp.
struct StampTraits {
    TexelRect rect;           ///< clipped to the map; may be empty
    bool shares_pass = true;  ///< its rule reads its own texel only, and nobody counts its saturated texels
};

/// Texels drawn at once, with the part of the batch's `order` that lists their stamps.
struct StampBlock {
    TexelRect rect;
    std::uint32_t first = 0, count = 0;
};

/// One pass: stamps [first, first + count) of the input.
struct StampBatch {
    std::size_t first = 0, count = 0;
    std::vector<StampBlock> blocks;    ///< disjoint
    std::vector<std::uint32_t> order;  ///< stamps by number within the batch, block after block
};

/// Bounds of one pass.
struct BatchLimits {
    std::size_t stamps = 4096;    ///< the list's texture buffer: 7 texels each, and GL 3.3 promises 65 536
    std::size_t entries = 65536;  ///< of `order`
    std::size_t blocks = 1024;    ///< places in the scratch textures
};

/// Cuts a list of stamps into passes; together they hold every stamp that touches the map once, in order. A stamp alone
/// in its pass is one block of any size. Cost: proportional to the blocks touched.
std::vector<StampBatch> plan_batches(std::span<const StampTraits> stamps, const BatchLimits& limits = {});

}  // namespace tilth
