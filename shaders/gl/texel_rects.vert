// gl/texel_rects.vert: maps each instance's rectangle of texels to exactly those pixels of the target.
//   reads   a_rect      min_x, min_z, max_x, max_z [texels of the target, half-open]
//           a_payload   four integers for the fragment shader
// Drawn as a strip of four vertices. Corners lie on pixel edges, half a pixel from every sample: the rounding of the
// division (below 1/1000 pixel for 16 384 texels) cannot move a sample in or out.
uniform ivec2 u_target_size_texels;
layout(location = 0) in ivec4 a_rect;
layout(location = 1) in ivec4 a_payload;
flat out ivec4 v_rect;
flat out ivec4 v_payload;
void main() {
    ivec2 corner = ivec2((gl_VertexID & 1) == 0 ? a_rect.x : a_rect.z, (gl_VertexID & 2) == 0 ? a_rect.y : a_rect.w);
    v_rect = a_rect;
    v_payload = a_payload;
    gl_Position = vec4(vec2(2 * corner - u_target_size_texels) / vec2(u_target_size_texels), 0.0, 1.0);
}
