// The floor of render/parallax/parallax.glsl: u_parallax_steps linear fetches of heights at the fragment's own place, and
// nothing is done with them. (Their sum moves the point by a billionth, so that none is left out.)
#ifndef TILTH_RENDER_PARALLAX
#define TILTH_RENDER_PARALLAX
#include "render/relief.glsl"
#include "render/terrain_inputs.glsl"

uniform int u_parallax_steps;

struct TracedRelief {
    vec3 position_m;
    float lit;
    int fetches;
};

TracedRelief trace_pixel(vec3 position_m, vec2 coarse_slope, vec2 fraction_m) {
    vec2 at = relief_texels(position_m.xz + fraction_m);
    float sum = 0.0;
    for (int i = 0; i < u_parallax_steps; ++i)
        sum += textureLod(u_relief_heights, (at + 0.5 + 0.001 * float(i)) / float(u_relief_size), 0.0).r;
    return TracedRelief(position_m + vec3(0.0, 1e-9 * sum, 0.0), 1.0, u_parallax_steps);
}
#endif
