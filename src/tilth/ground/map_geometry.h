// What a stamp must know of the map it goes to.
#pragma once

#include "tilth/ground/stamp.h"
#include "tilth/world/grid.h"
#include "tilth/world/height_codec.h"

namespace tilth {

/// One map: where its texels lie, how its codes read. For the detail map the grid's spacing is that of its texels.
struct MapGeometry {
    MapKind kind = MapKind::Coarse;
    GridSpec grid;
    HeightCodec codec;
    HeightPrecision precision = HeightPrecision::bits32;
};

}  // namespace tilth
