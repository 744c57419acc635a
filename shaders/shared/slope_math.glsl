// shared/slope_math.glsl: partial derivatives of the height, their stencils and storage. Compiled as GLSL and as C++.
// Floats: slopes are derived from the codes and never persistent. Slopes are dh/dx and dh/dz, metres per metre.
#ifndef TILTH_SHARED_SLOPE_MATH
#define TILTH_SHARED_SLOPE_MATH
#include "shared/prelude.glsl"

// Difference of two codes as a float, in code quanta. The subtraction is exact modulo 2^32; neighbours differ by less
// than half the range, or the slope is a cliff whose sign is kept by saturating.
SHARED_FUNCTION float code_difference(uint a, uint b) {
    return a >= b ? float(a - b) : -float(b - a);
}

// Central difference, error h^2 / 6 max|h'''|. per_m = code quantum [m] / spacing [m].
SHARED_FUNCTION float slope_central(uint west, uint east, float per_m) {
    return code_difference(east, west) * (0.5f * per_m);
}

// Five-point difference of fourth order, error h^4 / 30 max|h'''''|.
SHARED_FUNCTION float slope_fourth(uint west2, uint west, uint east, uint east2, float per_m) {
    return (code_difference(east, west) * 8.0f - code_difference(east2, west2)) * (per_m / 12.0f);
}

// RG8 storage: p / (1 + |p|) with |p| the length of the slope vector, so that a cliff saturates without turning. Flat is
// exactly 128 / 255; 127 steps either way. Returns the unorm value of one component.
SHARED_FUNCTION float slope_companded(float component, float slope_length) {
    return (floor(component / (1.0f + slope_length) * 127.0f + 0.5f) + 128.0f) / 255.0f;
}

// The inverse, on filtered values: one component to -1..1.
SHARED_FUNCTION float slope_signed(float stored) { return (stored * 255.0f - 128.0f) / 127.0f; }

// |c| = |p| / (1 + |p|) gives |p| = |c| / (1 - |c|): multiply both signed components by this. Clamped at slope 254.
SHARED_FUNCTION float slope_expansion(float signed_length) { return 1.0f / max(1.0f - signed_length, 1.0f / 255.0f); }
#endif
