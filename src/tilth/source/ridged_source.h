// Mountains from a number: the heights that are always there, when no elevation data is.
#pragma once

#include "tilth/source/raster_source.h"

namespace tilth {

struct RidgedSettings {
    std::uint64_t seed = 1;    ///< another seed, another range of mountains
    std::int32_t size = 1025;  ///< posts along each side, 2 to 16 384
    double relief_m = 200;     ///< the lowest post is at 0 m, the highest at this height; > 0
};

/// Ridged multifractal noise (Musgrave, in Ebert et al., Texturing & Modeling, ch. 16): crests where gradient noise
/// crosses zero, and each octave is weighted by the one above it, so crests are rough and valleys smooth.
///
/// The coarsest lattice has cells of size / 2 posts, so a crest stands about every size / 4; each octave halves the
/// cell and somewhat more than halves the amplitude, and the finest cell is not under 8 posts. With 200 m of relief on
/// 1 025 posts 1 m apart half of the ground is steeper than 34 degrees. The extremes are exactly 0 and relief_m (as a
/// float), by scaling. The same bits on every machine: gradients come from an integer hash, and all arithmetic is + - *
/// / sqrt and floor of IEEE doubles in a fixed order; no libm. Cost: computed once, 4 bytes a post; 1 025 x 1 025 posts
/// take about 0.15 s, 4 097 x 4 097 about 3 s.
/// Settings out of range are the caller's mistake and stop the program; what a user typed goes through `make_source`.
std::unique_ptr<RasterSource> make_ridged_source(const RidgedSettings& settings);

}  // namespace tilth
