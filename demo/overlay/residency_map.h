// The residency map: which tiles are where, as coloured rectangles in a corner of the picture. Pure; no GL.
//
//     fill     the tile's state        frame   sampled by this frame (active)
//     dot      its codes are not in the store yet (dirty)
//     white    the viewer; grey: further viewers
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tilth/core/vec.h"
#include "tilth/terrain.h"

namespace tilth::demo {

/// Pixels of the picture, from its top left corner; half-open.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

struct ColouredRect {
    PixelRect rect;
    Vec3f colour;
};

/// How a tile's cell looks.
struct CellLook {
    Vec3f fill;
    std::optional<Vec3f> frame, dot;
    friend bool operator==(const CellLook&, const CellLook&) = default;
};

/// Of a tile that the terrain reports; nullptr: untouched ground, which holds no tile.
CellLook look_of(const TileReport* tile);

/// The tiles that the map shows: all of a grid of up to `most` x `most`, else a window of that size about the viewer's
/// tile, moved inside the grid. `most` >= 1.
TileWindow shown_tiles(const TileGrid& grid, TileIndex viewer, std::int32_t most);

/// What the map is made of.
struct ResidencyPlaces {
    TileGrid grid;
    GridSpec texels;                    ///< of the detail map: where its texels lie in the world
    std::span<const TileReport> tiles;  ///< in the order of their indices, as `Terrain::tiles` gives them
    std::span<const WorldPos> viewers;  ///< the first is the camera's own; at least one
};

/// Rectangles in the order in which they are painted, in the top right corner of a picture of that size. Empty where
/// the picture is too small to show anything (under 64 pixels a side).
std::vector<ColouredRect> residency_map(const ResidencyPlaces& places, int width, int height);

/// The map of a terrain as it is now.
std::vector<ColouredRect> residency_map(const Terrain& terrain, std::span<const WorldPos> viewers, int width,
                                        int height);

}  // namespace tilth::demo
