// render/parallax/parallax.glsl: a fragment of the coarse ground shows what its ray meets of the relief.
// Features: those of render/parallax/trace.glsl, and
//   PARALLAX_RANGE    what is searched is u_parallax_range_m; else what there is within 32 texels (u_relief_range)
//   PARALLAX_SHADOWS  self-shadowing (render/parallax/shadow.glsl)
//   PARALLAX_DEPTH    `depth_of` gives the depth of a point; REVERSED_DEPTH: clip depth is 0..1, 1 near
//   DEPTH_ONE_SIDED   nothing is searched above the ground: what is seen lies behind it; GL is told, early z stays
//   DEBUG_VIEW        the distance to the exact hit is told, at the cost of the exact method
// To be included before anything but directives: an extension is asked for.
#if defined(PARALLAX_DEPTH) && defined(DEPTH_ONE_SIDED)
#extension GL_ARB_conservative_depth : enable
#endif
#ifndef TILTH_RENDER_PARALLAX
#define TILTH_RENDER_PARALLAX
#include "render/parallax/trace.glsl"
#include "render/relief.glsl"
#include "render/relief_shown.glsl"
#include "render/terrain_inputs.glsl"
#ifdef PARALLAX_SHADOWS
#include "render/parallax/shadow.glsl"
#endif

#if defined(PARALLAX_DEPTH) && defined(DEPTH_ONE_SIDED) && defined(GL_ARB_conservative_depth)
#ifdef REVERSED_DEPTH
layout(depth_less) out float gl_FragDepth;
#else
layout(depth_greater) out float gl_FragDepth;
#endif
#endif

// Tangent of the least elevation that a ray, of sight or of light, is followed at.
uniform float u_parallax_least_tangent;
uniform vec2 u_relief_extremes_m;  // highest, lowest of all that the window shows

const float kRangeTexels = 32.0;     // about a texel, that u_relief_range tells of
const float kMostStepTexels = 1.5;   // along the ground, before the linear search takes more steps
const int kMostStepsTimes = 4;       // than it was told
#ifdef PARALLAX_RANGE
uniform vec2 u_parallax_range_m;  // highest, lowest
#endif

struct TracedRelief {
    vec3 position_m;  // relative to the eye; what the pixel shows
    float lit;        // share of the direct light that reaches it past the relief
    int fetches;
#ifdef DEBUG_VIEW
    float error_texels;  // along the ground, from what the exact method shows
#endif
};

// Metres (highest, lowest) to be searched along a ray through `at`: always the ground itself too.
vec2 searched_m(vec2 at, vec2 shift, float share) {
#ifdef PARALLAX_RANGE
    vec2 range = u_parallax_range_m;
#else
    // Node k is of the cells from texel 64 k to 64 (k + 1), and its texel's centre, (k + 0.5) / (size / 64), is to
    // stand in the middle of them, at 64 (k + 0.5): so the coordinate is the position over the size, with no offset.
    vec2 range = textureLod(u_relief_range, at / float(u_relief_size), 0.0).rg;
    // That is what there is within 32 texels. Farther off the ray is this far from the plane: what is higher, or deeper,
    // anywhere may be met there.
    float beyond_m = share * u_relief_texels_per_m * length(shift);
    if (u_relief_extremes_m.x * beyond_m > kRangeTexels) range.x = u_relief_extremes_m.x;
    if (-range.y * beyond_m > kRangeTexels) range.y = u_relief_extremes_m.y;
#endif
    return vec2(max(range.x, 0.0), min(range.y, 0.0));
}

// Horizontal way per way along the normal of the plane; `rise` is what that way would be, if it is not too flat.
vec2 limited_shift(vec2 across, float rise) {
    return across / max(max(rise, length(across) * u_parallax_least_tangent), 1e-6);
}

// `position_m`: of the fragment, relative to the eye. The coarse ground is the plane with `coarse_slope` below or above it by
// what the mesh shows of the relief (relief_shown.glsl). Where mesh and parallax share it, the mesh is only what the search
// begins with: all of the relief is traced, so that a pixel shows the same whatever the mesh's share is, and neither side of
// a blend can be told from the other. `fraction_m`: from the base post to the eye.
TracedRelief trace_pixel(vec3 position_m, vec2 coarse_slope, vec2 fraction_m) {
    float mesh_m = mesh_relief_m();
    vec3 base_m = vec3(position_m.x, position_m.y - mesh_m, position_m.z);
    float distance_m = length(base_m);
    float share = traced_share(distance_m) > 0.0 ? relief_share(distance_m) : 0.0;
    vec2 at = relief_texels(position_m.xz + fraction_m);
    // Heights above the plane are measured along y. Nothing behind the eye is searched.
    float eye_m = dot(coarse_slope, base_m.xz) - base_m.y;
    vec2 shift = limited_shift(position_m.xz, eye_m - mesh_m);
    vec2 searched = searched_m(at, shift, share) * (share * u_relief_texels_per_m);
    searched.x = min(searched.x, max(eye_m, 0.0) * u_relief_texels_per_m);
    float first = mesh_m * u_relief_texels_per_m;
    int steps = u_parallax_steps;
#ifdef PARALLAX_SECANT
    steps = int(clamp(length(shift) * (searched.x - searched.y) / kMostStepTexels, float(steps),
                      float(kMostStepsTimes * steps)));
#endif
    ReliefHit hit = trace_relief(at + shift * first, shift, share, searched.x, searched.y, first, steps);
    vec2 moved_m = (hit.at - at) / u_relief_texels_per_m;
    float height_m = hit.height / u_relief_texels_per_m;
    TracedRelief traced;
    // Where nothing is searched the pixel shows what the mesh shows, to the bit.
    traced.position_m = searched.x > searched.y
                            ? base_m + vec3(moved_m.x, dot(coarse_slope, moved_m) + height_m, moved_m.y)
                            : position_m;
    traced.fetches = hit.fetches;
    traced.lit = 1.0;
#ifdef PARALLAX_SHADOWS
    vec2 light_shift = limited_shift(u_to_light.xz, u_to_light.y - dot(coarse_slope, u_to_light.xz));
    traced.lit = relief_light(hit.at, hit.height, light_shift, share, searched.x, searched.y);
#endif
#ifdef DEBUG_VIEW
    vec2 whole = vec2(max(u_relief_extremes_m.x, 0.0), min(u_relief_extremes_m.y, 0.0)) * (share * u_relief_texels_per_m);
    whole.x = min(whole.x, max(eye_m, 0.0) * u_relief_texels_per_m);
    traced.error_texels = distance(hit.at, trace_exact(at + shift * first, shift, share, whole.x, whole.y).at);
#endif
    return traced;
}

#ifdef PARALLAX_DEPTH
uniform mat4 u_clip_from_relative;

float depth_of(vec3 position_m) {
    vec4 clip = u_clip_from_relative * vec4(position_m, 1.0);
    float depth = clip.z / max(clip.w, 1e-6);
#ifndef REVERSED_DEPTH
    depth = 0.5 * depth + 0.5;
#endif
    depth = gl_DepthRange.near + gl_DepthRange.diff * depth;
#ifdef DEPTH_ONE_SIDED
    // What was promised, whatever rounding does.
#ifdef REVERSED_DEPTH
    depth = min(depth, gl_FragCoord.z);
#else
    depth = max(depth, gl_FragCoord.z);
#endif
#endif
    return depth;
}
#endif
#endif
