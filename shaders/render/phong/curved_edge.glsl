// render/phong/curved_edge.glsl: curved triangles over a height field (Boubekeur & Alexa, Phong Tessellation, 2008).
//
// A point P = sum b_i p_i of a triangle is projected on the tangent plane of each corner, and the projections are
// averaged by the same b_i. With projections along y - it is a height field: nothing moves sideways, nothing can fold -
// what P rises by is a sum over the three edges,
//     sum over i < j of b_i b_j bulge_ij,   bulge_ij = (slope_i - slope_j) . (p_j - p_i),
// so that on an edge only its own two ends matter, and each edge can have a weight of its own.
// On a parabola the exact surface is `shape` = 1/2 of that (the chord's error is curvature * d^2 / 2 * t (1 - t)).
#ifndef TILTH_RENDER_CURVED_EDGE
#define TILTH_RENDER_CURVED_EDGE
// Weighted; the same bits for (a, b) as for (b, a): both factors of the dot change sign.
float edge_bulge_m(vec3 a_m, vec2 a_slope, float a_weight, vec3 b_m, vec2 b_slope, float b_weight) {
    return a_weight * b_weight * dot(a_slope - b_slope, b_m.xz - a_m.xz);
}
#endif
