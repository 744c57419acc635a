#include "tilth/source/raster_source.h"

#include <gtest/gtest.h>

#include <limits>

namespace tilth {
namespace {

std::vector<float> ramp(int count) {
    std::vector<float> heights;
    for (int i = 0; i < count; ++i) heights.push_back(static_cast<float>(i));
    return heights;
}

TEST(RasterSource, IsRowByRowAlongX) {
    const auto source = RasterSource::create(4, 3, ramp(12), "ramp");
    ASSERT_TRUE(source.ok());
    EXPECT_EQ((*source)->width(), 4);
    EXPECT_EQ((*source)->depth(), 3);
    for (int z = 0; z < 3; ++z)
        for (int x = 0; x < 4; ++x) EXPECT_EQ((*source)->height_m({x, z}), z * 4 + x);
}

TEST(RasterSource, RangeIsExactWhereverTheExtremesLie) {
    for (std::size_t low = 0; low < 6; ++low)
        for (std::size_t high = 0; high < 6; ++high) {
            if (low == high) continue;
            std::vector<float> heights(6, 0.5f);
            heights[low] = -0.1f;
            heights[high] = 1e5f;
            const auto source = RasterSource::create(3, 2, heights, "extremes");
            ASSERT_TRUE(source.ok());
            EXPECT_EQ((*source)->min_m(), double{-0.1f});
            EXPECT_EQ((*source)->max_m(), 1e5);
        }
}

TEST(RasterSource, RefusesWhatIsNotFiniteAndNamesTheTexel) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()})
        for (std::size_t at : {std::size_t{0}, std::size_t{7}, std::size_t{11}}) {
            std::vector<float> heights = ramp(12);
            heights[at] = bad;
            const auto source = RasterSource::create(4, 3, heights, "map.tif");
            ASSERT_FALSE(source.ok());
            EXPECT_EQ(source.error().code, ErrorCode::InvalidArgument);
            EXPECT_NE(source.error().message.find("map.tif"), std::string::npos);
            EXPECT_NE(source.error().message.find(text("(", at % 4, ", ", at / 4, ")")), std::string::npos)
                << source.error().message;
        }
}

TEST(RasterSource, RefusesSidesBelowTwoAndWrongCounts) {
    EXPECT_FALSE(RasterSource::create(1, 5, ramp(5), "a").ok());
    EXPECT_FALSE(RasterSource::create(5, 1, ramp(5), "a").ok());
    EXPECT_FALSE(RasterSource::create(-2, -2, ramp(4), "a").ok());
    EXPECT_FALSE(RasterSource::create(3, 3, ramp(8), "a").ok());
    EXPECT_FALSE(RasterSource::create(3, 3, ramp(10), "a").ok());
    EXPECT_TRUE(RasterSource::create(2, 2, ramp(4), "a").ok());
}

}  // namespace
}  // namespace tilth
