#include "tilth/render/relief_reach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tilth/derive/relief_rects.h"
#include "tilth/pool/relief_window.h"
#include "tilth/render/clipmap_layout.h"

namespace tilth {
namespace {

constexpr double kNoBound = 1e9;

TEST(ReliefReach, OfTheReferenceConfiguration) {
    // 127 units, less the border, the zone of 25.5 and roundings: 100.24 posts.
    const ReliefReach reach = relief_reach({.n = 255, .levels = 5, .blend = 0.1}, 0.1, 3, 1, kNoBound);
    EXPECT_NEAR(reach.reach_m, 10.024, 1e-9);
    EXPECT_EQ(reach.window_texels, 1024);
    const ReliefReach share = relief_reach({.n = 255, .levels = 5, .blend = 0.1}, 0.1, 3, 0.6, kNoBound);
    EXPECT_NEAR(share.reach_m, 0.6 * 10.024, 1e-9);
}

TEST(ReliefReach, EndsWhereThereIsNoDetailAndTakesNoMoreWindowThanThat) {
    const ReliefReach reach = relief_reach({.n = 255, .levels = 5, .blend = 0.1}, 0.1, 3, 1, 3.6);
    EXPECT_NEAR(reach.reach_m, 3.6, 1e-9);
    EXPECT_EQ(reach.window_texels, 512);
}

// Whatever begins within the reach lies in the window, wherever the eye stands: or it would show the other side of it.
TEST(ReliefReach, EveryBlockThatBeginsWithinItLiesInTheWindow) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(2000, 2100);
    int seen = 0, far = 0;
    for (const std::int32_t n : {15, 31, 63, 127, 255, 511, 1023}) {
        for (std::int32_t per_post = 1; per_post <= 64; ++per_post) {
            for (const double share : {0.05, 0.3, 1.0}) {
                const ClipmapSettings clipmap{.n = n, .levels = 3, .blend = 0.1};
                const ReliefReach reach = relief_reach(clipmap, 1, per_post, share, kNoBound);
                ASSERT_LE(reach.window_texels, ReliefWindow::kMostSize);
                if (reach.reach_m <= 0) continue;
                const PostPos eye{place(random), place(random)};
                const Texel at{static_cast<std::int32_t>(eye.x * per_post),
                               static_cast<std::int32_t>(eye.z * per_post)};
                const TexelRect square = relief_square(at, reach.window_texels, kReliefStep);
                for (const ClipmapBlock& b : clipmap_layout(clipmap, eye, 4100, 4100).blocks) {
                    if (b.level != 0) continue;
                    const double dx = std::max({b.x - eye.x, eye.x - (b.x + b.width), 0.0}),
                                 dz = std::max({b.z - eye.z, eye.z - (b.z + b.depth), 0.0});
                    if (std::hypot(dx, dz) >= reach.reach_m) continue;
                    const TexelRect texels{{b.x * per_post - 16, b.z * per_post - 16},
                                           {(b.x + b.width) * per_post + 17, (b.z + b.depth) * per_post + 17}};
                    ASSERT_EQ(intersection(texels, square), texels)
                        << "n " << n << ", " << per_post << " texels a post, share " << share;
                    ++seen;
                }
                far += reach.reach_m > 16;
            }
        }
    }
    EXPECT_GT(seen, 8'000);
    EXPECT_GT(far, 300);
}

TEST(ReliefReach, NoRoomIsAReachOfZero) {
    EXPECT_EQ(relief_reach({.n = 255, .levels = 5, .blend = 0.1}, 1, 64, 1, kNoBound).reach_m, 0);
}

TEST(ReliefReach, MarksLookAtNodesOfTwoPosts) {
    for (std::int32_t per_post = 1; per_post <= 64; ++per_post) {
        const std::int32_t cells = 2 << mark_level(per_post);
        EXPECT_GE(cells, std::min(2 * per_post, ReliefWindow::kTopCells)) << per_post;
        if (mark_level(per_post) > 0) {
            EXPECT_LT(cells / 2, 2 * per_post) << per_post;
        }
    }
}

}  // namespace
}  // namespace tilth
