// Which texels a region holds: those whose positions lie inside it, borders included.
#include <gtest/gtest.h>

#include "demo/player/region.h"

namespace tilth::demo {
namespace {

const GridSpec kPosts{.origin = {100, 200}, .spacing_m = 2, .width = 11, .depth = 6};

TEST(Region, BordersAreInside) {
    EXPECT_EQ(texels_in(kPosts, {{{104, 202}, {108, 206}}}), (TexelRect{{2, 1}, {5, 4}}));
    EXPECT_EQ(texels_in(kPosts, {{{104.1, 202.1}, {107.9, 205.9}}}), (TexelRect{{3, 2}, {4, 3}}));
    EXPECT_EQ(texels_in(kPosts, {{{104, 202}, {104, 202}}}).count(), 1);
}

TEST(Region, CornersComeInAnyOrder) {
    EXPECT_EQ(texels_in(kPosts, {{{108, 202}, {104, 206}}}), (TexelRect{{2, 1}, {5, 4}}));
}

TEST(Region, ItIsClippedToTheMap) {
    EXPECT_EQ(texels_in(kPosts, {{{-1e10, -1e10}, {1e10, 1e10}}}), kPosts.rect());
    EXPECT_TRUE(texels_in(kPosts, {{{0, 0}, {99, 300}}}).empty());
    EXPECT_TRUE(texels_in(kPosts, {{{121, 200}, {130, 300}}}).empty());
    EXPECT_TRUE(texels_in(kPosts, {{{104.5, 202}, {105.5, 206}}}).empty()) << "between two posts there is none";
}

TEST(Region, TenthsOfAMetreAreNotLostToRounding) {
    const GridSpec tenths{
        .origin = {0, 0}, .spacing_m = 0.1, .width = 4000, .depth = 4000};  // 0.3 / 0.1 < 3 in doubles
    for (int post = 0; post < 1300; ++post) {
        const TexelRect rect = texels_in(tenths, {{{post / 10.0, 0}, {post / 10.0, 0.3}}});
        ASSERT_EQ(rect, (TexelRect{{post, 0}, {post + 1, 4}})) << post;
    }
}

}  // namespace
}  // namespace tilth::demo
