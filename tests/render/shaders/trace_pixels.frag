// One fragment of the ground to a pixel through render/parallax/parallax.glsl.
//   reads   u_fragments   RGBA32F   position [m from the eye]
//   writes  shown         RGBA32F   position shown; fetches, or (PARALLAX_DEPTH) its depth
//           told          RGBA32F   heights searched, highest and lowest [m]; light; error [texels]
#include "render/parallax/parallax.glsl"

uniform sampler2D u_fragments;
uniform vec2 u_coarse_slope, u_fraction_m;
layout(location = 0) out vec4 shown;
layout(location = 1) out vec4 told;

void main() {
    vec3 position_m = texelFetch(u_fragments, ivec2(gl_FragCoord.xy), 0).xyz;
    TracedRelief traced = trace_pixel(position_m, u_coarse_slope, u_fraction_m);
    shown = vec4(traced.position_m, float(traced.fetches));
    told = vec4(searched_m(relief_texels(position_m.xz + u_fraction_m), vec2(0.0), 1.0), traced.lit, 0.0);
#ifdef DEBUG_VIEW
    told.w = traced.error_texels;
#endif
#ifdef PARALLAX_DEPTH
    shown.w = depth_of(traced.position_m);
    gl_FragDepth = shown.w;
#endif
}
