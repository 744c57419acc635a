// render/parallax/trace.glsl: where a ray meets the relief about the eye.
//
// Everything is in texels. The coarse ground is the plane z = 0, the relief above it is h(p) = share *
// u_relief_texels_per_m * metres of detail, and the ray runs through `at` on that plane: p(z) = at - shift * z.
//
//      eye .                         shift     horizontal texels per texel of descent, (0, 0) straight down
//            `.                      highest   the search begins here, >= 0
//   ----------- `. at -------- z = 0
//     h(p) ___     `.  ___________   lowest    and ends here, <= 0: what is met there at the latest
//             \______`*              *         the hit: always on the ray
//
// Features, exactly one of
//   PARALLAX_ITERATIVE  `steps` times p += V (z - h(p)), V the unit direction of the ray (Premecz 2006), from
//                       z = `first` on, which the others do not need: 0, or where a mesh that follows relief was hit.
//                       Over a flat floor 1 - sin(elevation) of the way is left after each.
//   PARALLAX_SECANT     `steps` even steps in z with early exit, then one secant step between the last two
//   PARALLAX_EXACT      traversal of u_relief_pyramid (Tevs, Ihrke, Seidel 2008) to the triangle of the cell
// DEBUG_VIEW: `trace_exact` is there beside the method. The first two read heights with linear filtering, clamped to
// lowest .. highest; the exact one has the surface of the contract: cells split along the diagonal from 00 to 11.
//
// Software GL runs both sides of an `if` and pays for their fetches, but skips loops without turns: hence loops of at
// most one turn in the place of some `if`s.
#ifndef TILTH_RENDER_PARALLAX_TRACE
#define TILTH_RENDER_PARALLAX_TRACE
#include "render/relief.glsl"

uniform int u_parallax_steps;  // what `steps` is made from

struct ReliefHit {
    vec2 at;       // window texels
    float height;  // texels above the plane
    int fetches;   // heights read; of the exact method: nodes, and cells (four heights each)
};

// Height at `p` [texels], linear between texels.
float relief_height(vec2 p, float scale, float highest, float lowest) {
    float height_m = textureLod(u_relief_heights, (p + 0.5) / float(u_relief_size), 0.0).r;
    return clamp(height_m * scale, lowest, highest);
}

#ifdef PARALLAX_ITERATIVE
ReliefHit trace_relief(vec2 at, vec2 shift, float share, float highest, float lowest, float first,
                       int steps) {
    float scale = share * u_relief_texels_per_m, sine = inversesqrt(1.0 + dot(shift, shift));
    int turns = highest > lowest ? steps : 0;
    float z = clamp(first, lowest, highest);
    for (int i = 0; i < turns; ++i) z -= sine * (z - relief_height(at - shift * z, scale, highest, lowest));
    return ReliefHit(at - shift * z, z, turns);
}
#endif

#ifdef PARALLAX_SECANT
ReliefHit trace_relief(vec2 at, vec2 shift, float share, float highest, float lowest, float first,
                       int steps) {
    float scale = share * u_relief_texels_per_m, step_z = (highest - lowest) / float(steps);
    int turns = highest > lowest ? steps + 1 : 0, fetches = 0;
    float met = min(lowest, highest), before = highest, over_before = 1.0;
    for (int i = 0; i < turns; ++i) {
        float z = max(highest - step_z * float(i), lowest);  // never below the floor: the last step ends on it
        float over = z - relief_height(at - shift * z, scale, highest, lowest);
        ++fetches;
        if (over <= 0.0) {
            met = z + (before - z) * over / (over - over_before);
            break;
        }
        before = z;
        over_before = over;
    }
    return ReliefHit(at - shift * met, met, fetches);
}
#endif

#if defined(PARALLAX_EXACT) || defined(DEBUG_VIEW)
const int kTopLevel = 6;         // nodes of 64 cells; level 0 is the cells themselves
const int kFirstLevel = 3;       // measured at depths of 8 texels: one less costs edges visits, one more flat ground
const int kMostVisits = 4096;    // a guard: ten times the most that a ray at 0.1 degrees was seen to need
const float kLeastShift = 1e-9;  // in divisions

// The ray from `begin` to `end` (texels of descent) over one cell: how far it gets, up to `end`. At `begin` it is at
// `q` in the cell, at height z. Over either triangle its height above the surface is linear.
struct CellCrossing {
    bool hit;
    float descent;
};
CellCrossing cross_cell(vec4 corners, vec2 q, vec2 shift, float begin, float end, float z) {
    float length_z = end - begin;
    vec2 r = clamp(q + shift * length_z, 0.0, 1.0);
    q = clamp(q, 0.0, 1.0);
    float over = z - cell_height(corners.x, corners.y, corners.z, corners.w, q.x, q.y);
    if (over <= 0.0) return CellCrossing(true, begin);  // came from a neighbour, between the two by rounding
    float over_end = z - length_z - cell_height(corners.x, corners.y, corners.z, corners.w, r.x, r.y);
    float side = q.x - q.y, side_end = r.x - r.y;
    if (side * side_end < 0.0) {
        float t = side / (side - side_end), on_diagonal = mix(q.x, r.x, t);
        float middle = begin + t * length_z;
        float over_middle = z - t * length_z - mix(corners.x, corners.w, on_diagonal);
        if (over_middle <= 0.0) return CellCrossing(true, begin + (middle - begin) * over / (over - over_middle));
        begin = middle;
        over = over_middle;
    }
    if (over_end <= 0.0) return CellCrossing(true, begin + (end - begin) * over / (over - over_end));
    return CellCrossing(false, end);
}

// Cells are counted in integers from the one that the ray begins in. Every visit that does not descend goes on across a
// border in the direction of the ray, whatever rounding does to positions: so it ends, and leaves nothing out.
ReliefHit trace_exact(vec2 at, vec2 shift, float share, float highest, float lowest) {
    float scale = share * u_relief_texels_per_m;
    vec2 start = at - shift * highest;
    ivec2 base = ivec2(floor(start));
    vec2 from = start - vec2(base);
    bvec2 forward = greaterThanEqual(shift, vec2(0.0));
    vec2 per_texel = 1.0 / max(abs(shift), vec2(kLeastShift));
    float descent = 0.0, floor_descent = highest - lowest;
    int turns = highest > lowest ? kMostVisits : 0, level = kFirstLevel, fetches = 0;
    ivec2 cell = ivec2(0);
    for (int visit = 0; visit < turns; ++visit) {
        ivec2 node = (cell + base) >> level;
        ivec2 low = (node << level) - base, high = low + (1 << level);
        vec2 border = vec2(forward.x ? high.x : low.x, forward.y ? high.y : low.y);
        vec2 to = abs(border - from) * per_texel;
        float leave = max(min(min(to.x, to.y), floor_descent), descent);
        ++fetches;
        bool gone = true;  // the node is behind the ray
        int of_cells = level == 0 ? 1 : 0, of_nodes = 1 - of_cells;
        for (int i = 0; i < of_cells; ++i) {
            vec4 corners = vec4(relief_texel_m(node), relief_texel_m(node + ivec2(1, 0)),
                                relief_texel_m(node + ivec2(0, 1)), relief_texel_m(node + ivec2(1)));
            CellCrossing crossing = cross_cell(scale * corners, from + shift * descent - vec2(cell), shift, descent,
                                               leave, highest - descent);
            descent = crossing.descent;
            if (crossing.hit) floor_descent = descent;
        }
        for (int i = 0; i < of_nodes; ++i) {
            ivec2 wrapped = node & ((u_relief_size >> level) - 1);
            float above_top = highest - scale * texelFetch(u_relief_pyramid, wrapped, level - 1).r;
            gone = leave <= above_top;
            descent = gone ? leave : max(descent, above_top);
        }
        if (descent >= floor_descent) break;
        ivec2 along = clamp(ivec2(floor(from + shift * descent)), low, high - 1);
        along = ivec2(forward.x ? max(along.x, cell.x) : min(along.x, cell.x),
                      forward.y ? max(along.y, cell.y) : min(along.y, cell.y));
        if (gone && to.x <= to.y) along.x = forward.x ? high.x : low.x - 1;
        if (gone && to.y <= to.x) along.y = forward.y ? high.y : low.y - 1;
        cell = along;
        // Up where the ray leaves the parent too: the parent has been found too high to be skipped.
        bool left_parent = ((cell + base) >> (level + 1)) != (node >> 1);
        level = gone ? (left_parent ? min(level + 1, kTopLevel) : level) : level - 1;
    }
    float z = highest - (highest > lowest ? floor_descent : 0.0);
    return ReliefHit(at - shift * z, z, fetches);
}
#endif

#ifdef PARALLAX_EXACT
ReliefHit trace_relief(vec2 at, vec2 shift, float share, float highest, float lowest, float first,
                       int steps) {
    return trace_exact(at, shift, share, highest, lowest);
}
#endif
#endif
