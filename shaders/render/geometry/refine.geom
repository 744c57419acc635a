// render/geometry/refine.geom: splits a triangle of a clipmap block where there is detail under it.
//   reads  the vertices of render/terrain.vert with RELIEF_MESH; u_relief_heights at the new points
//   gives  what that shader gives without it: metres relative to the eye, the share of the next coarser level, level 0
// Features: MAX_FACTOR, the largest factor of u_refine_chain; MAX_VERTICES = MAX_FACTOR (MAX_FACTOR + 2), by itself as
// GLSL 3.30 takes no sum there. Hardware takes memory, and with it speed, by what is declared: no more than is needed.
// BETWEEN_TEXELS: a factor does not divide the texels a post.
// Uniforms of its own (beside those of terrain.vert and relief.glsl):
//   ivec4 u_refine_chain             factors from 1 on, each divides the next; where there
//                                    are less than four the last is repeated (backends/refinement_chain.h)
//   float u_refine_px_per_radian     of the picture
//   float u_refine_edge_px           edges are split until their parts are no longer than this; 0: always by the last
//
// A corner has a factor: 1 where it is not marked, else that of the chain which makes a post's spacing there short
// enough. An edge has the smaller one of its two ends: it follows from them alone: both its triangles split it alike.
// Two edges of a triangle then have one factor, the smallest, f, and the third, between the two other corners, g, a
// multiple of it:
//
//          a            The lattice of f parts a side, row by row from the corner a; along the third edge each triangle
//         / \           becomes a fan of g / f. With one factor in use these are the eight patterns of three marks: a
//        /___\          triangle that stays what it is (none or one marked), a fan of g from the corner that is not
//       /\   /\         marked, a lattice.
//      /  \ / |\        f = 2, g = 4 in the picture. Corners are what came in, to the bit; a triangle that is not split
//     b___.___.__c      reads no texture.
#include "render/relief_mesh.glsl"

#ifndef MAX_FACTOR
#define MAX_FACTOR 8
#define MAX_VERTICES 80
#endif

layout(triangles) in;
// The most is a lattice of MAX_FACTOR: strips of 3, 5, 7 .. vertices. f = g / 2 takes 3 (f f - f + g), which is less.
layout(triangle_strip, max_vertices = MAX_VERTICES) out;

uniform float u_spacing_m;
uniform vec2 u_fraction_m;
uniform mat4 u_clip_from_relative;
uniform ivec4 u_refine_chain;
uniform float u_refine_px_per_radian, u_refine_edge_px;

in vec3 r_position_m[];
in float r_base_m[];
in float r_alpha[];
flat in ivec2 r_from_base[];
flat in int r_marked[];

out vec3 v_position_m;
out float v_alpha;
flat out int v_level;
invariant gl_Position;  // edges are shared by blocks of different programs
#ifdef DEBUG_VIEW
out float v_relief_m;  // what the mesh shows of the relief
#endif

struct Corner {
    vec3 position_m;
    float base_m, alpha;
    ivec2 post;  // from the base post
    vec4 clip;
};

struct Point {
    vec3 position_m;
    float alpha;
    vec4 clip;
#ifdef DEBUG_VIEW
    float base_m;
#endif
};

Point made_point(vec3 position_m, float alpha, vec4 clip, float base_m) {
#ifdef DEBUG_VIEW
    return Point(position_m, alpha, clip, base_m);
#else
    return Point(position_m, alpha, clip);
#endif
}

Corner corner(int i) {
    return Corner(r_position_m[i], r_base_m[i], r_alpha[i], r_from_base[i], gl_in[i].gl_Position);
}

Point own(Corner c) { return made_point(c.position_m, c.alpha, c.clip, c.base_m); }

// (spacing px / distance) / factor > edge px: split further. Squares, and sums written out, so that every corner is
// judged by the same operations.
int factor_of(int i) {
    if (r_marked[i] == 0) return 1;
    float x = r_position_m[i].x, y = r_base_m[i], z = r_position_m[i].z;
    TILTH_PRECISE float squared_m2 = x * x + y * y + z * z;
    float wanted = u_spacing_m * u_refine_px_per_radian;
    int factor = 1;
    for (int level = 1; level < 4; ++level) {
        TILTH_PRECISE float reached = float(factor) * u_refine_edge_px;
        TILTH_PRECISE float reached_2 = reached * reached * squared_m2;
        if (reached_2 >= wanted * wanted) break;
        factor = min(u_refine_chain[level], MAX_FACTOR);
    }
    return factor;
}

// A point between corners: n / f posts from the base post. A texel, where f divides the texels a post.
struct Between {
    ivec2 n;
    int f;
    float base_m, alpha;
};

Point displaced(Between p) {
    TILTH_PRECISE vec2 at_m = vec2(p.n) / float(p.f) * u_spacing_m - u_fraction_m;
#ifdef BETWEEN_TEXELS
    float relief_m = relief_point_m(p.n, p.f);
#else
    float relief_m = relief_texel_m(p.n * (u_relief_per_post / p.f) + u_relief_base_texel);
#endif
    vec3 position_m = displaced_m(vec3(at_m.x, p.base_m, at_m.y), relief_m);
    return made_point(position_m, p.alpha, u_clip_from_relative * vec4(position_m, 1.0), p.base_m);
}

// Point k of f on the edge from p to q.
Between on_edge(Corner p, Corner q, int k, int f) {
    if (!edge_first(p.post, q.post)) {
        Corner first = q;
        q = p;
        p = first;
        k = f - k;
    }
    TILTH_PRECISE float base_m = (p.base_m * float(f - k) + q.base_m * float(k)) / float(f);
    TILTH_PRECISE float alpha = (p.alpha * float(f - k) + q.alpha * float(k)) / float(f);
    return Between(p.post * (f - k) + q.post * k, f, base_m, alpha);
}

// Point j of row r: from the side a b, j = 0, to the side a c, j = r. The last row is r = f; its points are those of
// the edge b c, which is split by g. One way and one fetch for all: software GL pays for both sides of every branch
// (measured: a third less time than with a branch for each edge and the middle).
Point lattice_point(Corner a, Corner b, Corner c, int r, int j, int f, int g) {
    bool last = r == f;
    Corner p = a, q = c;
    if (last) p = b;
    if (!last && j == 0) q = b;
    Between point = on_edge(p, q, last ? j * (g / f) : r, last ? g : f);
    if (!last && j > 0 && j < r) {
        vec3 weight = vec3(float(f - r), float(r - j), float(j)) / float(f);
        point.n = a.post * (f - r) + b.post * (r - j) + c.post * j;
        point.base_m = weight.x * a.base_m + weight.y * b.base_m + weight.z * c.base_m;
        point.alpha = weight.x * a.alpha + weight.y * b.alpha + weight.z * c.alpha;
    }
    Point made = displaced(point);
    if (last && j == 0) made = own(b);
    if (last && j == f) made = own(c);
    return made;
}

void emit(Point p) {
    v_position_m = p.position_m;
    v_alpha = p.alpha;
    v_level = 0;
#ifdef DEBUG_VIEW
    v_relief_m = p.position_m.y - p.base_m;
#endif
    gl_Position = p.clip;
    EmitVertex();
}

void emit_triangle(Point p, Point q, Point r) {
    emit(p);
    emit(q);
    emit(r);
    EndPrimitive();
}

void main() {
    ivec3 factor = ivec3(factor_of(0), factor_of(1), factor_of(2));
    // Vertices beyond the end of a smaller block fall together with its last.
    ivec2 along = r_from_base[1] - r_from_base[0], across = r_from_base[2] - r_from_base[0];
    if (along.x * across.y == along.y * across.x) factor = ivec3(1);

    int first = factor.x <= factor.y && factor.x <= factor.z ? 0 : (factor.y <= factor.z ? 1 : 2);
    int second = (first + 1) % 3, third = (first + 2) % 3;
    Corner a = corner(first), b = corner(second), c = corner(third);
    int f = factor[first], g = min(factor[second], factor[third]);
    if (g == 1) {
        emit_triangle(own(corner(0)), own(corner(1)), own(corner(2)));
        return;
    }
    // Rows as strips, wound like a, b, c: from the side a c to the side a b. `row` holds the row before, and beyond j
    // already the new one.
    Point row[MAX_FACTOR + 1];
    row[0] = own(a);
    int strips = g == f ? f : f - 1;
    for (int r = 1; r <= strips; ++r) {
        for (int j = r; j >= 0; --j) {
            Point p = lattice_point(a, b, c, r, j, f, g);
            emit(p);
            if (j > 0) emit(row[j - 1]);
            row[j] = p;
        }
        EndPrimitive();
    }
    if (g == f) return;
    // The row along the third edge: a fan below each point of the row before, and the triangles between.
    Point last = own(b);
    for (int k = 1; k <= g; ++k) {
        Point next = own(c);
        if (k < g) next = displaced(on_edge(b, c, k, g));
        int j = (k - 1) / (g / f);
        emit_triangle(row[j], last, next);
        if (k % (g / f) == 0 && k < g) emit_triangle(row[j], next, row[j + 1]);
        last = next;
    }
}
