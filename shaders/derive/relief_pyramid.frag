// derive/relief_pyramid.frag: (highest, lowest) metre of the nodes of one level of the relief window's pyramid.
//   reads   u_finer   level 0: R32F metres, the relief window's heights; above: RG32F, the level before
//   writes  range     RG32F   (highest, lowest)
// A node of level 0 covers 2 x 2 cells, so 3 x 3 texels, those on its sides included. The texels of a higher node are
// those of its 2 x 2 children, which share their inner sides. The window repeats.
uniform sampler2D u_finer;
uniform int u_of_heights;  // 1 at level 0, else 0
uniform int u_finer_mask;  // size of u_finer - 1, a power of two less one
layout(location = 0) out vec2 range;

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    int count = 2 + u_of_heights;
    range = vec2(-3.4e38, 3.4e38);
    for (int z = 0; z < count; ++z)
        for (int x = 0; x < count; ++x) {
            vec2 finer = texelFetch(u_finer, (first + ivec2(x, z)) & u_finer_mask, 0).rg;
            if (u_of_heights != 0) finer.g = finer.r;
            range = vec2(max(range.r, finer.r), min(range.g, finer.g));
        }
}
