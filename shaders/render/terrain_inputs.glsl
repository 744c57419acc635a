// render/terrain_inputs.glsl: what a fragment of the ground knows about itself.
#ifndef TILTH_RENDER_TERRAIN_INPUTS
#define TILTH_RENDER_TERRAIN_INPUTS

// One point of the visible surface. Metres; +y up; the ground plane is (x, z).
struct SurfacePoint {
    vec3 from_eye_m;   // position relative to the eye (world axes)
    float distance_m;  // length of it
    vec3 to_eye;       // unit
    vec3 normal;       // unit, from the slope
    vec2 slope;        // dh/dx, dh/dz, metres per metre: of the coarse map and of fine detail near the eye
    float lit;         // share of the direct light that reaches it: below 1 in the shadow of fine detail
    float tint_height; // height in u_tint_low_m .. u_tint_high_m as 0 .. 1, not clamped
};

// Colours are linear RGB.
uniform vec3 u_to_light;  // unit
uniform float u_ambient, u_diffuse, u_specular, u_specular_exponent;
uniform vec3 u_fog_colour;
uniform float u_fog_density;  // per metre
uniform vec3 u_low_colour, u_high_colour, u_steep_colour;
#endif
