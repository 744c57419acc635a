// shared/prelude.glsl: what lets one file be GLSL 3.30 and C++20. In C++ the includer opens namespace tilth::shared.
// Only scalars, structs of scalars and functions of them: no vectors, no out parameters, no overloads by precision.
// Everything is exact integers unless a comment says float.
#ifndef TILTH_SHARED_PRELUDE
#define TILTH_SHARED_PRELUDE
#ifdef TILTH_GLSL
#define SHARED_FUNCTION
#define SHARED_CONSTANT const
#else
#define SHARED_FUNCTION inline
#define SHARED_CONSTANT inline constexpr
#endif

#ifdef TILTH_GLSL
// High 32 bits of a * b. GLSL 3.30 has no umulExtended, so four 16-bit products.
uint mul_high(uint a, uint b) {
    uint a_low = a & 65535u, a_high = a >> 16, b_low = b & 65535u, b_high = b >> 16;
    uint low = a_low * b_low, cross_1 = a_high * b_low, cross_2 = a_low * b_high;
    uint middle = (low >> 16) + (cross_1 & 65535u) + (cross_2 & 65535u);
    return a_high * b_high + (cross_1 >> 16) + (cross_2 >> 16) + (middle >> 16);
}

// Integer square root of x * x + z * z, |x|, |z| < 2^23: a float estimate, corrected to the exact integer.
// float(n) may round to 24 bits and sqrt may err by a few ulp, so the estimate is off by a few (at most 6 for a root < 2^23.5).
uint root_of_squares(int x, int z) {
    uint ax = uint(abs(x)), az = uint(abs(z));
    uint x_high = mul_high(ax, ax), z_high = mul_high(az, az);
    uint x_low = ax * ax, low = x_low + az * az;
    uint high = x_high + z_high + (low < x_low ? 1u : 0u);
    // At least 1: where sqrt(x) is x * inversesqrt(x), sqrt(0) would be NaN.
    uint root = uint(sqrt(max(float(high) * 4294967296.0f + float(low), 1.0f)));
    for (int step = 0; step < 8; ++step) {
        uint square_high = mul_high(root, root), square_low = root * root;
        if (square_high < high || (square_high == high && square_low <= low)) break;
        --root;
    }
    for (int step = 0; step < 8; ++step) {
        uint next = root + 1u;
        uint square_high = mul_high(next, next), square_low = next * next;
        if (square_high > high || (square_high == high && square_low > low)) break;
        root = next;
    }
    return root;
}
#else
// High 32 bits of a * b.
inline uint mul_high(uint a, uint b) { return uint((std::uint64_t{a} * b) >> 32); }

// Integer square root of x * x + z * z, |x|, |z| < 2^24. The sum is exact in a double (< 2^49), IEEE sqrt rounds
// correctly, and the nearest irrational root is further from an integer than its rounding error: truncation is exact.
inline uint root_of_squares(int x, int z) {
    const double dx = x, dz = z;
    return uint(int(__builtin_sqrt(dx * dx + dz * dz)));
}
#endif
#endif
