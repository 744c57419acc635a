// render/shade.glsl: the colour of the ground. THE HOST'S HOOK: a shader folder of the host's may replace this one file;
// it must define `vec3 shade(SurfacePoint p)`, which returns linear RGB, may declare its own uniforms and samplers (units
// 8 and up are left alone), and is free to use or not to use what terrain_inputs.glsl and phong.glsl offer.
#include "render/phong.glsl"

// Flat ground by height, steep ground by slope: from about 37 to 52 degrees.
vec3 tint(SurfacePoint p) {
    vec3 flat_colour = mix(u_low_colour, u_high_colour, smoothstep(0.0, 1.0, p.tint_height));
    return mix(u_steep_colour, flat_colour, smoothstep(0.62, 0.80, p.normal.y));
}

vec3 shade(SurfacePoint p) { return fogged(phong(p, tint(p)), p.distance_m); }
