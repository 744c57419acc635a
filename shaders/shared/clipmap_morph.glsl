// shared/clipmap_morph.glsl: how a clipmap level turns into the next coarser one. Compiled as GLSL and as C++.
// Floats: geometry for the eye, never persistent. Level l has a vertex every 2^l posts; "units" are 2^l posts.
//
//    viewer                                    d, Chebyshev distance from the viewer in units of level l
//      +---- hole of level l-1 ----|---- own posts ----|==== zone ====|-| outer border
//      0                      <= half/2 + 0.5          s              e  >= half - 1
//
// The window follows the viewer in even units, so its borders lie up to one unit off the centre. The zone ends
// kMorphSlack short of the nearest place a border can have and begins no earlier than the farthest place of the hole, so
// alpha is exactly 1 on the outer border and exactly 0 on the hole's, whatever the rounding of d.
#ifndef TILTH_SHARED_CLIPMAP_MORPH
#define TILTH_SHARED_CLIPMAP_MORPH
#include "shared/prelude.glsl"

SHARED_CONSTANT float kMorphSlack = 0.25f;  // units; d is off by less than 0.001

// Width of the zone: `blend` of n, as far as there is room between hole and border: (n - 9) / 4 units.
SHARED_FUNCTION float morph_zone_units(int n, float blend) {
    return min(blend * float(n), (float(n) - 9.0f) * 0.25f);
}

// 0: the level's own posts; 1: the surface of the next coarser level.
SHARED_FUNCTION float morph_alpha(float distance_units, int n, float zone_units) {
    float end = float(n - 1) * 0.5f - 1.0f - kMorphSlack;
    return min(max((distance_units - end) / zone_units + 1.0f, 0.0f), 1.0f);
}

// How much of a refinement shows: 0 on the ring's outer border and on its hole's, 1 from four units inside either.
SHARED_FUNCTION float refinement_fade(float distance_units, int n, bool is_coarsest) {
    float half_units = float(n - 1) * 0.5f;
    float from_hole = (distance_units - (half_units + 1.0f) * 0.5f - kMorphSlack) * 0.25f;
    float from_border = is_coarsest ? 1.0f : (half_units - 1.0f - kMorphSlack - distance_units) * 0.25f;
    return min(max(min(from_hole, from_border), 0.0f), 1.0f);
}

// The posts of level + 1 about post p of `level` on one axis, 0 <= p <= last. Equal if p is itself such a post; the last
// post of the map belongs to every level.
SHARED_FUNCTION int coarse_low(int p, int level, int last) { return p >= last ? last : (p >> (level + 1)) << (level + 1); }
SHARED_FUNCTION int coarse_high(int p, int level, int last) {
    int low = coarse_low(p, level, last);
    return low == p ? p : min(low + (2 << level), last);
}
// Where p lies between them, 0 to below 1.
SHARED_FUNCTION float coarse_weight(int p, int low, int high) {
    return high > low ? float(p - low) / float(high - low) : 0.0f;
}

// Height on a cell split along the diagonal from corner 00 to corner 11; exactly h00 at (0, 0).
SHARED_FUNCTION float cell_height(float h00, float h10, float h01, float h11, float tx, float tz) {
    return tx >= tz ? h00 + tx * (h10 - h00) + tz * (h11 - h10) : h00 + tz * (h01 - h00) + tx * (h11 - h01);
}

// The post that post p of a map repeated by reflection shows; n posts a side, period 2 (n - 1), p >= 0.
SHARED_FUNCTION int folded_post(int p, int n) {
    int within = p % (2 * (n - 1));
    return within < n ? within : 2 * (n - 1) - within;
}
#endif
