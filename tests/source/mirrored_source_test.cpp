#include "tilth/source/mirrored_source.h"

#include <gtest/gtest.h>

#include <limits>

#include "tilth/source/raster_source.h"

namespace tilth {
namespace {

/// Walks instead of computing: turns round at either end.
TEST(MirroredIndex, IsAWalkThatTurnsAtTheEnds) {
    for (const int n : {2, 3, 4, 17, 1025}) {
        int at = 0, step = 1;
        for (int p = 0; p < 5 * n; ++p) {
            ASSERT_EQ(mirrored_index(p, n), at) << "p " << p << " n " << n;
            ASSERT_EQ(mirrored_index(-p, n), at) << "p " << -p << " n " << n;
            if (at + step < 0 || at + step >= n) step = -step;
            at += step;
        }
    }
}

TEST(MirroredIndex, IsPeriodicAndInRangeAtTheEndsOfTheIntegers) {
    for (const int n : {2, 3, 1025, 16384, 1 << 20}) {
        const std::int64_t period = 2 * (std::int64_t{n} - 1);
        for (const std::int64_t p : {std::int64_t{std::numeric_limits<std::int32_t>::min()},
                                     std::int64_t{std::numeric_limits<std::int32_t>::max()},
                                     std::int64_t{-4'000'000'000'000}, std::int64_t{4'000'000'000'001}}) {
            const std::int32_t i = mirrored_index(p, n);
            EXPECT_GE(i, 0);
            EXPECT_LT(i, n);
            EXPECT_EQ(mirrored_index(p + period, n), i);
            EXPECT_EQ(mirrored_index(p - period, n), i);
            EXPECT_EQ(mirrored_index(-p, n), i);
        }
    }
}

TEST(MirroredSource, ShowsTheInnerMapReflected) {
    auto inner = RasterSource::create(3, 4, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, "inner");
    ASSERT_TRUE(inner.ok());
    const MirroredSource world(std::move(*inner));
    EXPECT_EQ(world.width(), 1 << 20);
    EXPECT_EQ(world.depth(), 1 << 20);
    EXPECT_EQ(world.min_m(), 0);
    EXPECT_EQ(world.max_m(), 11);
    EXPECT_EQ(world.height_m({2, 3}), 11);
    EXPECT_EQ(world.height_m({3, 3}), 10);  // x folded about 2
    EXPECT_EQ(world.height_m({2, 4}), 8);   // z folded about 3
    EXPECT_EQ(world.height_m({4 * 250000, 6 * 170000}), 0);
    for (int p = 1000; p < 1012; ++p) {  // continuous: neighbours of the world are neighbours (or the same) inside
        EXPECT_EQ(std::abs(world.height_m({p, 0}) - world.height_m({p + 1, 0})), 1);
        EXPECT_EQ(std::abs(world.height_m({0, p}) - world.height_m({0, p + 1})), 3);
    }
}

}  // namespace
}  // namespace tilth
