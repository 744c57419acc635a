// The comparison that golden pictures are judged by refuses what is too far off, and nothing that is not.
#include "demo/picture_compare.h"

#include <gtest/gtest.h>

namespace tilth::test {
namespace {

io::Rgb8Picture grey(std::uint8_t value) { return {100, 100, std::vector<std::uint8_t>(100 * 100 * 3, value)}; }

/// `grey` with the green of its first `pixels` pixels `steps` brighter.
io::Rgb8Picture spotted(std::size_t pixels, int steps) {
    io::Rgb8Picture picture = grey(100);
    for (std::size_t i = 0; i < pixels; ++i) picture.pixels[3 * i + 1] = std::uint8_t(100 + steps);
    return picture;
}

TEST(PictureCompare, APictureIsLikeItself) {
    const PictureDistance d = distance_between(grey(100), grey(100));
    EXPECT_EQ(d.mean_steps, 0);
    EXPECT_EQ(d.share_far_off, 0);
    EXPECT_TRUE(alike(d));
}

TEST(PictureCompare, OneStepInHalfOfAllChannelsIsTheLimit) {
    io::Rgb8Picture other = grey(100);
    for (std::size_t i = 0; i < other.pixels.size() / 2; ++i) other.pixels[i] = i % 2 == 0 ? 99 : 101;
    EXPECT_EQ(distance_between(grey(100), other).mean_steps, 0.5);
    EXPECT_TRUE(alike(distance_between(grey(100), other)));
    other.pixels.back() = 101;
    EXPECT_FALSE(alike(distance_between(grey(100), other)));
}

TEST(PictureCompare, TwoPixelsInAThousandMayBeFarOff) {
    EXPECT_TRUE(alike(distance_between(grey(100), spotted(20, 155))));
    EXPECT_FALSE(alike(distance_between(grey(100), spotted(21, 155))));
    EXPECT_FALSE(alike(distance_between(spotted(21, 155), grey(100)))) << "darker counts as brighter does";
}

TEST(PictureCompare, EightStepsAreNotFarOffNineAre) {
    EXPECT_EQ(distance_between(grey(100), spotted(21, 8)).share_far_off, 0);
    EXPECT_EQ(distance_between(grey(100), spotted(21, 9)).share_far_off, 0.0021);
}

}  // namespace
}  // namespace tilth::test
