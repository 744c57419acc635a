#include "tilth/render/detail_blocks.h"

#include <algorithm>
#include <cmath>

#include "tilth/core/checks.h"

namespace tilth {
namespace {

/// Half-open range of texels of the map that posts `first`..`last` of one axis and the taps about them read.
struct Range {
    std::int64_t min = 0, max = 0;
};
Range range_of(std::int32_t first, std::int32_t last, std::int32_t per_post, std::int32_t map_min,
               std::int32_t map_max) {
    return {std::max<std::int64_t>(std::int64_t{first} * per_post - kDetailTapTexels, map_min),
            std::min<std::int64_t>(std::int64_t{last} * per_post + kDetailTapTexels + 1, map_max)};
}

}  // namespace

std::int32_t texels_per_post(const DetailView& detail, const GridSpec& grid) {
    const double ratio = grid.spacing_m / detail.spacing_m;
    TILTH_EXPECTS(ratio >= 0.5 && ratio < 1e6 && std::abs(ratio - std::round(ratio)) < 1e-6 * ratio,
                  "the spacing of posts is not a whole number of detail texels");
    return static_cast<std::int32_t>(std::lround(ratio));
}

DetailSource detail_source(const DetailView& detail, Texel first, Texel last, const GridSpec& grid,
                           const Camera& camera) {
    const double s = grid.spacing_m;
    const auto outside = [](double min, double max, double eye) { return std::max({min - eye, eye - max, 0.0}); };
    if (!(std::hypot(outside(first.x * s, last.x * s, camera.eye_x_m),
                     outside(first.z * s, last.z * s, camera.eye_z_m)) < detail.reach_m))
        return DetailSource::None;

    const std::int32_t per_post = texels_per_post(detail, grid);
    const Range x = range_of(first.x, last.x, per_post, detail.grid.map.min.x, detail.grid.map.max.x);
    const Range z = range_of(first.z, last.z, per_post, detail.grid.map.min.z, detail.grid.map.max.z);
    if (x.max <= x.min || z.max <= z.min) return DetailSource::None;
    const auto texel = [](std::int64_t tx, std::int64_t tz) {
        return Texel{static_cast<std::int32_t>(tx), static_cast<std::int32_t>(tz)};
    };
    const TileIndex low = detail.grid.tile_of(texel(x.min, z.min));
    const TileIndex high = detail.grid.tile_of(texel(x.max - 1, z.max - 1));
    bool any = false;
    std::size_t slot = 0;
    for (std::int32_t tz = std::max(low.z, detail.window.min.z); tz <= std::min(high.z, detail.window.max.z); ++tz) {
        for (std::int32_t tx = std::max(low.x, detail.window.min.x); tx <= std::min(high.x, detail.window.max.x);
             ++tx) {
            slot = static_cast<std::size_t>((tz - detail.window.min.z) * 2 + tx - detail.window.min.x);
            any |= detail.slopes[slot] != nullptr;
        }
    }
    if (!any) return DetailSource::None;
    return low == high ? static_cast<DetailSource>(static_cast<std::size_t>(DetailSource::Slot0) + slot)
                       : DetailSource::Window;
}

DetailPlacement detail_placement(const DetailView& detail, TileIndex tile, const GridSpec& grid, const Camera& camera) {
    const std::int32_t per_post = texels_per_post(detail, grid);
    const auto from = [&](std::int64_t texel, std::int32_t tile_on_axis) {
        return static_cast<float>(texel - std::int64_t{tile_on_axis} * detail.grid.size);
    };
    const TexelRect& map = detail.grid.map;
    return {
        from(std::int64_t{camera.base_x} * per_post, tile.x),
        from(std::int64_t{camera.base_z} * per_post, tile.z),
        {from(map.min.x, tile.x), from(map.min.z, tile.z), from(map.max.x - 1, tile.x), from(map.max.z - 1, tile.z)}};
}

}  // namespace tilth
