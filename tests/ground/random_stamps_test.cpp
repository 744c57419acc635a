// The scenario step `random` against its definition, drawn here by another splitmix64.
#include "tilth/ground/random_stamps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ground/support.h"

namespace tilth {
namespace {

/// Vigna's splitmix64.c, state outside.
std::uint64_t split_mix(std::uint64_t& x) {
    std::uint64_t z = (x += 11400714819323198485ull);
    z ^= z >> 30;
    z *= 13787848793156543929ull;
    z ^= z >> 27;
    z *= 10723151780598845931ull;
    return z ^ (z >> 31);
}

TEST(SplitMix64, GivesThePublishedValues) {
    SplitMix64 random{1234567};  // the widely published first outputs of this seed
    for (const std::uint64_t expected : {6457827717110365317ull, 3203168211198807973ull, 9817491932198370423ull,
                                         4593380528125082431ull, 16408922859458223821ull})
        EXPECT_EQ(random.next(), expected);
    std::uint64_t state = 42;
    SplitMix64 same{42};
    for (int i = 0; i < 1000; ++i) ASSERT_EQ(same.next(), split_mix(state));
}

TEST(RandomStamps, AreDrawnInTheOrderOfTheScenario) {
    auto ground = test::flat_ground(129, {.origin = {-10, 5}, .spacing_m = 0.5});
    ground->mutable_coarse().codes()[0] = 0;  // the level is the original height, whatever happened since
    RandomStamps settings{.seed = 77,
                          .count = 500,
                          .region = {WorldPos{-20, 3}, WorldPos{60, 70}},
                          .radius_m = {0.1, 9},
                          .amplitude_m = {-0.3, 0.2},
                          .shapes = {{4}, {0}, {2}},
                          .rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth}};
    const std::vector<StampRequest> stamps = random_stamps(settings, *ground);
    ASSERT_EQ(stamps.size(), 500u);
    std::uint64_t state = 77;
    const auto unit = [&] { return static_cast<double>(split_mix(state) / 2048) / 9007199254740992.0; };
    int levels = 0;
    for (const StampRequest& stamp : stamps) {
        ASSERT_DOUBLE_EQ(stamp.centre.x, -20 + 80 * unit());
        ASSERT_DOUBLE_EQ(stamp.centre.z, 3 + 67 * unit());
        ASSERT_DOUBLE_EQ(stamp.radius_m, 0.1 + 8.9 * unit());
        const double amplitude = -0.3 + 0.5 * unit();
        ASSERT_EQ(stamp.shape, settings.shapes[static_cast<std::size_t>(std::floor(3 * unit()))]);
        ASSERT_EQ(stamp.rule, settings.rules[static_cast<std::size_t>(std::floor(5 * unit()))]);
        ASSERT_NEAR(stamp.amplitude_m, stamp.rule == StampRule::Smooth ? std::abs(amplitude) / 0.3 : amplitude, 1e-15);
        ASSERT_NEAR(stamp.rotation_rad, 2 * std::numbers::pi * unit(), 1e-14);
        ASSERT_EQ(stamp.mirror, unit() >= 0.5);
        const bool coarse_level =
            stamp.radius_m >= 4 && stamp.rule != StampRule::Add && stamp.rule != StampRule::Smooth;
        ASSERT_EQ(stamp.level_m.has_value(), coarse_level);
        levels += coarse_level ? 1 : 0;
        ASSERT_EQ(stamp.level_m.value_or(10.0), 10.0);
        ASSERT_TRUE(ground->issue(stamp).ok());
    }
    EXPECT_GT(levels, 30);
    ASSERT_EQ(random_stamps(settings, *ground).size(), 500u);
    settings.count = 0;
    EXPECT_TRUE(random_stamps(settings, *ground).empty());
}

// The level is that of the nearest post, clamped to the map.
TEST(RandomStamps, LevelIsTheNearestPostsOriginalHeight) {
    Result<std::unique_ptr<Ground>> made =
        Ground::create(std::make_shared<HillSource>(65, 12.0, 9.0), {.detail = false});
    ASSERT_TRUE(made.ok());
    const RandomStamps settings{
        .seed = 3, .count = 300, .region = {WorldPos{-15, -15}, WorldPos{80, 80}}, .rules = {StampRule::Set}};
    RandomStamps with_shape = settings;
    with_shape.shapes = {{0}};
    for (const StampRequest& stamp : random_stamps(with_shape, **made)) {
        double nearest = 1e300, level = 0;  // by trying all
        for (int z = 0; z < 65; ++z)
            for (int x = 0; x < 65; ++x) {
                const double d =
                    (stamp.centre.x - x) * (stamp.centre.x - x) + (stamp.centre.z - z) * (stamp.centre.z - z);
                if (d < nearest)
                    nearest = d, level = (*made)->height_m({static_cast<double>(x), static_cast<double>(z)});
            }
        ASSERT_NEAR(stamp.level_m.value_or(-1), level, 1e-12);
    }
}

}  // namespace
}  // namespace tilth
