// gl/blit.frag: copies texels one to one.
//   reads   u_source   any colour format   the texel at the fragment's place + v_payload.xy
//   writes  texel      the target's format
uniform sampler2D u_source;
flat in ivec4 v_payload;
layout(location = 0) out vec4 texel;
void main() { texel = texelFetch(u_source, ivec2(gl_FragCoord.xy) + v_payload.xy, 0); }
