// shared/stamp_math.glsl: the arithmetic of stamps. Compiled as GLSL and as C++; exact integers throughout.
// Weights are 1/65536, -65536..65536. Magnitudes and codes are unsigned 32-bit; signs travel beside them, so that a stamp
// and its negation round alike and cancel. With STAMP_BITS16 codes are multiples of 65536.
#ifndef TILTH_SHARED_STAMP_MATH
#define TILTH_SHARED_STAMP_MATH
#include "shared/prelude.glsl"
#include "shared/stamp_params.glsl"

// ---- where a texel lies in the stamp ----

// Distance of a texel from the stamp's centre, 1/1024 texel, rounded down.
SHARED_FUNCTION uint stamp_distance(StampParams s, int x, int z) {
    return root_of_squares((x - s.centre_x) * 1024 - s.offset_x, (z - s.centre_z) * 1024 - s.offset_z);
}

// distance / radius as 31 fraction bits; distance < radius. The reciprocal is rounded down, so the result is < 2^31.
SHARED_FUNCTION uint profile_position(StampParams s, uint distance) {
    return mul_high(distance << s.radius_shift, s.radius_reciprocal);
}
SHARED_FUNCTION int profile_entry(uint position) { return int(position >> 21); }                  // 0..1023
SHARED_FUNCTION uint profile_fraction(uint position) { return (position >> 7) & 16383u; }         // 14 bits

// Image position of a texel: `u_bits` and `v_bits` fraction bits, pixel centres at integers. Wraps like 32-bit integers do.
SHARED_FUNCTION int image_u(StampParams s, int x, int z) {
    return int(uint(s.u_centre) + uint(x - s.centre_x) * uint(s.u_per_x) + uint(z - s.centre_z) * uint(s.u_per_z));
}
SHARED_FUNCTION int image_v(StampParams s, int x, int z) {
    return int(uint(s.v_centre) + uint(x - s.centre_x) * uint(s.v_per_x) + uint(z - s.centre_z) * uint(s.v_per_z));
}
// Inside the square that the image covers: from half a pixel before the first centre to half a pixel after the last.
SHARED_FUNCTION bool image_covers(int position, uint size, uint bits) {
    return uint(position) + (1u << (bits - 1u)) < (size << bits);
}
SHARED_FUNCTION int image_texel(int position, uint bits) { return position >> int(bits); }        // may be -1
SHARED_FUNCTION uint image_fraction(int position, uint bits) { return (uint(position) >> (bits - 14u)) & 16383u; }

// Between two neighbouring weights, |b - a| <= 131072, fraction of 14 bits: the product stays below 2^31.
SHARED_FUNCTION int between_weights(int a, int b, uint fraction) {
    return a + (((b - a) * int(fraction) + 8192) >> 14);
}

// ---- what it does to a code ----

// round(amplitude * weight / 65536), weight 0..65536: 32 x 17 bits without a wider type; weight 65536 is exact.
SHARED_FUNCTION uint scaled(uint amplitude, uint weight) {
    return (amplitude >> 16) * weight + (((amplitude & 65535u) * weight + 32768u) >> 16);
}

// Uniform 32-bit hash of the record's key and a texel of the map (finaliser: C. Wellons' lowbias32).
SHARED_FUNCTION uint mix_bits(uint h) {
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return h ^ (h >> 16);
}
SHARED_FUNCTION uint dither_of(uint key, int x, int z) {
    return mix_bits(mix_bits(key ^ (uint(x) * 0x9e3779b1u)) ^ (uint(z) * 0x85ebca77u));
}

// A magnitude in whole quanta of the high plane: rounded up with the probability of what is cut off.
SHARED_FUNCTION uint dithered(uint magnitude, uint dither) {
    uint quanta = (magnitude >> 16) + (((magnitude & 65535u) + (dither & 65535u)) >> 16);
    return min(quanta, 65535u) << 16;
}

struct Blended {
    uint code;
    uint saturated;  // 1: the value would have left the range
};

// code +- magnitude, stopping at 0 and `top`.
SHARED_FUNCTION Blended added(uint code, uint magnitude, bool down, uint top) {
    uint room = down ? code : top - code;
    bool stops = magnitude > room;
    uint step = stops ? room : magnitude;
    Blended result;
    result.code = down ? code - step : code + step;
    result.saturated = stops ? 1u : 0u;
    return result;
}

SHARED_FUNCTION uint top_code(bool bits16) { return bits16 ? 0xffff0000u : 0xffffffffu; }

// level +- magnitude as a code of the map; with bits16 rounded to the nearest quantum, so that it does not depend on the key.
SHARED_FUNCTION Blended target_code(uint level, uint magnitude, bool down, bool bits16) {
    Blended result = added(level, magnitude, down, 0xffffffffu);
    if (bits16) result.code = min((result.code >> 16) + ((result.code >> 15) & 1u), 65535u) << 16;
    return result;
}

// code moved towards target by weight, 0..65536; 65536 reaches it exactly. Never leaves the range.
SHARED_FUNCTION uint moved(uint code, uint target, uint weight, bool bits16, uint dither) {
    bool down = target < code;
    uint step = scaled(down ? code - target : target - code, weight);
    if (bits16) step = dithered(step, dither);
    return down ? code - step : code + step;
}

// Mean of eight codes from the sums of their high and low halves, rounded to nearest; with bits16 to a whole quantum.
SHARED_FUNCTION uint mean_of_eight(uint high_sum, uint low_sum, bool bits16) {
    if (bits16) return ((high_sum + 4u) >> 3) << 16;
    return ((high_sum >> 3) << 16) + ((((high_sum & 7u) << 16) + low_sum + 4u) >> 3);
}

// The rule's result at one texel. `weight` is signed; only add takes weights below zero. `mean` is read by smooth alone.
SHARED_FUNCTION Blended blended(uint rule, bool bits16, uint code, int weight, uint amplitude, bool negative, uint level,
                                uint mean, uint dither) {
    Blended result;
    result.code = code;
    result.saturated = 0u;
    uint size = uint(abs(weight));
    if (rule == STAMP_RULE_ADD) {
        uint magnitude = scaled(amplitude, size);
        if (bits16) magnitude = dithered(magnitude, dither);
        result = added(code, magnitude, negative != (weight < 0), top_code(bits16));
    } else if (rule == STAMP_RULE_MIN || rule == STAMP_RULE_MAX) {
        Blended target = target_code(level, scaled(amplitude, size), negative, bits16);
        uint chosen = rule == STAMP_RULE_MIN ? min(code, target.code) : max(code, target.code);
        result.code = weight > 0 ? chosen : code;
        result.saturated = weight > 0 ? target.saturated : 0u;
    } else if (rule == STAMP_RULE_SET) {
        Blended target = target_code(level, amplitude, negative, bits16);
        uint reached = moved(code, target.code, size, bits16, dither);
        result.code = weight > 0 ? reached : code;
        result.saturated = weight > 0 ? target.saturated : 0u;
    } else {
        uint reached = moved(code, mean, scaled(amplitude, size), bits16, dither);
        result.code = weight > 0 ? reached : code;
    }
    return result;
}

// The residue of a zero-volume stamp, at its centre texel, after `blended`.
SHARED_FUNCTION Blended with_residue(Blended before, uint residue, bool negative, bool bits16) {
    Blended result = added(before.code, residue, negative, top_code(bits16));
    result.saturated = max(result.saturated, before.saturated);
    return result;
}
#endif
