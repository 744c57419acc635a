// The floor of render/geometry/refine.geom: the same inputs, the same declaration, and triangles go out as they came.
#include "render/relief_mesh.glsl"

layout(triangles) in;
layout(triangle_strip, max_vertices = MAX_VERTICES) out;

in vec3 r_position_m[];
in float r_alpha[];

out vec3 v_position_m;
out float v_alpha;
flat out int v_level;

void main() {
    for (int i = 0; i < 3; ++i) {
        v_position_m = r_position_m[i];
        v_alpha = r_alpha[i];
        v_level = 0;
        gl_Position = gl_in[i].gl_Position;
        EmitVertex();
    }
    EndPrimitive();
}
