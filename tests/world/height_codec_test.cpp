#include "tilth/world/height_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tilth {
namespace {

constexpr std::uint32_t kTop = 0xffff'ffffu;

TEST(HeightCodec, EveryCodeComesBack) {
    std::mt19937 random(1);
    for (const HeightCodec codec : {HeightCodec::detail(), HeightCodec{0, 1.0 / 64}, HeightCodec{512.25, 1.0 / 1024},
                                    HeightCodec{-8848.43, 0.5}, HeightCodec{1234.56789, 1.0}}) {
        const auto check = [&](std::uint32_t code) {
            ASSERT_EQ(codec.code(codec.height_m(code), HeightPrecision::bits32), code);
            const std::uint32_t high = code & 0xffff'0000u;
            ASSERT_EQ(codec.code(codec.height_m(high), HeightPrecision::bits16), high);
            // One rounding of a double: height = middle + (code - 2^31) quantum / 65536.
            const long double exact = static_cast<long double>(codec.middle_m) +
                                      (static_cast<long double>(code) - 2147483648.0L) * codec.quantum_m / 65536.0L;
            ASSERT_EQ(codec.height_m(code), static_cast<double>(exact));
        };
        for (const std::uint32_t code :
             {0u, 1u, 65535u, 65536u, kMidCode - 1, kMidCode, kMidCode + 1, 0xffff'0000u, kTop - 1, kTop})
            check(code);
        for (int i = 0; i < 100000; ++i) check(static_cast<std::uint32_t>(random()));
    }
}

TEST(HeightCodec, TakesTheNearestCode) {
    std::mt19937_64 random(2);
    const HeightCodec codec{100, 1.0 / 64};
    std::uniform_real_distribution<double> height(codec.min_m(), codec.max_m());
    for (int i = 0; i < 100000; ++i) {
        const double h = height(random);
        EXPECT_LE(std::abs(codec.height_m(codec.code(h, HeightPrecision::bits32)) - h),
                  codec.code_quantum_m() * 0.5000001);
        const std::uint32_t high = codec.code(h, HeightPrecision::bits16);
        EXPECT_EQ(high & 65535u, 0u);
        if (h < codec.max_m() - codec.quantum_m) {
            EXPECT_LE(std::abs(codec.height_m(high) - h), codec.quantum_m * 0.5000001);
        }
    }
}

TEST(HeightCodec, SaturatesOutsideItsRange) {
    const HeightCodec codec{10, 1.0 / 64};
    for (const double beyond : {0.001, 1.0, 1e6, 1e300}) {
        EXPECT_EQ(codec.code(codec.max_m() + beyond, HeightPrecision::bits32), kTop);
        EXPECT_EQ(codec.code(codec.min_m() - beyond, HeightPrecision::bits32), 0u);
        EXPECT_EQ(codec.code(codec.max_m() + beyond, HeightPrecision::bits16), 0xffff'0000u);
        EXPECT_EQ(codec.code(codec.min_m() - beyond, HeightPrecision::bits16), 0u);
    }
    EXPECT_EQ(codec.height_m(0), codec.min_m());
    EXPECT_EQ(codec.height_m(kTop), codec.max_m());
}

TEST(HeightCodec, DetailIsTwoToTheMinusTwelveAndMinusTwentyEightOverEightMetresEitherWay) {
    const HeightCodec codec = HeightCodec::detail();
    EXPECT_EQ(codec.quantum_m, std::ldexp(1.0, -12));
    EXPECT_EQ(codec.code_quantum_m(), std::ldexp(1.0, -28));
    EXPECT_EQ(codec.height_m(kMidCode), 0.0);
    EXPECT_EQ(codec.min_m(), -8.0);
    EXPECT_EQ(codec.max_m(), 8.0 - std::ldexp(1.0, -28));
}

// The default: the smallest power of two with 65536 q >= 4 (max - min) + 64 m; mid-code at the middle.
TEST(HeightCodec, RangeChoosesTheSmallestSufficientPowerOfTwo) {
    const auto check = [](double low, double high) {
        const HeightCodec codec = HeightCodec::for_range(low, high);
        int exponent = 0;
        ASSERT_EQ(std::frexp(codec.quantum_m, &exponent), 0.5) << low << " " << high;
        const long double needed = 4 * (static_cast<long double>(high) - low) + 64;
        ASSERT_GE(65536.0L * codec.quantum_m, needed) << low << " " << high;
        ASSERT_LT(65536.0L * codec.quantum_m / 2, needed) << low << " " << high;
        ASSERT_EQ(codec.middle_m, (low + high) / 2);
        ASSERT_GE(low, codec.min_m());
        ASSERT_LE(high, codec.max_m());
    };
    EXPECT_EQ(HeightCodec::for_range(5, 5).quantum_m, 1.0 / 1024);  // 64 m, met exactly
    EXPECT_EQ(HeightCodec::for_range(0, 240).quantum_m, 1.0 / 64);  // 1 024 m, met exactly
    EXPECT_EQ(HeightCodec::for_range(0, 240.001).quantum_m, 1.0 / 32);
    EXPECT_EQ(HeightCodec::for_range(0, 1024).quantum_m, 1.0 / 8);  // 4 160 m of 8 192 m
    EXPECT_EQ(HeightCodec::for_range(-11000, 8848).quantum_m, 2.0);
    for (int step = 0; step < 4000; ++step) check(-3.5 * step, 0.01 * step * step);
    check(0, 0), check(-1e6, 1e6), check(1e-300, 2e-300), check(-430, -430);
}

}  // namespace
}  // namespace tilth
