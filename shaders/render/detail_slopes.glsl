// render/detail_slopes.glsl: slopes of the fine detail about the eye, to be added to those of the coarse map.
//   reads   u_detail     RG8 companded or (SLOPES_RG16F) RG16F   dh/dx, dh/dz of the detail height alone; texel (i, j) of
//                        a tile's texture lies u_detail_apron texels before the tile's own texel (i, j)
//   RELIEF: u_relief_slopes holds the same about the eye without borders (pool/relief_window.h) and is read instead
//   DETAIL_WINDOW: ground on the border of tiles; u_detail is the tile at the window's low corner, the others follow
//                  along +x, +z and both; each tap chooses its tile, and what lies beyond the window adds nothing
// Positions are texels from the first interior texel of the tile (of the window); a whole number is a texel's centre.
//
// Tiles have no mips. A pixel that covers more than a texel takes four taps spread over it, in the pattern of a rotated
// grid: four different places along either axis of the screen, so that a long footprint of ground seen at a grazing angle
// is cut in four and a square one in 2 x 2. Where that leaves more than kFadeToTexels to a tap, detail has faded. Taps
// are at most 7 texels off the fragment (3/8 of 16 + 1/8 of 8); kDetailTapTexels in detail_blocks.h holds a bound.
#ifndef TILTH_RENDER_DETAIL_SLOPES
#define TILTH_RENDER_DETAIL_SLOPES
#include "shared/slope_math.glsl"

#ifdef RELIEF
uniform sampler2D u_relief_slopes;
uniform float u_relief_slopes_size;  // texels a side
#else
uniform sampler2D u_detail;
#endif
uniform vec2 u_detail_base_texels;  // the base post; RELIEF: in window texels
uniform float u_detail_texels_per_m;
uniform float u_detail_apron, u_detail_stored_size;
uniform vec4 u_detail_map_edge;     // first texel of the map x, z; last texel x, z
uniform float u_detail_reach_m;     // horizontal distance at which nothing is left
#ifdef DETAIL_WINDOW
uniform sampler2D u_detail_x, u_detail_z, u_detail_xz;
uniform float u_detail_tile_texels;
uniform vec2 u_detail_window_texels;
#endif

// Texels per tap at which detail begins to fade and is gone. Chosen by eye, walking at 2 m.
const float kFadeFromTexels = 1.0, kFadeToTexels = 4.0;

vec2 signed_slope(vec2 stored) {
#ifdef SLOPES_RG16F
    return stored;
#else
    return vec2(slope_signed(stored.x), slope_signed(stored.y));
#endif
}

// 1 below `from`, 0 from `to` on, smooth at both ends.
float faded(float x, float from, float to) {
    float t = clamp((to - x) / (to - from), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Where the taps of a pixel lie [texels]: at + near, at + far, at - near, at - far; only the first where they coincide.
struct Footprint {
    vec2 at, near, far;
    int taps;
};

// The slope (companded) at one tap, if it lies in the texels from `low` to below `high` of the tile whose first interior
// texel is `low`. textureLod: derivatives do not exist in a branch.
#ifdef RELIEF
vec2 relief_tap(vec2 texels) {
    return signed_slope(textureLod(u_relief_slopes, (texels + 0.5) / u_relief_slopes_size, 0.0).rg);
}
#else
vec2 tap(sampler2D tile, vec2 low, vec2 high, vec2 texels) {
    texels = clamp(texels, u_detail_map_edge.xy, u_detail_map_edge.zw);
    vec2 slope = signed_slope(textureLod(tile, (texels - low + (u_detail_apron + 0.5)) / u_detail_stored_size, 0.0).rg);
#ifdef DETAIL_WINDOW
    bool here = all(greaterThanEqual(texels, low)) && all(lessThan(texels, high));
    return here ? slope : vec2(0.0);
#else
    return slope;
#endif
}
#endif

#ifdef DETAIL_WINDOW
// The sum of the taps that lie in the tile at (x, z) of the window. A loop of no turn in the place of an `if`, where the
// pixel does not touch the tile: software GL runs both sides of every `if` and pays for their fetches, but skips a loop.
vec2 window_sum(sampler2D tile, float x, float z, Footprint print) {
    vec2 low = vec2(x, z) * u_detail_tile_texels;
    vec2 high = min(low + u_detail_tile_texels, u_detail_window_texels);
    vec2 room = max(abs(print.near), abs(print.far)) + 1.0;
    bool touched = all(greaterThan(print.at + room, low)) && all(lessThan(print.at - room, high));
    int taps = touched ? print.taps : 0;
    vec2 sum = vec2(0.0), offset = print.near, next = print.far;
    for (int i = 0; i < taps; ++i) {
        sum += tap(tile, low, high, print.at + offset);
        vec2 opposite = -offset;
        offset = next;
        next = opposite;
    }
    return sum;
}
#endif

// `ground_m`: metres from the eye; dx_m, dy_m: how it changes from pixel to pixel, taken where control flow is uniform.
vec2 detail_slope(vec2 ground_m, vec2 dx_m, vec2 dy_m, vec2 fraction_m) {
    vec2 dx = dx_m * u_detail_texels_per_m, dy = dy_m * u_detail_texels_per_m;
    float x_texels = length(dx), y_texels = length(dy);
    float wide = max(x_texels, y_texels), per_tap = max(0.25 * wide, 0.5 * min(x_texels, y_texels));
    float weight = faded(length(ground_m), 0.5 * u_detail_reach_m, u_detail_reach_m) *
                   faded(per_tap, kFadeFromTexels, kFadeToTexels);
    // A triangle without area may have any derivative, even NaN.
    if (!(per_tap < kFadeToTexels && weight > 0.0)) return vec2(0.0);
    // The taps' spread makes up for what a pixel of w texels is wider than a filtered texel, variance (w^2 - 1) / 12; 0
    // where a texel covers the pixel.
    float spread = sqrt(1.0 - 1.0 / max(wide * wide, 1.0));
    Footprint print;
    print.near = spread * (0.125 * dx + 0.375 * dy);
    print.far = spread * (0.375 * dx - 0.125 * dy);
    print.at = (ground_m + fraction_m) * u_detail_texels_per_m + u_detail_base_texels;
#if defined(RELIEF)
    vec2 companded = 0.25 * (relief_tap(print.at + print.near) + relief_tap(print.at + print.far) +
                             relief_tap(print.at - print.near) + relief_tap(print.at - print.far));
#elif defined(DETAIL_WINDOW)
    print.taps = spread > 0.0 ? 4 : 1;
    vec2 companded = (window_sum(u_detail, 0.0, 0.0, print) + window_sum(u_detail_x, 1.0, 0.0, print) +
                      window_sum(u_detail_z, 0.0, 1.0, print) + window_sum(u_detail_xz, 1.0, 1.0, print)) /
                     float(print.taps);
#else
    // Always four: one fetch and four in the branches of an `if` would be five on software GL.
    vec2 companded = 0.25 * (tap(u_detail, vec2(0.0), vec2(0.0), print.at + print.near) +
                             tap(u_detail, vec2(0.0), vec2(0.0), print.at + print.far) +
                             tap(u_detail, vec2(0.0), vec2(0.0), print.at - print.near) +
                             tap(u_detail, vec2(0.0), vec2(0.0), print.at - print.far));
#endif
#ifndef SLOPES_RG16F
    companded *= slope_expansion(length(companded));
#endif
    return weight * companded;
}
#endif
