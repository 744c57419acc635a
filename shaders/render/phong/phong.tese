// render/phong/phong.tese: a point of a curved triangle (render/phong/curved_edge.glsl).
//   reads   phong.tesc's corners and the parts of each edge
//   gives   what render/terrain.frag reads
//   mat4   u_clip_from_relative
//   float  u_phong_shape
//
// Corners are passed on. A point on an edge is k of f parts from the end that comes first by place: the two triangles
// at the edge get the same bits. Heights are sums of differences, so that what is flat stays flat to the bit.
#include "render/phong/curved_edge.glsl"

layout(triangles, equal_spacing, ccw) in;

uniform mat4 u_clip_from_relative;
uniform float u_phong_shape;

in vec3 t_position_m[];
in float t_alpha[];
in int t_level[];
in vec2 t_slope[];
in float t_weight[];

out vec3 v_position_m;
out float v_alpha;
flat out int v_level;
invariant gl_Position;  // edges are shared by blocks of different programs

float bulge_m(int a, int b) {
    return edge_bulge_m(t_position_m[a], t_slope[a], t_weight[a], t_position_m[b], t_slope[b], t_weight[b]);
}

void pass_on(int corner) {
    v_position_m = t_position_m[corner];
    v_alpha = t_alpha[corner];
    gl_Position = gl_in[corner].gl_Position;
}

void place(vec3 position_m, float alpha) {
    v_position_m = position_m;
    v_alpha = alpha;
    gl_Position = u_clip_from_relative * vec4(position_m, 1.0);
}

// `share` of the way from corner a to corner b, of `parts` parts.
void on_edge(int a, int b, float share, float parts_wide) {
    int parts = int(parts_wide + 0.5);
    int k = int(share * float(parts) + 0.5);
    vec2 a_m = t_position_m[a].xz, b_m = t_position_m[b].xz;
    if (b_m.y < a_m.y || (b_m.y == a_m.y && b_m.x < a_m.x)) {
        int c = a;
        a = b;
        b = c;
        k = parts - k;
    }
    precise float t = float(k) / float(parts);
    precise float rise_m = u_phong_shape * (t * (1.0 - t)) * bulge_m(a, b);
    precise vec3 position_m = t_position_m[a] + t * (t_position_m[b] - t_position_m[a]) + vec3(0.0, rise_m, 0.0);
    precise float alpha = t_alpha[a] + t * (t_alpha[b] - t_alpha[a]);
    place(position_m, alpha);
}

void inside(vec3 at) {
    float rise_m = u_phong_shape *
                   (at.x * at.y * bulge_m(0, 1) + at.y * at.z * bulge_m(1, 2) + at.z * at.x * bulge_m(2, 0));
    vec3 position_m = t_position_m[0] + at.y * (t_position_m[1] - t_position_m[0]) +
                      at.z * (t_position_m[2] - t_position_m[0]) + vec3(0.0, rise_m, 0.0);
    place(position_m, dot(at, vec3(t_alpha[0], t_alpha[1], t_alpha[2])));
}

void main() {
    v_level = t_level[0];
    vec3 at = gl_TessCoord;
    if (at.x == 1.0) pass_on(0);
    else if (at.y == 1.0) pass_on(1);
    else if (at.z == 1.0) pass_on(2);
    else if (at.x == 0.0) on_edge(1, 2, at.z, gl_TessLevelOuter[0]);
    else if (at.y == 0.0) on_edge(2, 0, at.x, gl_TessLevelOuter[1]);
    else if (at.z == 0.0) on_edge(0, 1, at.y, gl_TessLevelOuter[2]);
    else inside(at);
}
