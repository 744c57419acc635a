// render/terrain.frag: shades the ground by the slope map, and draws the brush cursor on it.
//   reads   u_slopes   RG8 companded or (SLOPES_RG16F) RG16F   dh/dx, dh/dz at the posts of the map, see pool/slope_map.h
//   writes  colour     linear RGB, alpha 1; GL encodes it where the host enabled GL_FRAMEBUFFER_SRGB on an sRGB target
// Features: SLOPES_RG16F, MIRRORED; DETAIL: fine slopes are added (render/detail_slopes.glsl), RELIEF: from the relief
// window; PARALLAX: the pixel shows what its ray meets of the relief (render/parallax/parallax.glsl), PARALLAX_DEPTH: with
// its depth; DEBUG_VIEW: it tells something else than colour (render/debug_view.glsl).
#ifdef PARALLAX
#include "render/parallax/parallax.glsl"
#endif
#ifdef DEBUG_VIEW
#include "render/debug_view.glsl"
#endif
#include "render/shade.glsl"
#include "render/terrain_inputs.glsl"
#include "shared/slope_math.glsl"
#ifdef DETAIL
#include "render/detail_slopes.glsl"
#endif

uniform sampler2D u_slopes;
uniform vec2 u_slopes_size_posts;  // padded
uniform int u_slopes_last_level;
uniform vec2 u_base_stored_post;   // base post; MIRRORED: modulo the period of the reflection
uniform ivec2 u_stored_posts;
uniform vec2 u_fraction_m;
uniform float u_spacing_m;
uniform vec2 u_eye_tint;           // tint height = y * u_eye_tint.x + u_eye_tint.y
uniform vec3 u_cursor_m;           // x, z relative to the eye, radius; 0: none
uniform vec3 u_cursor_colour;

in vec3 v_position_m;
in float v_alpha;
flat in int v_level;
layout(location = 0) out vec4 colour;

// `posts`: position in the stored map. Level l holds every 2^l-th post; its texel (0, 0) is post (0, 0).
vec2 slope_at(vec2 posts, int wanted_level) {
    int level = min(wanted_level, u_slopes_last_level);
    // The level's last texel stands at its last post; beyond it lies padding.
    posts = min(posts, vec2(((u_stored_posts - 1) >> level) << level));
    vec2 stored = textureLod(u_slopes, (posts + 0.5 * float(1 << level)) / u_slopes_size_posts, float(level)).rg;
#ifdef SLOPES_RG16F
    return stored;
#else
    vec2 companded = vec2(slope_signed(stored.x), slope_signed(stored.y));
    return companded * slope_expansion(length(companded));
#endif
}

vec2 slope_here() {
    vec2 posts = (v_position_m.xz + u_fraction_m) / u_spacing_m + u_base_stored_post;
    vec2 last = vec2(u_stored_posts - 1);
    vec2 sign_of_fold = vec2(1.0);
#ifdef MIRRORED
    vec2 within = mod(posts, 2.0 * last);
    bvec2 odd = greaterThan(within, last);
    posts = mix(within, 2.0 * last - within, vec2(odd));
    sign_of_fold = vec2(1.0) - 2.0 * vec2(odd);
#endif
    posts = clamp(posts, vec2(0.0), last);
    vec2 slope = slope_at(posts, v_level);
    if (v_alpha > 0.0) slope = mix(slope, slope_at(posts, v_level + 1), v_alpha);
    return slope * sign_of_fold;
}

// A ring on the ground: as wide as 3 % of the radius, at least two pixels, with soft edges.
float cursor_cover(vec2 ground_m) {
    float pixel_m = fwidth(length(v_position_m.xz - u_cursor_m.xy));  // of the surface that is rasterised: it has no jumps
    float distance_m = length(ground_m - u_cursor_m.xy);
    float half_width_m = max(0.015 * u_cursor_m.z, pixel_m);
    return clamp((half_width_m - abs(distance_m - u_cursor_m.z)) / max(pixel_m, 1e-6) + 0.5, 0.0, 1.0);
}

void main() {
    vec3 position_m = v_position_m;
    SurfacePoint p;
    p.slope = slope_here();
    p.lit = 1.0;
#ifdef PARALLAX
    TracedRelief traced = trace_pixel(position_m, p.slope, u_fraction_m);
    position_m = traced.position_m;
    p.lit = traced.lit;
#ifdef PARALLAX_DEPTH
    gl_FragDepth = depth_of(position_m);
#endif
#endif
    p.from_eye_m = position_m;
    p.distance_m = length(position_m);
    p.to_eye = -position_m / max(p.distance_m, 1e-6);
#ifdef DETAIL
    // The footprint is that of the coarse surface: where a ray jumps from rim to floor, differences mean nothing.
    p.slope += detail_slope(position_m.xz, dFdx(v_position_m.xz), dFdy(v_position_m.xz), u_fraction_m);
#endif
    p.normal = normalize(vec3(-p.slope.x, 1.0, -p.slope.y));
    p.tint_height = position_m.y * u_eye_tint.x + u_eye_tint.y;
    vec3 shaded = shade(p);
    if (u_cursor_m.z > 0.0) shaded = mix(shaded, u_cursor_colour, 0.9 * cursor_cover(position_m.xz));
#ifdef DEBUG_VIEW
#ifdef PARALLAX
    shaded = debug_colour(v_position_m, v_level, u_fraction_m, shaded, traced);
#else
    shaded = debug_colour(v_position_m, v_level, u_fraction_m, shaded);
#endif
#endif
    colour = vec4(shaded, 1.0);
}
