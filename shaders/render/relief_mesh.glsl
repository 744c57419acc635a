// render/relief_mesh.glsl: points of a mesh that follows relief, between the posts of the finest level.
//
// A point is named by integers: (n.x, n.y) / f posts from the base post. Every stage computes what it needs of a point
// from those integers by the functions below, and a point on an edge from the edge's two ends taken in one order
// (edge_first), so that the two triangles at an edge get the same bits for every point of it, whichever of them asks
// and however it is wound. `precise` keeps compilers that have it from contracting one of the two differently.
#ifndef TILTH_RENDER_RELIEF_MESH
#define TILTH_RENDER_RELIEF_MESH
#if __VERSION__ < 400 && defined(GL_ARB_gpu_shader5)
#extension GL_ARB_gpu_shader5 : enable  // for `precise`; so this file comes before every declaration of a shader
#endif
#if __VERSION__ >= 400 || defined(GL_ARB_gpu_shader5)
#define TILTH_PRECISE precise
#else
#define TILTH_PRECISE
#endif
#include "render/relief.glsl"
#include "shared/clipmap_morph.glsl"

uniform int u_relief_mark_level;  // of the pyramid: nodes two posts wide, as far as there are such

// A multiple of every window's size: what is added to make numbers positive before they are divided.
const int kReliefLift = 65536;

// Metres of detail at the point n / f. Texels are read as they are; between them the surface is that of the contract:
// cells split along the diagonal from the low to the high corner.
float relief_point_m(ivec2 n, int f) {
    ivec2 lifted = n * u_relief_per_post + ivec2(f * kReliefLift);
    ivec2 texel = lifted / f, rest = lifted - texel * f;
    texel += u_relief_base_texel;
    if (rest == ivec2(0)) return relief_texel_m(texel);
    TILTH_PRECISE vec2 t = vec2(rest) / float(f);
    return relief_cell_m(texel, t);
}

// What the surface stands at, metres from the eye, from where it stood without relief.
vec3 displaced_m(vec3 base_m, float relief_m) {
    TILTH_PRECISE float y = base_m.y + displaced_share(length(base_m)) * relief_m;
    return vec3(base_m.x, y, base_m.z);
}

// Whether there is detail in the cells about a post, and whether it shows there. Says yes too often, by the size of
// nodes, never too seldom: every triangle with detail anywhere in it has three such posts.
bool relief_is_near(ivec2 from_base, vec3 base_m) {
    if (displaced_share(length(base_m)) <= 0.0) return false;
    int shift = u_relief_mark_level + 1;
    int last = (u_relief_size >> shift) - 1;
    ivec2 texel = from_base * u_relief_per_post + u_relief_base_texel + ivec2(kReliefLift);
    ivec2 low = (texel - u_relief_per_post) >> shift, high = (texel + u_relief_per_post - 1) >> shift;
    vec2 found = vec2(0.0);
    for (int z = low.y; z <= high.y; ++z)
        for (int x = low.x; x <= high.x; ++x)
            found = max(found, abs(texelFetch(u_relief_pyramid, ivec2(x, z) & last, u_relief_mark_level).rg));
    return found != vec2(0.0);
}

// Whether the end `a` of an edge comes first, by place.
bool edge_first(ivec2 a, ivec2 b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }
#endif
