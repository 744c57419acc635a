// tests/render/shaders/reference.vert: positions computed on the CPU, relative to the eye. Shares nothing with the library.
layout(location = 0) in vec3 position_m;
uniform mat4 u_clip_from_relative;
void main() { gl_Position = u_clip_from_relative * vec4(position_m, 1.0); }
