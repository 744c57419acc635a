// Both branches of shaders/shared/prelude.glsl against 64-bit integers: the C++ one, and the GLSL one compiled here
// with a square root that errs as GLSL's may.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>

namespace {

using uint = std::uint32_t;
using std::abs;
using std::max;

int g_sqrt_error_ulps = 0;
float sqrt(float value) {
    float root = std::sqrt(value);
    for (int i = 0; i < std::abs(g_sqrt_error_ulps); ++i)
        root = std::nextafter(root, g_sqrt_error_ulps > 0 ? 1e30f : 0.0f);
    return root;
}

namespace glsl {
#define TILTH_GLSL
#include "shared/prelude.glsl"
#undef TILTH_GLSL
#undef TILTH_SHARED_PRELUDE
#undef SHARED_FUNCTION
#undef SHARED_CONSTANT
}  // namespace glsl
namespace cpp {
#include "shared/prelude.glsl"
}

/// floor(sqrt(n)), by integers alone.
std::uint64_t integer_root(std::uint64_t n) {
    std::uint64_t root = 0;
    for (std::uint64_t bit = std::uint64_t{1} << 31; bit != 0; bit >>= 1)
        if ((root + bit) * (root + bit) <= n) root += bit;
    return root;
}

void check_root(int x, int z) {
    const std::uint64_t n =
        static_cast<std::uint64_t>(std::int64_t{x} * x) + static_cast<std::uint64_t>(std::int64_t{z} * z);
    const std::uint64_t expected = integer_root(n);
    ASSERT_EQ(cpp::root_of_squares(x, z), expected) << x << ", " << z;
    ASSERT_EQ(glsl::root_of_squares(x, z), expected) << x << ", " << z << " sqrt error " << g_sqrt_error_ulps << " ulp";
}

TEST(Prelude, MulHighIsTheUpperHalfOfTheProduct) {
    std::mt19937 random(3);
    const auto check = [](uint a, uint b) {
        const uint expected = static_cast<uint>(std::uint64_t{a} * b / 4294967296u);
        ASSERT_EQ(cpp::mul_high(a, b), expected) << a << " * " << b;
        ASSERT_EQ(glsl::mul_high(a, b), expected) << a << " * " << b;
    };
    const uint edges[] = {0u,          1u,          2u,          65535u,      65536u,      65537u,
                          0x7fffffffu, 0x80000000u, 0x80000001u, 0xfffeffffu, 0xffff0000u, 0xffffffffu};
    for (const uint a : edges)
        for (const uint b : edges) check(a, b);
    for (int i = 0; i < 1000000; ++i) check(static_cast<uint>(random()), static_cast<uint>(random()));
}

// A stamp's distances: |x|, |z| up to 2^23 and a texel, in sub-texels; a root as bad as 4.5 ulp either way.
TEST(Prelude, RootOfSquaresIsExactWhateverTheSquareRootErrs) {
    constexpr int kLargest = (1 << 23) + 2048;
    std::mt19937 random(4);
    for (const int ulps : {0, 1, -1, 3, -3, 5, -5}) {
        g_sqrt_error_ulps = ulps;
        for (int x = -40; x <= 40; ++x)
            for (int z = -40; z <= 40; ++z) check_root(x, z);
        for (int i = 0; i < 100000; ++i) {
            const int bits = 1 + static_cast<int>(random() % 24);
            const auto draw = [&] {
                return std::min(static_cast<int>(random() >> (32 - bits)), kLargest) * (random() % 2 == 0 ? 1 : -1);
            };
            check_root(draw(), draw());
        }
        // On and just beside perfect squares: Pythagorean (3k, 4k), and one unit more or less in a leg.
        for (int k = 1; k < kLargest / 4; k += 1 + k / 50)
            for (int d = -1; d <= 1; ++d) check_root(3 * k, 4 * k + d);
        for (const int edge : {kLargest, kLargest - 1, 1 << 23, (1 << 23) - 1, 4095, 4096, 4097})
            for (const int other : {0, 1, 2, edge - 1, edge}) check_root(edge, other), check_root(-other, -edge);
    }
    g_sqrt_error_ulps = 0;
}

// The C++ root holds over the whole range that its comment claims.
TEST(Prelude, RootOfSquaresInCppHoldsBelowTwoToTheTwentyFour) {
    std::mt19937 random(5);
    constexpr int kLargest = (1 << 24) - 1;
    for (int i = 0; i < 300000; ++i) {
        const int x = static_cast<int>(random() >> 8), z = static_cast<int>(random() >> 8);
        ASSERT_EQ(cpp::root_of_squares(x, -z),
                  integer_root(static_cast<std::uint64_t>(std::int64_t{x} * x + std::int64_t{z} * z)));
    }
    for (const int x : {kLargest, kLargest - 1, 1, 0})
        ASSERT_EQ(cpp::root_of_squares(-kLargest, x),
                  integer_root(static_cast<std::uint64_t>(std::int64_t{kLargest} * kLargest + std::int64_t{x} * x)));
}

}  // namespace
