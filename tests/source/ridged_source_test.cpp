#include "tilth/source/ridged_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tilth {
namespace {

TEST(RidgedSource, FillsTheReliefExactly) {
    for (const std::int32_t size : {2, 3, 17, 129, 300})
        for (const double relief : {200.0, 0.1, 1e6})
            for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{7}, ~std::uint64_t{0}}) {
                const auto source = make_ridged_source({.seed = seed, .size = size, .relief_m = relief});
                EXPECT_EQ(source->width(), size);
                EXPECT_EQ(source->depth(), size);
                EXPECT_EQ(source->min_m(), 0.0);
                EXPECT_EQ(source->max_m(), double{static_cast<float>(relief)});
            }
}

TEST(RidgedSource, IsAFunctionOfItsSeed) {
    const auto a = make_ridged_source({.seed = 7, .size = 129}), b = make_ridged_source({.seed = 7, .size = 129});
    const auto c = make_ridged_source({.seed = 8, .size = 129});
    EXPECT_TRUE(std::ranges::equal(a->heights_m(), b->heights_m()));
    std::size_t equal = 0;
    for (std::size_t i = 0; i < a->heights_m().size(); ++i) equal += a->heights_m()[i] == c->heights_m()[i];
    EXPECT_LT(equal, a->heights_m().size() / 100);
}

/// Mean square of the difference of posts `distance` apart, along both axes, m^2.
double structure(const RasterSource& source, int distance) {
    double sum = 0;
    int count = 0;
    for (int z = 0; z + distance < source.depth(); z += 3)
        for (int x = 0; x + distance < source.width(); x += 3, count += 2) {
            const double here = source.height_m({x, z});
            sum += std::pow(source.height_m({x + distance, z}) - here, 2) +
                   std::pow(source.height_m({x, z + distance}) - here, 2);
        }
    return sum / count;
}

// Natural terrain: difference grows with distance as distance^(2 H), H between 0.5 and 1; flat noise has H = 0.
TEST(RidgedSource, MostEnergyIsAtLongWavelengths) {
    for (const std::uint64_t seed : {1u, 7u, 42u}) {
        const auto source = make_ridged_source({.seed = seed, .size = 513, .relief_m = 100});
        const double hurst = 0.5 * std::log2(structure(*source, 16) / structure(*source, 4)) / 2;
        EXPECT_GT(hurst, 0.5) << seed;
        EXPECT_LT(hurst, 1.0) << seed;
        EXPECT_GT(structure(*source, 128), 25 * structure(*source, 4)) << seed;
    }
}

// Posts sample the finest octave (cells of 8) well: at one post's distance the ground is nearly straight, so the second
// difference is much less than the first. White noise would give a ratio of 3.
TEST(RidgedSource, IsSmoothAtThePosts) {
    const auto source = make_ridged_source({.seed = 7, .size = 513, .relief_m = 100});
    double first = 0, second = 0;
    for (int z = 0; z < 513; ++z)
        for (int x = 1; x < 512; ++x) {
            const double before = source->height_m({x - 1, z}), here = source->height_m({x, z}),
                         after = source->height_m({x + 1, z});
            first += (after - here) * (after - here);
            second += std::pow(after - 2 * here + before, 2);
        }
    EXPECT_LT(second, 0.1 * first);
}

// Octaves are turned against each other, so over several seeds the ground is as steep along x as along z.
TEST(RidgedSource, HasNoPreferredAxis) {
    double along_x = 0, along_z = 0;
    for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
        const auto source = make_ridged_source({.seed = seed, .size = 257});
        for (int z = 0; z < 256; ++z)
            for (int x = 0; x < 256; ++x) {
                along_x += std::pow(source->height_m({x + 1, z}) - source->height_m({x, z}), 2);
                along_z += std::pow(source->height_m({x, z + 1}) - source->height_m({x, z}), 2);
            }
    }
    EXPECT_NEAR(along_x / along_z, 1.0, 0.3);
}

}  // namespace
}  // namespace tilth
