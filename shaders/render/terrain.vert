// render/terrain.vert: a vertex of a clipmap block or of a stitch, from the height planes.
//   reads  u_high_plane, u_low_plane   R16 unorm   height code, texel (i, j) = post (i, j); BITS16: no low plane
//   gives  metres relative to the eye, the share of the next coarser level, the level
// Features: BITS16, MIRRORED (the map is repeated by reflection), and of the first three at most one of
//   ALL_OWN       blocks in which no vertex morphs and none is refined: one fetch of the planes a vertex
//   ALL_MORPHING  blocks that are not refined
//   ALL_REFINED   blocks that are
//   RELIEF_MESH   the vertex is displaced by fine detail, and a geometry or tessellation stage follows
//   PHONG         triangles are curved by a tessellation stage that follows (render/phong); not with ALL_REFINED
// which leave out what their blocks do not need; software GL, and a GPU whose vertices diverge, would pay for it. They
// give the bits that the general program gives.
//
// Every level computes a position by the same expression from the post's integer index, so a vertex that two levels (or
// a block and a stitch) share is the same to the last bit. Codes and posts are subtracted as integers: nothing large
// becomes a float near the eye.
#ifdef RELIEF_MESH
#include "render/relief_mesh.glsl"
#endif
#include "shared/clipmap_morph.glsl"
#include "shared/height_code.glsl"
#include "shared/slope_math.glsl"

layout(location = 0) in ivec2 block_origin;  // units of 2^level posts
layout(location = 1) in ivec2 block_size;    // quads; 0 on one axis for a stitch
layout(location = 2) in ivec2 block_levels;  // of the vertices, of the surface: one coarser where it is refined

uniform sampler2D u_high_plane, u_low_plane;
uniform ivec2 u_last_post;     // of the world
uniform ivec2 u_stored_posts;  // of the textures
uniform ivec2 u_base_post;     // at or before the eye
uniform vec2 u_fraction_m;     // from the base post to the eye
uniform float u_spacing_m;
uniform uint u_eye_code;       // near the eye's height
uniform float u_eye_above_code_m;
uniform float u_code_quantum_m;
uniform int u_n;               // vertices a side of a window
uniform float u_zone_units;    // width of the morph zone
uniform int u_coarsest_level;  // it does not morph
uniform mat4 u_clip_from_relative;
uniform samplerBuffer u_node_weights;  // how much of a refinement shows, see clipmap_refinement.h
uniform ivec4 u_node_grids[16];        // of each level: first node x, z; nodes a row; index of the first weight

invariant gl_Position;
#ifdef RELIEF_MESH
out vec3 r_position_m;        // relative to the eye, displaced; what gl_Position is made from
out float r_base_m;           // height before that
out float r_alpha;
flat out ivec2 r_from_base;   // posts from the base post
flat out int r_marked;        // 1 where there is detail about the vertex: edges between two such may be split
#elif defined(PHONG)
out vec3 p_position_m;  // relative to the eye
out float p_alpha;
flat out int p_level;
out vec2 p_slope;       // of the ground, dh/dx, dh/dz
out float p_weight;     // how much curvature shows
#include "render/phong/phong_vertex.glsl"
#else
out vec3 v_position_m;  // relative to the eye
out float v_alpha;
flat out int v_level;
#endif

const int kMeshVertices = 33;  // a side: kBlockQuads + 1

float height_m(int x, int z) {
#ifdef MIRRORED
    ivec2 texel = ivec2(folded_post(x, u_stored_posts.x), folded_post(z, u_stored_posts.y));
#else
    ivec2 texel = ivec2(x, z);
#endif
#ifdef BITS16
    uint code = plane_bits(texelFetch(u_high_plane, texel, 0).r) << 16;
#else
    uint code = code_of_planes(texelFetch(u_high_plane, texel, 0).r, texelFetch(u_low_plane, texel, 0).r);
#endif
    return code_difference(code, u_eye_code) * u_code_quantum_m - u_eye_above_code_m;
}

vec2 ground_m(int x, int z) { return vec2(ivec2(x, z) - u_base_post) * u_spacing_m - u_fraction_m; }

float distance_units(int level, vec2 at_m) {
    return max(abs(at_m.x), abs(at_m.y)) / (u_spacing_m * float(1 << level));
}

float alpha_at(int level, int x, int z) {
    return level < u_coarsest_level ? morph_alpha(distance_units(level, ground_m(x, z)), u_n, u_zone_units) : 0.0;
}

// The height of a vertex of `level`, morphed. A post of the next coarser level stays exactly where it is.
float vertex_m(int level, int x, int z) {
    float height = height_m(x, z);
    float alpha = alpha_at(level, x, z);
    int x0 = coarse_low(x, level, u_last_post.x), x1 = coarse_high(x, level, u_last_post.x);
    int z0 = coarse_low(z, level, u_last_post.y), z1 = coarse_high(z, level, u_last_post.y);
    if (alpha <= 0.0 || (x0 == x1 && z0 == z1)) return height;
    float coarse = cell_height(height_m(x0, z0), height_m(x1, z0), height_m(x0, z1), height_m(x1, z1),
                               coarse_weight(x, x0, x1), coarse_weight(z, z0, z1));
    return alpha < 1.0 ? height + alpha * (coarse - height) : coarse;
}

float node_weight(ivec4 grid, int x, int z) {
    return texelFetch(u_node_weights, grid.w + (z - grid.y) * grid.z + x - grid.x).r;
}

float refinement_at(int level, int x, int z) {
    int shift = level + 5;  // 32 units
    int node_x = x >> shift, node_z = z >> shift;
    float scale = 1.0 / float(1 << shift);
    float tx = float(x - (node_x << shift)) * scale, tz = float(z - (node_z << shift)) * scale;
    ivec4 grid = u_node_grids[level];
    float near = mix(node_weight(grid, node_x, node_z), node_weight(grid, node_x + 1, node_z), tx);
    float far = mix(node_weight(grid, node_x, node_z + 1), node_weight(grid, node_x + 1, node_z + 1), tx);
    return mix(near, far, tz) *
           refinement_fade(distance_units(level, ground_m(x, z)), u_n, level == u_coarsest_level);
}

// The height of a vertex of the level below `level` on the surface of `level`: exactly that surface where the refinement
// is 0 and at the surface's own vertices.
float refined_m(int level, int x, int z) {
    int fine = level - 1;
    int x0 = coarse_low(x, fine, u_last_post.x), x1 = coarse_high(x, fine, u_last_post.x);
    int z0 = coarse_low(z, fine, u_last_post.y), z1 = coarse_high(z, fine, u_last_post.y);
    float base = vertex_m(level, x0, z0);
    if (x0 != x1 || z0 != z1)
        base = cell_height(base, vertex_m(level, x1, z0), vertex_m(level, x0, z1), vertex_m(level, x1, z1),
                           coarse_weight(x, x0, x1), coarse_weight(z, z0, z1));
    float weight = refinement_at(level, x, z);
    return weight > 0.0 ? base + weight * (height_m(x, z) - base) : base;
}

void main() {
    ivec2 corner = min(ivec2(gl_VertexID % kMeshVertices, gl_VertexID / kMeshVertices), block_size);
    ivec2 post = min((block_origin + corner) << block_levels.x, u_last_post);
    int level = block_levels.y;
    vec2 at_m = ground_m(post.x, post.y);
#if defined(ALL_OWN)
    float height = height_m(post.x, post.y);
    float alpha = 0.0;
#else
    float alpha = alpha_at(level, post.x, post.y);
#if defined(ALL_MORPHING)
    float height = vertex_m(level, post.x, post.y);
#elif defined(ALL_REFINED)
    float height = refined_m(level, post.x, post.y);
#else
    float height = block_levels.x == level ? vertex_m(level, post.x, post.y) : refined_m(level, post.x, post.y);
#endif
#endif
    vec3 position_m = vec3(at_m.x, height, at_m.y);
#ifdef RELIEF_MESH
    r_from_base = post - u_base_post;
    r_marked = relief_is_near(r_from_base, position_m) ? 1 : 0;
    r_base_m = height;
    r_alpha = alpha;
    // Unmarked posts stay what they are in blocks without relief, to the bit: there is no detail at them.
    if (r_marked != 0) position_m = displaced_m(position_m, relief_point_m(r_from_base, 1));
    r_position_m = position_m;
#elif defined(PHONG)
    p_position_m = position_m;
    p_alpha = alpha;
    p_level = level;
    p_slope = phong_slope(level, post.x, post.y, alpha);
    p_weight = phong_weight(level, post.x, post.y, distance_units(level, at_m));
#else
    v_position_m = position_m;
    v_alpha = alpha;
    v_level = level;
#endif
    gl_Position = u_clip_from_relative * vec4(position_m, 1.0);
}
