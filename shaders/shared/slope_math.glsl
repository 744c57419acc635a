// shared/slope_math.glsl: partial derivatives of the height, their stencils and storage. Compiled as GLSL and as C++.
// Floats: slopes are derived from the codes and never persistent. Slopes are dh/dx and dh/dz, metres per metre.
#ifndef TILTH_SHARED_SLOPE_MATH
#define TILTH_SHARED_SLOPE_MATH
#include "shared/prelude.glsl"

// Difference of two codes as a float, in code quanta, to one quantum: halved first, so that it fits a signed integer
// whatever the codes are and a cliff keeps its sign.
SHARED_FUNCTION float code_difference(uint a, uint b) { return float(int(a >> 1) - int(b >> 1)) * 2.0f; }

// dh along one axis at post `position` of 0..last, from the codes of the posts two and one before it and one and two after
// it (clamped to the map). per_m = code quantum [m] / spacing [m].
// Central difference: error h^2 / 6 max|h'''|; one-sided at the border. Fourth order: error h^4 / 30 max|h'''''|, where two
// posts lie on either side, else central.
SHARED_FUNCTION float slope_along(uint before2, uint before, uint after, uint after2, int position, int last, bool fourth,
                                  float per_m) {
    if (fourth && position >= 2 && position <= last - 2)
        return (code_difference(after, before) * 8.0f - code_difference(after2, before2)) * (per_m / 12.0f);
    int span = min(position + 1, last) - max(position - 1, 0);
    return code_difference(after, before) * (per_m / float(span));
}

// RG8 storage: p / (1 + |p|) with |p| the length of the slope vector, so that a cliff saturates without turning. Flat is
// exactly 128; 127 steps either way. Returns one component's byte, 1..255.
SHARED_FUNCTION int slope_byte(float component, float slope_length) {
    return int(component / (1.0f + slope_length) * 127.0f + 128.5f);
}

// The inverse, on filtered values: one component to -1..1.
SHARED_FUNCTION float slope_signed(float stored) { return (stored * 255.0f - 128.0f) / 127.0f; }

// |c| = |p| / (1 + |p|) gives |p| = |c| / (1 - |c|): multiply both signed components by this. Clamped at slope 254.
SHARED_FUNCTION float slope_expansion(float signed_length) { return 1.0f / max(1.0f - signed_length, 1.0f / 255.0f); }
#endif
