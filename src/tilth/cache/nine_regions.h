// Which tiles a viewer needs, given where he stands in his tile. Pure: no GL, no state.
//
//     NW | N | NE     A central band (a fraction of the tile) cuts the tile into nine regions, each axis on its own.
//    ----+---+----    A corner region needs the 2 x 2 tiles that meet there, an edge region 2 x 3, the centre all
//      W | C | E      3 x 3. Of those the tiles towards the viewer's corner are active: they are what a frame samples.
//    ----+---+----
//     SW | S | SE     Paging happens on crossing the band, never on crossing a tile's border.
//
// Region by region (Crause, Flower, Marais 2011, section 4.2): centre, nine loaded and one active; edge, six and two;
// corner, four and four. The viewer's own tile is always both.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tilth/world/grid.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

enum class Side : std::uint8_t { Low, Middle, High };
struct Region {
    Side x = Side::Middle, z = Side::Middle;
    friend bool operator==(const Region&, const Region&) = default;
};

/// Where a viewer stands: his tile, and his place in it as a fraction in [0, 1).
struct PlaceInTile {
    TileIndex tile;
    double x = 0, z = 0;
};

/// `at` in texels of the detail map (not of posts); NaN counts as 0, places off the map as its nearest texel. A place a
/// hair before a border (-1e-17) is in the tile before it or in the one behind, never at a fraction of 1.
PlaceInTile place_in_tile(const TileGrid& grid, PostPos at_texels);

/// The region of a place. `band`: width of the central band as a fraction of the tile, in [0.02, 0.9].
Region region_of(const PlaceInTile& place, double band);

/// Tiles to keep loaded, and of those the active ones, about the viewer's tile. Not clipped to the map.
TileWindow loaded_window(TileIndex viewer_tile, Region region);
TileWindow active_window(TileIndex viewer_tile, Region region);

/// A tile once loaded stays while a wider band would ask for it (0.4 of a tile wider, at most half of what the band
/// leaves), so that pacing across the band's edge loads nothing: to lose a tile the viewer walks a fifth of one. At
/// most nine a viewer; and a tile behind him has gone before he dents the one ahead.
double kept_band(double band);
TileWindow kept_window(const PlaceInTile& place, double band);

/// How far from a viewer, in any direction, the active tiles are sure to reach, metres: half of what the band leaves.
/// Detail must have faded out there.
double active_reach_m(double tile_m, double band);

/// How far a viewer may still walk, texels along the nearer axis, before `tile` becomes active for him; 0 when it is.
double texels_until_active(const TileGrid& grid, PostPos at_texels, TileIndex tile, double band);

/// One viewer's windows, clipped to the map.
struct ViewerTiles {
    TileIndex own;
    TileWindow loaded, active, kept;
};
ViewerTiles tiles_of_viewer(const TileGrid& grid, PostPos at_texels, double band);

/// What a tile is to the viewers together: the most that it is to one of them.
enum class Interest : std::uint8_t { None, Kept, Loaded, Active };
Interest interest_in(TileIndex tile, std::span<const ViewerTiles> viewers);

/// Chebyshev distance in tiles to the nearest viewer's own tile: the order in which tiles are loaded.
std::int32_t tiles_away(TileIndex tile, std::span<const ViewerTiles> viewers);

}  // namespace tilth
