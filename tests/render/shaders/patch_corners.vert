// Corners of patches as the test says them, in the place of render/terrain.vert.
layout(location = 0) in vec3 position_m;
layout(location = 1) in vec4 clip;     // anything: stages that split must pass it on
layout(location = 2) in vec4 numbers;  // height without relief, share of the next level; slope x, z
layout(location = 3) in ivec4 integers;  // posts from the base post x, z; marked; level
layout(location = 4) in float weight;

#ifdef PHONG
out vec3 p_position_m;
out float p_alpha;
flat out int p_level;
out vec2 p_slope;
out float p_weight;
#else
out vec3 r_position_m;
out float r_base_m;
out float r_alpha;
flat out ivec2 r_from_base;
flat out int r_marked;
#endif

void main() {
#ifdef PHONG
    p_position_m = position_m;
    p_alpha = numbers.y;
    p_level = integers.w;
    p_slope = numbers.zw;
    p_weight = weight;
#else
    r_position_m = position_m;
    r_base_m = numbers.x;
    r_alpha = numbers.y;
    r_from_base = integers.xy;
    r_marked = integers.z;
#endif
    gl_Position = clip;
}
