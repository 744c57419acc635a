// Which detail tiles a block of ground samples, and where they lie. Pure: numbers in, numbers out.
#pragma once

#include <array>
#include <cstdint>

#include "tilth/render/camera.h"
#include "tilth/render/detail_view.h"
#include "tilth/world/grid.h"

namespace tilth {

/// What the fragments of a block read. Most blocks lie in one tile, and pay for one sampler; only those on a border
/// between tiles choose among four for every tap.
enum class DetailSource : std::uint8_t { None, Slot0, Slot1, Slot2, Slot3, Window };

/// Texels about a fragment's own that its taps may read (`render/detail_slopes.glsl` says why), with some to spare for
/// positions that multisampling extrapolates.
inline constexpr std::int32_t kDetailTapTexels = 16;

/// Detail texels between two posts.
std::int32_t texels_per_post(const DetailView& detail, const GridSpec& grid);

/// What a block whose corners are the posts `first` and `last` (both included, of the drawn world: not folded) reads:
/// None beyond the reach or the window, and where all tiles about it are missing.
DetailSource detail_source(const DetailView& detail, Texel first, Texel last, const GridSpec& grid,
                           const Camera& camera);

/// The ground in texels from the first interior texel of a tile. Differences are taken between integers, so the
/// numbers are exact as long as they are below 2^24: anywhere near the tile, however far that is from the origin.
struct DetailPlacement {
    float base_x = 0, base_z = 0;     ///< the camera's base post
    std::array<float, 4> map_edge{};  ///< first texel of the map x, z; last texel x, z
};
DetailPlacement detail_placement(const DetailView& detail, TileIndex tile, const GridSpec& grid, const Camera& camera);

}  // namespace tilth
