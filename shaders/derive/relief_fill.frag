// derive/relief_fill.frag: detail of one tile, or untouched ground, into the relief window.
//   reads   u_high, u_low   R16 unorm   height codes of the tile (shared/height_code.glsl)
//           u_slopes        RG8 companded or RG16F (feature SLOPES_RG16F), of the same texels
//   writes  new_height_m    R32F        metres of detail
//           new_slope       as u_slopes
// v_payload.xy: texel of the tile's textures minus texel of the window; v_payload.z: 1 to read the tile, 0 for
// untouched ground. Feature BITS16: there is no low plane.
#include "shared/height_code.glsl"
flat in ivec4 v_payload;
uniform sampler2D u_high, u_low, u_slopes;
uniform float u_code_quantum_m;
layout(location = 0) out float new_height_m;
layout(location = 1) out vec2 new_slope;

#ifdef SLOPES_RG16F
const vec2 kFlat = vec2(0.0), kQuarterStep = vec2(0.0);
#else
// A store that rounds and one that truncates both give the byte back.
const vec2 kFlat = vec2(128.0 / 255.0), kQuarterStep = vec2(0.25 / 255.0);
#endif

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy) + v_payload.xy;
    float height_m = 0.0;
    vec2 slope = kFlat;
    for (int read = 0; read < v_payload.z; ++read) {  // not an if: software GL runs both sides of one
#ifdef BITS16
        uint code = plane_bits(texelFetch(u_high, texel, 0).r) << 16;
#else
        uint code = code_of_planes(texelFetch(u_high, texel, 0).r, texelFetch(u_low, texel, 0).r);
#endif
        height_m = float(int(code ^ 0x80000000u)) * u_code_quantum_m;  // the code minus 2^31
        slope = texelFetch(u_slopes, texel, 0).rg;
    }
    new_height_m = height_m;
    new_slope = slope + kQuarterStep;
}
