// render/tessellation/relief.tese: a point of a split triangle, displaced by the detail under it.
//   reads   relief.tesc's corners, the parts of each edge, render/relief.glsl
//   gives   what render/terrain.frag reads
//   mat4   u_clip_from_relative
//
// Corners are passed on. A point on an edge is k of f parts from the end that comes first by place and follows from the
// two ends and from integers alone (render/relief_mesh.glsl): the two triangles at the edge get the same bits. Only
// inside a triangle is a place a float.
//
// Triangles rather than quads: a triangle that is not split is the coarse mesh's, where the diagonal of a quad that is
// not split would be the driver's choice. The price: GL lays the points inside a triangle on smaller triangles about
// its middle, not on the lattice of texels, so that where every texel of an edge is a vertex a small error stays
// inside: of smooth, kinked and stepped stamps of 2 to 12 cm at 16 texels a post 0.06, 0.18 and 2.4 mm rms, a quarter
// to a third of what half as many parts leave (tests/render/tessellation_gl_test.cpp). render/geometry has none.
#include "render/relief_mesh.glsl"

layout(triangles, equal_spacing, ccw) in;

uniform mat4 u_clip_from_relative;

in vec3 t_position_m[];
in float t_base_m[];
in float t_alpha[];
in ivec2 t_from_base[];

out vec3 v_position_m;
out float v_alpha;
flat out int v_level;
invariant gl_Position;  // edges are shared by blocks of different programs
out float v_relief_m;  // what the mesh shows of the relief

vec3 base_of(int corner) { return vec3(t_position_m[corner].x, t_base_m[corner], t_position_m[corner].z); }

void pass_on(int corner) {
    v_position_m = t_position_m[corner];
    v_alpha = t_alpha[corner];
    v_relief_m = t_position_m[corner].y - t_base_m[corner];
    gl_Position = gl_in[corner].gl_Position;
}

void place(vec3 base_m, float relief_m) {
    vec3 position_m = displaced_m(base_m, relief_m);
    v_position_m = position_m;
    v_relief_m = position_m.y - base_m.y;
    gl_Position = u_clip_from_relative * vec4(position_m, 1.0);
}

// `share` of the way from corner a to corner b, of `parts` parts.
void on_edge(int a, int b, float share, float parts_wide) {
    int parts = int(parts_wide + 0.5);
    int k = int(share * float(parts) + 0.5);
    if (!edge_first(t_from_base[a], t_from_base[b])) {
        int c = a;
        a = b;
        b = c;
        k = parts - k;
    }
    float t = float(k) / float(parts);
    TILTH_PRECISE vec3 base_m = base_of(a) + t * (base_of(b) - base_of(a));
    TILTH_PRECISE float alpha = t_alpha[a] + t * (t_alpha[b] - t_alpha[a]);
    v_alpha = alpha;
    place(base_m, relief_point_m(t_from_base[a] * parts + k * (t_from_base[b] - t_from_base[a]), parts));
}

// Detail at a float place, texels from the texel `origin` of the window.
float relief_at_m(ivec2 origin, vec2 texels) {
    vec2 low = floor(texels);
    return relief_cell_m(origin + ivec2(low), texels - low);
}

void inside(vec3 at) {
    vec3 base_m = base_of(0) + at.y * (base_of(1) - base_of(0)) + at.z * (base_of(2) - base_of(0));
    v_alpha = dot(at, vec3(t_alpha[0], t_alpha[1], t_alpha[2]));
    ivec2 low = min(t_from_base[0], min(t_from_base[1], t_from_base[2]));
    vec2 posts = at.x * vec2(t_from_base[0] - low) + at.y * vec2(t_from_base[1] - low) +
                 at.z * vec2(t_from_base[2] - low);
    ivec2 origin = low * u_relief_per_post + u_relief_base_texel + ivec2(kReliefLift);
    place(base_m, relief_at_m(origin, posts * float(u_relief_per_post)));
}

void main() {
    v_level = 0;
    vec3 at = gl_TessCoord;
    if (at.x == 1.0) pass_on(0);
    else if (at.y == 1.0) pass_on(1);
    else if (at.z == 1.0) pass_on(2);
    else if (at.x == 0.0) on_edge(1, 2, at.z, gl_TessLevelOuter[0]);
    else if (at.y == 0.0) on_edge(2, 0, at.x, gl_TessLevelOuter[1]);
    else if (at.z == 0.0) on_edge(0, 1, at.y, gl_TessLevelOuter[2]);
    else inside(at);
}
