// derive/relief_range.frag: (highest, lowest) metre of 3 x 3 of the coarsest nodes about each node.
//   reads   u_pyramid   RG32F   (highest, lowest), level u_level
//   writes  range       RG32F   (highest, lowest)
// The window repeats.
uniform sampler2D u_pyramid;
uniform int u_level, u_mask;  // the coarsest level, its size - 1
layout(location = 0) out vec2 range;

void main() {
    range = vec2(-3.4e38, 3.4e38);
    for (int z = -1; z <= 1; ++z)
        for (int x = -1; x <= 1; ++x) {
            vec2 node = texelFetch(u_pyramid, (ivec2(gl_FragCoord.xy) + ivec2(x, z)) & u_mask, u_level).rg;
            range = vec2(max(range.r, node.r), min(range.g, node.g));
        }
}
