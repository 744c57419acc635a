// render/relief.glsl: fine detail about the eye as heights, for the backends that show it as relief.
//   reads   u_relief_heights   R32F    metres of detail; texel (i, j) of the map at (i, j) modulo the window's size
//           u_relief_pyramid   RG32F   (highest, lowest) metre of the cells of a node; level l: nodes of 2^(l+1) cells a side
//           u_relief_range     RG32F   (highest, lowest) of 3 x 3 of the coarsest nodes, linear filtering
// (pool/relief_window.h). A position in "window texels" is a map texel up to a multiple of the window's size; a whole
// number is a texel's centre. Floats for the eye only.
//
// The relief that shows at a distance d from the eye is relief_share(d) of the detail: a mesh shows displaced_share(d) of the
// detail, and where that is less, where traced_share(d) is above 0, parallax brings what it shows to the whole.
#ifndef TILTH_RENDER_RELIEF
#define TILTH_RENDER_RELIEF
#include "shared/clipmap_morph.glsl"

#ifndef TILTH_PRECISE
#define TILTH_PRECISE  // relief_mesh.glsl says more
#endif

uniform sampler2D u_relief_heights, u_relief_pyramid, u_relief_range;
uniform int u_relief_size;            // texels a side, a power of two
uniform ivec2 u_relief_base_texel;    // texel of the base post, 0 .. size - 1
uniform int u_relief_per_post;        // texels between two posts
uniform float u_relief_texels_per_m;
uniform vec4 u_relief_fade_m;         // displaced relief is whole up to x, gone from y on; all relief up to z, from w on

// 1 up to `from`, 0 from `to` on, smooth at both ends.
float relief_fade(float distance_m, float from_m, float to_m) {
    TILTH_PRECISE float t = clamp((to_m - distance_m) / (to_m - from_m), 0.0, 1.0);
    TILTH_PRECISE float whole = t * t * (3.0 - 2.0 * t);
    return whole;
}

float relief_share(float distance_m) { return relief_fade(distance_m, u_relief_fade_m.z, u_relief_fade_m.w); }

float displaced_share(float distance_m) {
    return min(relief_fade(distance_m, u_relief_fade_m.x, u_relief_fade_m.y), relief_share(distance_m));
}

float traced_share(float distance_m) { return relief_share(distance_m) - displaced_share(distance_m); }

ivec2 relief_wrapped(ivec2 texel) { return texel & (u_relief_size - 1); }

// Metres of detail at a texel of the window.
float relief_texel_m(ivec2 texel) { return texelFetch(u_relief_heights, relief_wrapped(texel), 0).r; }

// The same at `t`, 0 to 1, in the cell that begins at `texel`, on the contract's triangles.
float relief_cell_m(ivec2 texel, vec2 t) {
    float h00 = relief_texel_m(texel), h10 = relief_texel_m(texel + ivec2(1, 0));
    float h01 = relief_texel_m(texel + ivec2(0, 1)), h11 = relief_texel_m(texel + ivec2(1));
    TILTH_PRECISE float height = cell_height(h00, h10, h01, h11, t.x, t.y);
    return height;
}

// The window texel at metres from the base post.
vec2 relief_texels(vec2 from_base_m) { return from_base_m * u_relief_texels_per_m + vec2(u_relief_base_texel); }
#endif
