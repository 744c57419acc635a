// render/tessellation/edge_parts.glsl: in how many parts an edge is split for the screen.
#ifndef TILTH_RENDER_EDGE_PARTS
#define TILTH_RENDER_EDGE_PARTS
// 1 .. most parts of about `part_px` pixels seen from the distance of the edge's middle, turned broadside; part_px 0:
// the most. Relative to the eye, metres. The same bits for (a, b) as for (b, a): sums commute, squares forget the sign.
int edge_parts(vec3 a_m, vec3 b_m, float part_px, float px_per_radian, int most) {
    if (part_px <= 0.0) return most;
    vec3 along_m = b_m - a_m, twice_middle_m = a_m + b_m;
    float radians_wide = 2.0 * sqrt(dot(along_m, along_m) / max(dot(twice_middle_m, twice_middle_m), 1e-12));
    return int(clamp(ceil(radians_wide * px_per_radian / part_px), 1.0, float(most)));
}
#endif
