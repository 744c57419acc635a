// gl/write_payload.frag: writes what a texel pass hands over, for its tests.
//   writes  payload   RGBA32I   v_payload
//   writes  place     RGBA32I   texel x, z, and the rectangle's min x, z
flat in ivec4 v_rect;
flat in ivec4 v_payload;
layout(location = 0) out ivec4 payload;
layout(location = 1) out ivec4 place;
void main() {
    payload = v_payload;
    place = ivec4(ivec2(gl_FragCoord.xy), v_rect.xy);
}
