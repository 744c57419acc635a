// render/plain_mesh.vert: the floor of the clipmap's benchmark: positions from a vertex buffer, no height planes, no
// morphing, and the very fragment shader of the ground.
//   reads  position_m   metres relative to the eye;   alpha, level   as render/terrain.vert computes them
uniform mat4 u_clip_from_relative;
layout(location = 0) in vec3 position_m;
layout(location = 1) in vec2 alpha_level;
out vec3 v_position_m;
out float v_alpha;
flat out int v_level;
void main() {
    v_position_m = position_m;
    v_alpha = alpha_level.x;
    v_level = int(alpha_level.y);
    gl_Position = u_clip_from_relative * vec4(position_m, 1.0);
}
