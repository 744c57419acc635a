// render/debug_view.glsl: what a picture tells in place of its colours. Part of render/terrain.frag, under DEBUG_VIEW.
//   int    u_debug_view       enum DebugView (src/tilth/render/detail_settings.h)
//   ivec2  u_debug_base_tile  detail tile of the base post
//   vec3   u_debug_tile       where in that tile the base post stands, in tiles; tiles a metre, 0: no detail map
// Colours are linear RGB. Wireframe, level, tile and backend are shaded by the ground's light, so that its form shows;
// fetches and error are ramps from black to white, and nothing else.
//
// The error of a mesh is |relief that it shows - relief that there is| in texels, both as they are shared out with
// distance; of parallax how far along the ground the pixel is from what the exact method shows; of both the larger.
// Where slopes alone are shown no heights are at hand: dark blue, no red.
#ifndef TILTH_RENDER_DEBUG_VIEW
#define TILTH_RENDER_DEBUG_VIEW
#ifdef RELIEF
#include "render/relief.glsl"
#endif
#include "render/relief_shown.glsl"

uniform int u_debug_view;
uniform ivec2 u_debug_base_tile;
uniform vec3 u_debug_tile;

const int kDebugWireframe = 1, kDebugLevel = 2, kDebugTile = 3, kDebugBackend = 4, kDebugFetches = 5, kDebugError = 6;
const float kMostFetches = 32.0, kMostErrorTexels = 4.0;
const vec3 kErrorUnknown = vec3(0.0, 0.0, 0.25);

vec3 debug_hue(float turns, float saturation) {
    vec3 pure = clamp(abs(fract(turns + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(1.0), pure, saturation);
}

// Golden sections of the circle: neighbours are far apart, and no two of the first hundred are alike.
vec3 debug_level_colour(int level) { return debug_hue(0.618034 * float(level), 0.85); }

vec3 debug_tile_colour(vec3 position_m, vec2 fraction_m) {
    ivec2 tile = u_debug_base_tile + ivec2(floor((position_m.xz + fraction_m) * u_debug_tile.z + u_debug_tile.xy));
    float checker = ((tile.x + tile.y) & 1) == 0 ? 1.0 : 0.6;
    return checker * debug_hue(0.618034 * float(tile.x) + 0.754878 * float(tile.y), 0.6);
}

// Where the ground stood without what a mesh made of it.
vec3 debug_base_m(vec3 position_m) {
    return vec3(position_m.x, position_m.y - mesh_relief_m(), position_m.z);
}

// Displaced red, traced green, slopes alone blue, by their shares; grey without any detail.
vec3 debug_backend_colour(vec3 position_m) {
#if defined(RELIEF)
    float distance_m = length(debug_base_m(position_m));
    float displaced = displaced_share(distance_m), traced = traced_share(distance_m);
#ifndef RELIEF_MESH
    displaced = 0.0;
#endif
#ifndef PARALLAX
    traced = 0.0;
#endif
    return displaced * vec3(1.0, 0.25, 0.15) + traced * vec3(0.2, 1.0, 0.25) +
           max(1.0 - displaced - traced, 0.0) * vec3(0.25, 0.35, 1.0);
#elif defined(DETAIL)
    return vec3(0.25, 0.35, 1.0);
#else
    return vec3(0.6);
#endif
}

#ifdef RELIEF_MESH
float debug_mesh_error_texels(vec3 position_m, vec2 fraction_m) {
    vec2 at = relief_texels(position_m.xz + fraction_m);
    vec2 low = floor(at);
    float exact_m = relief_cell_m(ivec2(low), at - low);
    float share = displaced_share(length(debug_base_m(position_m)));
    return abs(v_relief_m - share * exact_m) * u_relief_texels_per_m;
}
#endif

// `position_m`: of the fragment, before parallax moves what it shows. `fraction_m`: from the base post to the eye.
#ifdef PARALLAX
vec3 debug_colour(vec3 position_m, int level, vec2 fraction_m, vec3 shaded, TracedRelief traced) {
#else
vec3 debug_colour(vec3 position_m, int level, vec2 fraction_m, vec3 shaded) {
#endif
    float fetches = 0.0;
    vec3 error = vec3(0.0);
#ifdef PARALLAX
    fetches = float(traced.fetches);
    error = vec3(traced.error_texels / kMostErrorTexels);
#endif
#if defined(RELIEF_MESH)
    error = max(error, vec3(debug_mesh_error_texels(position_m, fraction_m) / kMostErrorTexels));
#elif defined(DETAIL) && !defined(RELIEF)
    error = kErrorUnknown;
#endif
    float light = 0.35 + 0.65 * clamp(1.25 * dot(shaded, vec3(0.2126, 0.7152, 0.0722)), 0.0, 1.0);
    if (u_debug_view == kDebugWireframe) return debug_level_colour(level);
    if (u_debug_view == kDebugLevel) return light * debug_level_colour(level);
    if (u_debug_view == kDebugTile) return light * debug_tile_colour(position_m, fraction_m);
    if (u_debug_view == kDebugBackend) return light * debug_backend_colour(position_m);
    if (u_debug_view == kDebugFetches) return vec3(clamp(fetches / kMostFetches, 0.0, 1.0));
    if (u_debug_view == kDebugError) return clamp(error, 0.0, 1.0);
    return shaded;
}
#endif
