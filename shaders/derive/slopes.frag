// derive/slopes.frag: partial derivatives of the height at every 2^level-th post.
//   reads   u_high, u_low   R16 unorm   height codes of the whole map, texel = post
//   writes  new_slope       RG8 unorm   companded (slope_math.glsl), or RG16F with feature SLOPES_RG16F
// The texel (i, j) of mip level l is the slope at post (i << l, j << l): all levels are computed from the codes.
// Feature BITS16: there is no low plane.
#include "shared/height_code.glsl"
#include "shared/slope_math.glsl"
uniform sampler2D u_high, u_low;
uniform ivec2 u_last_post;
uniform int u_level;
uniform float u_per_m;   // code quantum [m] / spacing [m]
uniform bool u_fourth;
layout(location = 0) out vec2 new_slope;

uint code_at(ivec2 post) {
    post = clamp(post, ivec2(0), u_last_post);
#ifdef BITS16
    return plane_bits(texelFetch(u_high, post, 0).r) << 16;
#else
    return code_of_planes(texelFetch(u_high, post, 0).r, texelFetch(u_low, post, 0).r);
#endif
}

float slope_on(ivec2 post, ivec2 axis, int position, int last) {
    uint before2 = 0u, after2 = 0u;
    if (u_fourth) {
        before2 = code_at(post - 2 * axis);
        after2 = code_at(post + 2 * axis);
    }
    return slope_along(before2, code_at(post - axis), code_at(post + axis), after2, position, last, u_fourth, u_per_m);
}

void main() {
    ivec2 post = min(ivec2(gl_FragCoord.xy) << u_level, u_last_post);
    vec2 slope = vec2(slope_on(post, ivec2(1, 0), post.x, u_last_post.x), slope_on(post, ivec2(0, 1), post.y, u_last_post.y));
#ifdef SLOPES_RG16F
    new_slope = clamp(slope, vec2(-65504.0), vec2(65504.0));  // the largest half: no infinity
#else
    float size = length(slope);
    new_slope = vec2(float(slope_byte(slope.x, size)), float(slope_byte(slope.y, size))) / 255.0;
#endif
}
