// Stamps along a polyline: spacing, sides, turning, keys, limits.
#include "tilth/ground/path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ground/support.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

std::vector<StampRequest> along(const PathRequest& path) {
    const Result<std::vector<StampRequest>> stamps = stamps_along(path);
    EXPECT_TRUE(stamps.ok()) << (stamps.ok() ? "" : stamps.error().message);
    return stamps.ok() ? *stamps : std::vector<StampRequest>{};
}

TEST(Path, StampsAreSpacedByDistanceRoundCorners) {
    // 3 m east, then 4 m south, a repeated point between.
    const std::vector<StampRequest> stamps =
        along({.points = {{10, 20}, {13, 20}, {13, 20}, {13, 24}}, .spacing_m = 0.75});
    ASSERT_EQ(stamps.size(), 10u);  // 0, 0.75, .. 6.75 of 7 m
    for (std::size_t i = 0; i < stamps.size(); ++i) {
        const double s = 0.75 * static_cast<double>(i);
        EXPECT_NEAR(stamps[i].centre.x, s <= 3 ? 10 + s : 13, 1e-12) << i;
        EXPECT_NEAR(stamps[i].centre.z, s <= 3 ? 20 : 20 + s - 3, 1e-12) << i;
    }
}

TEST(Path, TheLastStampIsNotLostToRounding) {
    // 0.1 + 0.1 + 0.1 > 0.3 in doubles.
    EXPECT_EQ(along({.points = {{0, 0}, {0.3, 0}}, .spacing_m = 0.1}).size(), 4u);
    EXPECT_EQ(along({.points = {{0, 0}, {0.1, 0}, {0.2, 0}, {0.3, 0}}, .spacing_m = 0.1}).size(), 4u);
    EXPECT_EQ(along({.points = {{0, 0}, {0.299, 0}}, .spacing_m = 0.1}).size(), 3u);
}

TEST(Path, SidesAlternateLeftFirstAndEverySecondIsMirrored) {
    for (const bool mirror : {false, true}) {
        const std::vector<StampRequest> stamps =
            along({.stamp = {.mirror = mirror}, .points = {{0, 0}, {10, 0}}, .spacing_m = 2, .alternate_m = 0.15});
        ASSERT_EQ(stamps.size(), 6u);
        for (std::size_t i = 0; i < stamps.size(); ++i) {
            // Walking along +x with +y up and +z to the right hand: left is -z.
            EXPECT_NEAR(stamps[i].centre.x, 2.0 * static_cast<double>(i), 1e-12);
            EXPECT_NEAR(stamps[i].centre.z, i % 2 == 0 ? -0.15 : 0.15, 1e-12);
            EXPECT_EQ(stamps[i].mirror, i % 2 == 0 ? mirror : !mirror);
        }
        // Left is left in every direction: to the left hand of (3, 4) / 5 lies (4, -3) / 5.
        const StampRequest first =
            along({.stamp = {.mirror = mirror}, .points = {{0, 0}, {3, 4}}, .spacing_m = 2, .alternate_m = 0.5})[0];
        EXPECT_NEAR(first.centre.x, 0.4, 1e-12);
        EXPECT_NEAR(first.centre.z, -0.3, 1e-12);
    }
    for (const StampRequest& stamp : along({.points = {{0, 0}, {10, 0}}})) EXPECT_FALSE(stamp.mirror);
}

// An image that points along its +x, walked in several directions, stamped: its centre of mass lies ahead.
TEST(Path, TheImagesXAxisPointsAlongThePath) {
    for (const WorldPos direction : {WorldPos{0, 1}, {1, 0}, {-1, 0}, {0, -1}, {0.6, 0.8}, {-0.8, 0.6}})
        for (const double turned : {0.0, 1.0, 10.0, 11.0}) {  // from 10 on mirrored
            const bool mirror = turned >= 10;
            auto ground = test::flat_ground(33, {.detail = false});
            const ShapeId arrow = *ground->shapes().bake("arrow", 64, [](double x, double) { return x > 0 ? x : 0.0; });
            const double extra = mirror ? turned - 10 : turned;
            const std::vector<StampRequest> stamps = along(
                {.stamp = {.shape = arrow, .radius_m = 6, .amplitude_m = 1, .rotation_rad = extra, .mirror = mirror},
                 .points = {{16, 16}, {16 + direction.x, 16 + direction.z}},
                 .spacing_m = 5});
            ASSERT_EQ(stamps.size(), 1u);
            test::stamp(*ground, stamps[0]);
            double mass = 0, x_sum = 0, z_sum = 0;
            for (int z = 0; z < 33; ++z)
                for (int x = 0; x < 33; ++x) {
                    const double m = static_cast<double>(ground->coarse().code({x, z})) - kMidCode;
                    mass += m, x_sum += m * (x - 16), z_sum += m * (z - 16);
                }
            // 2/3 of the radius ahead; `rotation_rad` a turns (x, z) to (x cos a + z sin a, z cos a - x sin a).
            const double c = std::cos(extra), s = std::sin(extra);
            EXPECT_NEAR(x_sum / mass, 4 * (direction.x * c + direction.z * s), 0.35);
            EXPECT_NEAR(z_sum / mass, 4 * (direction.z * c - direction.x * s), 0.35);
        }
}

TEST(Path, KeysCountUpIfGiven) {
    const std::vector<StampRequest> keyed =
        along({.stamp = {.key = 0xfffffffeu}, .points = {{0, 0}, {3, 0}}, .spacing_m = 1});
    ASSERT_EQ(keyed.size(), 4u);
    EXPECT_EQ(keyed[0].key, 0xfffffffeu);
    EXPECT_EQ(keyed[3].key, 1u);
    for (const StampRequest& stamp : along({.points = {{0, 0}, {3, 0}}})) EXPECT_FALSE(stamp.key);
}

TEST(Path, OnePlaceIsOneStamp) {
    EXPECT_EQ(along({.points = {{3, 4}}}).size(), 1u);
    EXPECT_EQ(along({.points = {{3, 4}, {3, 4}, {3, 4}}}).size(), 1u);
    EXPECT_EQ(along({.points = {{3, 4}}})[0].centre, (WorldPos{3, 4}));
    EXPECT_EQ(along({.points = {{0, 0}, {0.1, 0}}, .spacing_m = 5}).size(), 1u);
}

TEST(Path, RefusesWhatItCannotWalk) {
    const double inf = INFINITY, nan = NAN;
    const auto field = [](const PathRequest& path) {
        const Result<std::vector<StampRequest>> result = stamps_along(path);
        return result.ok() ? std::string("walked") : result.error().message.substr(0, result.error().message.find(':'));
    };
    EXPECT_EQ(field({}), "points");
    for (const double v : {inf, nan}) {
        EXPECT_EQ(field({.points = {{0, 0}, {v, 0}}}), "points");
        EXPECT_EQ(field({.points = {{0, v}}}), "points");
    }
    for (const double v : {inf, nan, 0.0, -1.0})
        EXPECT_EQ(field({.points = {{0, 0}, {1, 0}}, .spacing_m = v}), "spacing");
    for (const double v : {inf, nan, -0.1})
        EXPECT_EQ(field({.points = {{0, 0}, {1, 0}}, .alternate_m = v}), "alternate");
    EXPECT_EQ(field({.points = {{0, 0}, {1000, 0}}, .spacing_m = 0.001}), "spacing");  // a million and one
    EXPECT_EQ(field({.points = {{0, 0}, {1e200, 0}}, .spacing_m = 1e-200}), "spacing");
    EXPECT_EQ(along({.points = {{0, 0}, {999, 0}}, .spacing_m = 1}).size(), 1000u);
}

}  // namespace
}  // namespace tilth
