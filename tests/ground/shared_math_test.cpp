// Height planes and slopes of shaders/shared/, as C++.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tilth/core/shared_glsl.h"
namespace tilth::shared {
#include "shared/height_code.glsl"
#include "shared/slope_math.glsl"
}  // namespace tilth::shared

namespace tilth {
namespace {

using namespace shared;

// GL rounds a store to the nearest of 65 536 levels or truncates; both must give the integer back.
TEST(HeightCode, EveryPlaneValueComesBack) {
    for (std::uint32_t bits = 0; bits < 65536; ++bits) {
        const double clamped = std::min(1.0, static_cast<double>(plane_value(bits)));
        ASSERT_EQ(static_cast<std::uint32_t>(std::floor(clamped * 65535)), bits);
        ASSERT_EQ(static_cast<std::uint32_t>(std::floor(clamped * 65535 + 0.5)), bits);
        const float sampled = static_cast<float>(bits / 65535.0);
        ASSERT_EQ(plane_bits(sampled), bits);
        ASSERT_EQ(plane_bits(std::nextafter(sampled, 2.0f)), bits);  // a sampler may err by an ulp
        ASSERT_EQ(plane_bits(std::nextafter(sampled, -1.0f)), bits);
        ASSERT_EQ(code_of_planes(sampled, static_cast<float>((bits ^ 0x5a5au) / 65535.0)),
                  bits << 16 | (bits ^ 0x5a5au));
    }
}

TEST(SlopeMath, StencilsAreExactOnPolynomialsOfTheirOrder) {
    // h = 3 x^3 - 40 x^2 + 7 x code quanta about the middle; derivatives in closed form. Small integers: floats are
    // exact.
    const auto code = [](int x) {
        return 0x80000000u + static_cast<std::uint32_t>(3 * x * x * x - 40 * x * x + 7 * x);
    };
    for (int x = -20; x <= 20; ++x) {
        const double slope = 9.0 * x * x - 80.0 * x + 7, tolerance = 1e-6 * (1 + std::abs(slope));
        const auto along = [&](int position, int last, bool fourth) {
            const auto clamped = [&](int step) { return code(x + std::clamp(position + step, 0, last) - position); };
            return slope_along(clamped(-2), clamped(-1), clamped(1), clamped(2), position, last, fourth, 0.25f);
        };
        for (const int position : {2, 3, 98}) {
            EXPECT_NEAR(along(position, 100, true), slope * 0.25, tolerance);
            EXPECT_NEAR(along(position, 100, false), (slope + 3) * 0.25,
                        tolerance);  // + a sixth of the third derivative
        }
        for (const int position : {1, 99}) EXPECT_NEAR(along(position, 100, true), (slope + 3) * 0.25, tolerance);
        const double bend = 18.0 * x - 80;  // the second derivative: half of it shows in a one-sided difference
        for (const bool fourth : {false, true}) {
            EXPECT_NEAR(along(0, 100, fourth), (slope + bend / 2 + 3) * 0.25, tolerance);
            EXPECT_NEAR(along(100, 100, fourth), (slope - bend / 2 + 3) * 0.25, tolerance);
            EXPECT_NEAR(along(0, 1, fourth), (slope + bend / 2 + 3) * 0.25, tolerance);  // a map of two posts
        }
    }
    EXPECT_EQ(code_difference(7u, 7u), 0.0f);
    EXPECT_EQ(code_difference(0xffffffffu, 0u), 4294967296.0f);  // no wrap at a full-range cliff
    EXPECT_EQ(code_difference(0u, 0xffffffffu), -4294967296.0f);
}

// S16: stored as RG8, a cliff keeps its direction within a degree and its sign; nothing overflows.
TEST(SlopeMath, CompandingKeepsDirectionUpToCliffs) {
    EXPECT_EQ(slope_byte(0.0f, 0.0f), 128);
    EXPECT_EQ(slope_signed(128.0f / 255.0f), 0.0f);
    for (const double slope : {0.5, 1.0, 3.0, 30.0, 333.0, 1e4, 1e30}) {
        for (int degree = 0; degree < 360; ++degree) {
            const double angle = degree * std::numbers::pi / 180;
            const auto x = static_cast<float>(slope * std::cos(angle)), z = static_cast<float>(slope * std::sin(angle));
            const auto length = static_cast<float>(slope);
            const auto stored = [&](float component) {
                const int byte = slope_byte(component, length);
                EXPECT_GE(byte, 1);
                EXPECT_LE(byte, 255);
                return slope_signed(static_cast<float>(byte) / 255.0f);
            };
            const float sx = stored(x), sz = stored(z);
            // Half a step of 1/127 on each axis across a vector of length s / (1 + s).
            const double bound = std::atan(0.5 * std::numbers::sqrt2 / 127 / (slope / (1 + slope)) * 1.01);
            const double turned = std::remainder(std::atan2(sz, sx) - angle, 2 * std::numbers::pi);
            EXPECT_LE(std::abs(turned), bound) << slope << " at " << degree;
            if (slope >= 1) {
                EXPECT_LE(std::abs(turned), std::numbers::pi / 180) << slope << " at " << degree;
            }
            const float expansion = slope_expansion(std::hypot(sx, sz));
            ASSERT_TRUE(std::isfinite(expansion));
            EXPECT_LE(expansion, 255.0f);
            if (slope <= 3) {  // the error of |c| grows by (1 + s)^2 on the way back
                const double size = std::hypot(sx, sz) * expansion;
                EXPECT_NEAR(size, slope, 0.75 / 127 * std::pow(1 + slope, 2) * 1.3) << slope << " at " << degree;
            }
        }
    }
}

}  // namespace
}  // namespace tilth
