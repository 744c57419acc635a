// Heights of points between texels, one for each vertex: row by row of u_side points about the base post.
#include "render/relief_mesh.glsl"

uniform int u_side, u_parts;
out float height_m;

void main() {
    ivec2 n = ivec2(gl_VertexID % u_side, gl_VertexID / u_side) - u_side / 2;
    height_m = relief_point_m(n, u_parts);
    gl_Position = vec4(0.0);
}
