// render/terrain.vert: a vertex of a clipmap block or of a stitch, from the height planes.
//   reads  u_high_plane, u_low_plane   R16 unorm   height code, texel (i, j) = post (i, j); BITS16: no low plane
//   gives  metres relative to the eye, the share of the next coarser level, the level
// Features: BITS16, MIRRORED (the map is repeated by reflection).
//
// Every level computes a position by the same expression from the post's integer index, so a vertex that two levels (or
// a block and a stitch) share is the same to the last bit. Codes and posts are subtracted as integers: nothing large
// becomes a float near the eye.
#include "shared/clipmap_morph.glsl"
#include "shared/height_code.glsl"
#include "shared/slope_math.glsl"

layout(location = 0) in ivec2 block_origin;  // units of 2^level posts
layout(location = 1) in ivec2 block_size;    // quads; 0 on one axis for a stitch
layout(location = 2) in int block_level;

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

invariant gl_Position;
out vec3 v_position_m;  // relative to the eye
out float v_alpha;
flat out int v_level;

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

void main() {
    ivec2 corner = min(ivec2(gl_VertexID % kMeshVertices, gl_VertexID / kMeshVertices), block_size);
    ivec2 post = min((block_origin + corner) << block_level, u_last_post);
    vec2 ground_m = vec2(post - u_base_post) * u_spacing_m - u_fraction_m;
    float height = height_m(post.x, post.y);

    float alpha = 0.0;
    if (block_level < u_coarsest_level) {
        float unit_m = u_spacing_m * float(1 << block_level);
        alpha = morph_alpha(max(abs(ground_m.x), abs(ground_m.y)) / unit_m, u_n, u_zone_units);
        int x0 = coarse_low(post.x, block_level, u_last_post.x), x1 = coarse_high(post.x, block_level, u_last_post.x);
        int z0 = coarse_low(post.y, block_level, u_last_post.y), z1 = coarse_high(post.y, block_level, u_last_post.y);
        if (alpha > 0.0 && (x0 != x1 || z0 != z1)) {  // a post of the coarser level stays exactly where it is
            float coarse = cell_height(height_m(x0, z0), height_m(x1, z0), height_m(x0, z1), height_m(x1, z1),
                                       coarse_weight(post.x, x0, x1), coarse_weight(post.y, z0, z1));
            height = alpha < 1.0 ? height + alpha * (coarse - height) : coarse;
        }
    }
    v_position_m = vec3(ground_m.x, height, ground_m.y);
    v_alpha = alpha;
    v_level = block_level;
    gl_Position = u_clip_from_relative * vec4(v_position_m, 1.0);
}
