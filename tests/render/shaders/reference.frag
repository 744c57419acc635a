// tests/render/shaders/reference.frag: ground is grey.
layout(location = 0) out vec4 colour;
void main() { colour = vec4(0.5, 0.5, 0.5, 1.0); }
