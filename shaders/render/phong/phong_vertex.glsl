// render/phong/phong_vertex.glsl: what render/terrain.vert adds to a vertex of a curved triangle: the ground's slope
// there, and how much of the curvature shows. Included after the uniforms of terrain.vert.
//   reads   u_slopes   RG8 companded or (SLOPES_RG16F) RG16F   dh/dx, dh/dz at the posts (pool/slope_map.h)
//   int u_phong_first_level   finer levels stay as they are: those that show relief
#ifndef TILTH_RENDER_PHONG_VERTEX
#define TILTH_RENDER_PHONG_VERTEX
#include "shared/clipmap_morph.glsl"
#include "shared/height_code.glsl"
#include "shared/slope_math.glsl"

uniform sampler2D u_slopes;
uniform int u_phong_first_level;

// The slope at a post. Mips hold the same numbers at fewer posts: level 0 serves every level of the clipmap.
vec2 post_slope(int x, int z) {
    ivec2 texel = ivec2(x, z);
    vec2 sign_of_fold = vec2(1.0);
#ifdef MIRRORED
    texel = ivec2(folded_post(x, u_stored_posts.x), folded_post(z, u_stored_posts.y));
    sign_of_fold = vec2(texel.x == x % (2 * (u_stored_posts.x - 1)) ? 1.0 : -1.0,
                        texel.y == z % (2 * (u_stored_posts.y - 1)) ? 1.0 : -1.0);
#endif
    vec2 stored = texelFetch(u_slopes, texel, 0).rg;
#ifdef SLOPES_RG16F
    return sign_of_fold * stored;
#else
    vec2 companded = vec2(slope_signed(stored.x), slope_signed(stored.y));
    return sign_of_fold * companded * slope_expansion(length(companded));
#endif
}

// The slope of a vertex of `level`, morphed as its height is: a coarser vertex's own or the mean of the two about it.
vec2 phong_slope(int level, int x, int z, float alpha) {
    vec2 slope = post_slope(x, z);
    if (alpha <= 0.0) return slope;
    vec2 coarse = 0.5 * (post_slope(coarse_low(x, level, u_last_post.x), coarse_low(z, level, u_last_post.y)) +
                         post_slope(coarse_high(x, level, u_last_post.x), coarse_high(z, level, u_last_post.y)));
    return mix(slope, coarse, alpha);
}

// 0 on every border of a level, where another level or a stitch meets it, and at folds of a mirrored map, where the
// ground has a crease and no slope; 1 from four units inside.
float phong_weight(int level, int x, int z, float distance_units) {
    if (level < u_phong_first_level) return 0.0;
#ifdef MIRRORED
    if (x % (u_stored_posts.x - 1) == 0 || z % (u_stored_posts.y - 1) == 0) return 0.0;
#endif
    bool is_coarsest = level == u_coarsest_level;
    if (level > 0) return refinement_fade(distance_units, u_n, is_coarsest);
    float to_border = float(u_n - 1) * 0.5 - 1.0 - kMorphSlack - distance_units;  // level 0 has no hole
    return is_coarsest ? 1.0 : clamp(0.25 * to_border, 0.0, 1.0);
}
#endif
