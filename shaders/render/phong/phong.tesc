// render/phong/phong.tesc: how finely a triangle of any level is split to be curved.
//   reads   what render/terrain.vert (PHONG) gives
//   gives   the same to phong.tese: a corner's place to the bit; the parts of each edge
//   int    u_phong_factor_most      most parts of an edge, 1..16
//   float  u_phong_edge_px          parts are about this long on the screen; 0: always the most
//   float  u_phong_px_per_radian    0.5 * height / tan(0.5 * vertical field of view)
//   float  u_phong_shape            0 flat .. 1 fully curved
//
// An edge is split if both its ends have weight and its middle rises enough to be seen, by what its ends alone say: the
// two triangles at an edge split it alike. On plains nothing is.
#include "render/phong/curved_edge.glsl"
#include "render/tessellation/edge_parts.glsl"

layout(vertices = 3) out;

uniform int u_phong_factor_most;
uniform float u_phong_edge_px, u_phong_px_per_radian, u_phong_shape;

// Less is not seen: what splitting changes pops in by no more than this.
const float kLeastBulgePx = 0.05;

in vec3 p_position_m[];
in float p_alpha[];
flat in int p_level[];
in vec2 p_slope[];
in float p_weight[];

out vec3 t_position_m[];
out float t_alpha[];
out int t_level[];
out vec2 t_slope[];
out float t_weight[];

int parts(int a, int b) {
    if (p_weight[a] <= 0.0 || p_weight[b] <= 0.0) return 1;
    float bulge_m = edge_bulge_m(p_position_m[a], p_slope[a], p_weight[a], p_position_m[b], p_slope[b], p_weight[b]);
    float rise_px = 0.25 * u_phong_shape * abs(bulge_m) * u_phong_px_per_radian;
    float distance_m = 0.5 * length(p_position_m[a] + p_position_m[b]);
    if (u_phong_edge_px > 0.0 && rise_px < kLeastBulgePx * distance_m) return 1;
    return edge_parts(p_position_m[a], p_position_m[b], u_phong_edge_px, u_phong_px_per_radian, u_phong_factor_most);
}

void main() {
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    t_position_m[gl_InvocationID] = p_position_m[gl_InvocationID];
    t_alpha[gl_InvocationID] = p_alpha[gl_InvocationID];
    t_level[gl_InvocationID] = p_level[gl_InvocationID];
    t_slope[gl_InvocationID] = p_slope[gl_InvocationID];
    t_weight[gl_InvocationID] = p_weight[gl_InvocationID];
    if (gl_InvocationID != 0) return;
    int opposite_0 = parts(1, 2), opposite_1 = parts(2, 0), opposite_2 = parts(0, 1);
    gl_TessLevelOuter[0] = float(opposite_0);
    gl_TessLevelOuter[1] = float(opposite_1);
    gl_TessLevelOuter[2] = float(opposite_2);
    gl_TessLevelInner[0] = float(max(opposite_0, max(opposite_1, opposite_2)));
}
