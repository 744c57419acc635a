// derive/slopes.frag: partial derivatives of the height at every 2^level-th texel of a map.
//   reads   u_high, u_low   R16 unorm   height codes of the map, or of one tile of it
//   writes  new_slope       RG8 unorm   companded (slope_math.glsl), or RG16F with feature SLOPES_RG16F
// v_payload.xy: texel of the slope map minus texel of the target (0 where the slope map itself is drawn to).
// The texel (i, j) of mip level l is the slope at texel u_origin + (i << l, j << l) of the map: all levels are computed
// from the codes. Differences are one-sided at the map's border alone; what lies beyond the codes held repeats them.
// Feature BITS16: there is no low plane.
#include "shared/height_code.glsl"
#include "shared/slope_math.glsl"
flat in ivec4 v_payload;
uniform sampler2D u_high, u_low;
uniform ivec2 u_origin;                     // texel of the map at texel (0, 0) of the textures
uniform ivec2 u_first_held, u_last_held;    // texels of the map that the textures hold, inclusive
uniform ivec2 u_first_texel, u_last_texel;  // of the map, inclusive
uniform int u_level;
uniform float u_per_m;   // code quantum [m] / spacing [m]
uniform bool u_fourth;
layout(location = 0) out vec2 new_slope;

uint code_at(ivec2 texel) {
    texel = clamp(texel, u_first_held, u_last_held) - u_origin;
#ifdef BITS16
    return plane_bits(texelFetch(u_high, texel, 0).r) << 16;
#else
    return code_of_planes(texelFetch(u_high, texel, 0).r, texelFetch(u_low, texel, 0).r);
#endif
}

float slope_on(ivec2 texel, ivec2 axis, int position, int last) {
    uint before2 = 0u, after2 = 0u;
    if (u_fourth) {
        before2 = code_at(texel - 2 * axis);
        after2 = code_at(texel + 2 * axis);
    }
    return slope_along(before2, code_at(texel - axis), code_at(texel + axis), after2, position, last, u_fourth, u_per_m);
}

void main() {
    ivec2 texel = min(u_origin + ((ivec2(gl_FragCoord.xy) + v_payload.xy) << u_level), u_last_texel);
    ivec2 position = texel - u_first_texel, last = u_last_texel - u_first_texel;
    vec2 slope = vec2(slope_on(texel, ivec2(1, 0), position.x, last.x), slope_on(texel, ivec2(0, 1), position.y, last.y));
#ifdef SLOPES_RG16F
    new_slope = clamp(slope, vec2(-65504.0), vec2(65504.0));  // the largest half: no infinity
#else
    float size = length(slope);
    new_slope = vec2(float(slope_byte(slope.x, size)), float(slope_byte(slope.y, size))) / 255.0;
#endif
}
