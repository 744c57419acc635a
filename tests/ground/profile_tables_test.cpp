// The committed tables are the formulae of shape_library.h, rounded half to even; turns are angles.
#include "tilth/ground/profile_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tilth/ground/turn.h"

namespace tilth {
namespace {

constexpr long double kPi = std::numbers::pi_v<long double>;

long double formula(BuiltinProfile profile, long double t) {
    switch (profile) {
        case BuiltinProfile::Gaussian:
            return (std::exp(-6 * t * t) - std::exp(-6.0L)) / (1 - std::exp(-6.0L));
        case BuiltinProfile::Cone:
            return 1 - t;
        case BuiltinProfile::Paraboloid:
            return 1 - t * t;
        case BuiltinProfile::Cosine:
            return (1 + std::cos(kPi * t)) / 2;
        case BuiltinProfile::Crater:
            return (1 - t * t) * (1 - t * t) * (1 - 4 * t * t);
        case BuiltinProfile::Disc:
            return 1;
    }
    return NAN;
}

TEST(ProfileTables, AreTheFormulaeRoundedHalfToEven) {
    for (std::uint32_t p = 0; p < kBuiltinProfiles; ++p) {
        const auto profile = static_cast<BuiltinProfile>(p);
        const std::span<const std::int32_t> table = profile_table(profile);
        ASSERT_EQ(table.size(), 1025u);
        for (int i = 0; i <= 1024; ++i) {
            const long double exact = 65536 * formula(profile, i / 1024.0L);
            ASSERT_EQ(table[static_cast<std::size_t>(i)], static_cast<std::int32_t>(std::nearbyint(exact)))
                << "profile " << p << " entry " << i;
        }
        EXPECT_EQ(table[0], 65536);
        EXPECT_EQ(table[1024], profile == BuiltinProfile::Disc ? 65536 : 0);
        EXPECT_EQ(ShapeLibrary().shape({p}).weights, std::vector<std::int32_t>(table.begin(), table.end()));
    }
}

// Volume of the formula, 2 pi int w t dt: the crater has none.
TEST(ProfileTables, TheCraterHasNoVolume) {
    long double sum = 0;
    constexpr int kSteps = 1 << 16;
    for (int i = 0; i < kSteps; ++i) {
        const long double t = (i + 0.5L) / kSteps;
        sum += formula(BuiltinProfile::Crater, t) * t / kSteps;
    }
    EXPECT_NEAR(static_cast<double>(sum), 0, 1e-9);
}

TEST(Turn, SineAndCosineAreWithinTwoToTheMinus28) {
    std::mt19937 random(6);
    long double worst = 0;
    for (int i = 0; i < 1000000; ++i) {
        const auto turns = static_cast<std::uint32_t>(random());
        const long double angle = 2 * kPi * turns / 4294967296.0L;
        const SineCosine got = sine_cosine(turns);
        worst = std::max({worst, std::abs(got.sine / 1073741824.0L - std::sin(angle)),
                          std::abs(got.cosine / 1073741824.0L - std::cos(angle))});
    }
    EXPECT_LT(worst, 0x1p-28L);
}

TEST(Turn, QuarterTurnsAreExactAndTheOctantsJoin) {
    constexpr std::int32_t kOne = 1 << 30;
    const std::int32_t sines[] = {0, kOne, 0, -kOne};
    for (std::uint32_t q = 0; q < 4; ++q) {
        const SineCosine turn = sine_cosine(q << 30);
        EXPECT_EQ(turn.sine, sines[q]);
        EXPECT_EQ(turn.cosine, sines[(q + 1) % 4]);
    }
    for (std::uint32_t octant = 0; octant < 8; ++octant)  // where the reduction changes quarter
        for (const std::uint32_t step : {0xffffffffu, 0u, 1u}) {
            const std::uint32_t turns = (octant << 29) + step;
            const long double angle = 2 * kPi * turns / 4294967296.0L;
            EXPECT_NEAR(sine_cosine(turns).sine / 0x1p30, static_cast<double>(std::sin(angle)), 0x1p-28) << turns;
            EXPECT_NEAR(sine_cosine(turns).cosine / 0x1p30, static_cast<double>(std::cos(angle)), 0x1p-28) << turns;
        }
}

TEST(Turn, AnglesBecomeTurns) {
    constexpr double kHalfPi = std::numbers::pi / 2;
    EXPECT_EQ(turns_of(0), 0u);
    EXPECT_EQ(turns_of(-0.0), 0u);
    EXPECT_EQ(turns_of(kHalfPi), 1u << 30);
    EXPECT_EQ(turns_of(2 * kHalfPi), 1u << 31);
    EXPECT_EQ(turns_of(-kHalfPi), 3u << 30);
    EXPECT_EQ(turns_of(4 * kHalfPi), 0u);
    EXPECT_EQ(turns_of(1e-7), 68u);  // 1e-7 / 2 pi * 2^32 = 68.36
    EXPECT_EQ(turns_of(-1e-7), 0u - 68u);
    EXPECT_EQ(turns_of(-1e-20), 0u);
    EXPECT_EQ(turns_of(1e-300), 0u);
    for (const double angle : {1.0, -1.0, 0.3, 1000.0, -12345.678, 1e9, -1e9}) {
        const long double turns = static_cast<long double>(angle) / (2 * kPi);
        const long double expected = (turns - std::floor(turns)) * 4294967296.0L;
        // pi as a double and the division err by 2^-53 each, relative to all the turns.
        const double tolerance = 0.5 + std::abs(angle) * 0x1p-52 * 4294967296.0;
        const auto difference = static_cast<std::int32_t>(
            turns_of(angle) - static_cast<std::uint32_t>(static_cast<std::uint64_t>(std::nearbyint(expected))));
        EXPECT_LE(std::abs(difference), tolerance) << angle;
    }
}

TEST(DirectionAngle, IsAtan2WithoutLibm) {
    EXPECT_EQ(direction_angle(0, 0), 0);
    EXPECT_EQ(direction_angle(1, 0), 0);
    EXPECT_EQ(turns_of(direction_angle(0, 1)), 1u << 30) << "quarter turns are exact";
    EXPECT_EQ(turns_of(direction_angle(-1, 0)), 1u << 31);
    EXPECT_EQ(turns_of(direction_angle(0, -1)), 3u << 30);
    for (int i = 0; i < 100000; ++i) {
        const double x = std::cos(i * 0.7) * (1 + i % 7), y = std::sin(i * 1.3) * (1 + i % 11);
        ASSERT_NEAR(direction_angle(x, y), std::atan2(y, x), 1e-14) << x << ", " << y;
    }
}

}  // namespace
}  // namespace tilth
