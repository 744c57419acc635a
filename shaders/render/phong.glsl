// render/phong.glsl: light on a surface, and air before it.
#ifndef TILTH_RENDER_PHONG
#define TILTH_RENDER_PHONG
#include "render/terrain_inputs.glsl"

// Ambient, diffuse and specular light (Phong). Ambient falls by a quarter from ground that faces the sky to a wall, which
// sees only half of it.
vec3 phong(SurfacePoint p, vec3 albedo) {
    float facing = dot(p.normal, u_to_light);
    float ambient = u_ambient * (0.5 + 0.5 * p.normal.y);
    vec3 colour = albedo * (ambient + u_diffuse * p.lit * max(facing, 0.0));
    if (facing > 0.0) {
        vec3 mirrored = 2.0 * facing * p.normal - u_to_light;
        colour += p.lit * u_specular * pow(max(dot(mirrored, p.to_eye), 0.0), u_specular_exponent);
    }
    return colour;
}

vec3 fogged(vec3 colour, float distance_m) {
    float thickness = u_fog_density * distance_m;
    return mix(u_fog_colour, colour, exp(-thickness * thickness));
}
#endif
