// shared/height_code.glsl: height codes and their planes. Compiled as GLSL and as C++.
// A height code is 32-bit fixed point, 2^31 in the middle of the map's range, kept in two 16-bit unorm planes. Both
// directions are exact. With HeightPrecision::bits16 there is no low plane and the low half is zero.
#ifndef TILTH_SHARED_HEIGHT_CODE
#define TILTH_SHARED_HEIGHT_CODE
#include "shared/prelude.glsl"

// One plane's texel, as a sampler returns it, to its 16 bits.
SHARED_FUNCTION uint plane_bits(float plane) { return uint(plane * 65535.0f + 0.5f); }

// 16 bits to what a fragment writes. + 0.25: a store that rounds and one that truncates both give the integer back.
SHARED_FUNCTION float plane_value(uint bits) { return (float(bits) + 0.25f) / 65535.0f; }

SHARED_FUNCTION uint code_of_planes(float high, float low) { return (plane_bits(high) << 16) | plane_bits(low); }
#endif
