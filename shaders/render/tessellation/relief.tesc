// render/tessellation/relief.tesc: how finely a triangle of the finest level is split where there is detail under it.
//   reads   what render/terrain.vert (RELIEF_MESH) gives
//   gives   the same to relief.tese: a corner's place to the bit; the parts of each edge
//   int    u_refine_factor_most     most parts of an edge, 1..64
//   float  u_refine_edge_px         parts are about this long on the screen; 0: always the most
//   float  u_refine_px_per_radian   of the middle of the picture: 0.5 * height / tan(0.5 * vertical field of view)
// and those of render/relief.glsl.
//
// An edge is split if there is detail at both its ends, and by what its ends alone say, either way round alike: the two
// triangles at an edge split it alike. No part is shorter than a texel. A triangle with nothing to split stays as it
// is.
#include "render/relief_mesh.glsl"
#include "render/tessellation/edge_parts.glsl"

layout(vertices = 3) out;

uniform int u_refine_factor_most;
uniform float u_refine_edge_px, u_refine_px_per_radian;

in vec3 r_position_m[];
in float r_base_m[];
in float r_alpha[];
flat in ivec2 r_from_base[];
flat in int r_marked[];

out vec3 t_position_m[];
out float t_base_m[];
out float t_alpha[];
out ivec2 t_from_base[];

// The edge from vertex a to vertex b.
int parts(int a, int b) {
    if (r_marked[a] == 0 || r_marked[b] == 0) return 1;
    vec3 from_m = vec3(r_position_m[a].x, r_base_m[a], r_position_m[a].z);
    vec3 to_m = vec3(r_position_m[b].x, r_base_m[b], r_position_m[b].z);
    return edge_parts(from_m, to_m, u_refine_edge_px, u_refine_px_per_radian,
                      min(u_refine_factor_most, u_relief_per_post));
}

void main() {
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    t_position_m[gl_InvocationID] = r_position_m[gl_InvocationID];
    t_base_m[gl_InvocationID] = r_base_m[gl_InvocationID];
    t_alpha[gl_InvocationID] = r_alpha[gl_InvocationID];
    t_from_base[gl_InvocationID] = r_from_base[gl_InvocationID];
    if (gl_InvocationID != 0) return;
    int opposite_0 = parts(1, 2), opposite_1 = parts(2, 0), opposite_2 = parts(0, 1);
    int most = max(opposite_0, max(opposite_1, opposite_2));
    // Without three marks there is no detail inside: GL splits an inner level of 1 beside a split edge in 2 by itself.
    bool inside = r_marked[0] != 0 && r_marked[1] != 0 && r_marked[2] != 0;
    gl_TessLevelOuter[0] = float(opposite_0);
    gl_TessLevelOuter[1] = float(opposite_1);
    gl_TessLevelOuter[2] = float(opposite_2);
    gl_TessLevelInner[0] = float(inside ? most : min(most, 2));
}
