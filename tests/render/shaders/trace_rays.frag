// One ray to a pixel through render/parallax/trace.glsl.
//   reads   u_rays   RGBA32F   at, shift [texels]
//   writes  found    RGBA32F   hit [window texels], its height [texels], fetches; LIGHT: w is the light there
#include "render/parallax/trace.glsl"
#ifdef LIGHT
#include "render/parallax/shadow.glsl"
#endif

uniform sampler2D u_rays;
uniform float u_share, u_highest, u_lowest;
uniform vec2 u_light_shift;
layout(location = 0) out vec4 found;

void main() {
    vec4 ray = texelFetch(u_rays, ivec2(gl_FragCoord.xy), 0);
    ReliefHit hit = trace_relief(ray.xy, ray.zw, u_share, u_highest, u_lowest, 0.0, u_parallax_steps);
    found = vec4(hit.at, hit.height, float(hit.fetches));
#ifdef LIGHT
    found.w = relief_light(hit.at, hit.height, u_light_shift, u_share, u_highest, u_lowest);
#endif
}
