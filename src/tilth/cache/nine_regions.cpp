#include "tilth/cache/nine_regions.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tilth/core/checks.h"
#include "tilth/core/result.h"

namespace tilth {
namespace {

/// Offsets of tiles along one axis, both inclusive.
struct Offsets {
    std::int32_t min, max;
};

constexpr Offsets loaded_offsets(Side side) { return {side == Side::High ? 0 : -1, side == Side::Low ? 0 : 1}; }
constexpr Offsets active_offsets(Side side) { return {side == Side::Low ? -1 : 0, side == Side::High ? 1 : 0}; }
constexpr TileWindow window(TileIndex at, Offsets x, Offsets z) {
    return {{at.x + x.min, at.z + z.min}, {at.x + x.max, at.z + z.max}};
}

constexpr TileWindow clipped(const TileWindow& a, const TileWindow& b) {
    return {{std::max(a.min.x, b.min.x), std::max(a.min.z, b.min.z)},
            {std::min(a.max.x, b.max.x), std::min(a.max.z, b.max.z)}};
}

/// The place along one axis among texels [first, end).
double clamped_place(double at, std::int32_t first, std::int32_t end) {
    const double low = first;
    return std::clamp(std::isnan(at) ? 0.0 : at, low, std::max(low, end - 1.0));
}

struct PlaceOnAxis {
    std::int32_t tile;
    double fraction;
};
PlaceOnAxis place_on_axis(double at, std::int32_t size) {
    const double whole = std::floor(at);
    const auto texel = static_cast<std::int32_t>(whole);
    // at - whole rounds to 1 a hair before a texel.
    const double fraction = (floor_modulo(texel, size) + (at - whole)) / size;
    return {floor_divide(texel, size), std::min(fraction, std::nextafter(1.0, 0.0))};
}

Side side_of(double fraction, double band) {
    return fraction < 0.5 - band / 2 ? Side::Low : fraction > 0.5 + band / 2 ? Side::High : Side::Middle;
}

/// How far along one axis from a place to where tiles of index `tile` are active, in tiles: within (tile - reach,
/// tile + 1 + reach).
double tiles_until_active(const PlaceOnAxis& place, std::int32_t tile, double band) {
    const double reach = (1 - band) / 2;
    const double before = tile - reach - (place.tile + place.fraction);
    const double behind = place.tile + place.fraction - (tile + 1 + reach);
    return std::max({before, behind, 0.0});
}

}  // namespace

PlaceInTile place_in_tile(const TileGrid& grid, PostPos at_texels) {
    const PlaceOnAxis x = place_on_axis(clamped_place(at_texels.x, grid.map.min.x, grid.map.max.x), grid.size);
    const PlaceOnAxis z = place_on_axis(clamped_place(at_texels.z, grid.map.min.z, grid.map.max.z), grid.size);
    return {{x.tile, z.tile}, x.fraction, z.fraction};
}

Region region_of(const PlaceInTile& place, double band) {
    TILTH_EXPECTS(band >= 0.02 && band <= 0.9, text("band ", band, " must lie in [0.02, 0.9]"));
    return {side_of(place.x, band), side_of(place.z, band)};
}

TileWindow loaded_window(TileIndex viewer_tile, Region region) {
    return window(viewer_tile, loaded_offsets(region.x), loaded_offsets(region.z));
}

TileWindow active_window(TileIndex viewer_tile, Region region) {
    return window(viewer_tile, active_offsets(region.x), active_offsets(region.z));
}

double kept_band(double band) { return std::min(band + 0.4, (1 + band) / 2); }

TileWindow kept_window(const PlaceInTile& place, double band) {
    const double wider = kept_band(band);
    return loaded_window(place.tile, {side_of(place.x, wider), side_of(place.z, wider)});
}

double active_reach_m(double tile_m, double band) { return tile_m * (1 - band) / 2; }

double texels_until_active(const TileGrid& grid, PostPos at_texels, TileIndex tile, double band) {
    const PlaceInTile place = place_in_tile(grid, at_texels);
    if (active_window(place.tile, region_of(place, band)).contains(tile)) return 0;
    return grid.size * std::max(tiles_until_active({place.tile.x, place.x}, tile.x, band),
                                tiles_until_active({place.tile.z, place.z}, tile.z, band));
}

ViewerTiles tiles_of_viewer(const TileGrid& grid, PostPos at_texels, double band) {
    const PlaceInTile place = place_in_tile(grid, at_texels);
    const Region region = region_of(place, band);
    const TileWindow all = tiles_of(grid, grid.map);
    return {.own = place.tile,
            .loaded = clipped(loaded_window(place.tile, region), all),
            .active = clipped(active_window(place.tile, region), all),
            .kept = clipped(kept_window(place, band), all)};
}

Interest interest_in(TileIndex tile, std::span<const ViewerTiles> viewers) {
    Interest most = Interest::None;
    for (const ViewerTiles& viewer : viewers) {
        if (viewer.active.contains(tile)) return Interest::Active;
        if (viewer.loaded.contains(tile))
            most = Interest::Loaded;
        else if (viewer.kept.contains(tile))
            most = std::max(most, Interest::Kept);
    }
    return most;
}

std::int32_t tiles_away(TileIndex tile, std::span<const ViewerTiles> viewers) {
    std::int32_t nearest = std::numeric_limits<std::int32_t>::max();
    for (const ViewerTiles& viewer : viewers)
        nearest = std::min(nearest, std::max(std::abs(tile.x - viewer.own.x), std::abs(tile.z - viewer.own.z)));
    return nearest;
}

}  // namespace tilth
