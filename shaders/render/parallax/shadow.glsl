// render/parallax/shadow.glsl: how much direct light reaches a point of the relief past the relief about it.
// Units and signs as in render/parallax/trace.glsl; feature PARALLAX_SHADOWS.
#ifndef TILTH_RENDER_PARALLAX_SHADOW
#define TILTH_RENDER_PARALLAX_SHADOW
#include "render/parallax/trace.glsl"

uniform int u_parallax_shadow_steps;

// Relief that stands this steeply above the way to the light takes all of it, half as steeply half of it. Taste: six
// degrees where the sun has half a degree, for a few steps are all that is looked at.
const float kFullShade = 0.1;

// Even steps from the hit up to `highest`, where nothing can be in the way any more. `light_shift`: horizontal texels
// towards the light per texel of ascent. Exactly 1 where no step is below the relief.
float relief_light(vec2 at, float height, vec2 light_shift, float share, float highest, float lowest) {
    float scale = share * u_relief_texels_per_m;
    // A hit that the method put below the relief is not in its shadow.
    height = max(height, relief_height(at, scale, highest, lowest));
    float step_z = (highest - height) / float(max(u_parallax_shadow_steps, 1));
    int turns = step_z > 0.0 ? u_parallax_shadow_steps : 0;
    float way = sqrt(1.0 + dot(light_shift, light_shift)), worst = 0.0;
    for (int i = 1; i <= turns; ++i) {
        float up = step_z * float(i);
        float over = relief_height(at + light_shift * up, scale, highest, lowest) - (height + up);
        worst = max(worst, over / (way * up));
    }
    return clamp(1.0 - worst / kFullShade, 0.0, 1.0);
}
#endif
