// Rectangles on shelves never overlap, keep to their limits, and waste no pass.
#include "tilth/pool/shelves.h"

#include <gtest/gtest.h>

#include <vector>

#include "tilth/ground/random_stamps.h"
#include "tilth/world/texel.h"

namespace tilth {
namespace {

TEST(Shelves, RandomRectanglesLieApartWithinTheirLimits) {
    SplitMix64 random{3};
    for (int round = 0; round < 200; ++round) {
        const auto below = [&](int n) { return static_cast<std::int32_t>(random.next() % static_cast<unsigned>(n)); };
        const std::int32_t width = 32 + below(200), depth = 32 + below(200), align = 1 << below(5);
        Shelves shelves(width, depth, align);
        struct Placed {
            std::int32_t pass = 0;
            TexelRect rect;
        };
        std::vector<Placed> placed;
        for (int i = 0; i < 40; ++i) {
            const std::int32_t w = 1 + below(round % 2 == 0 ? 40 : width + 50),
                               d = 1 + below(round % 3 == 0 ? 250 : 40);
            const Shelves::Spot spot = shelves.add(w, d);
            const Placed added{spot.pass, {{spot.x, spot.z}, {spot.x + w, spot.z + d}}};
            EXPECT_EQ(spot.x % align, 0);
            EXPECT_EQ(spot.z % align, 0);
            EXPECT_LE(added.rect.max.x, std::max(width, w));
            EXPECT_LE(added.rect.max.z, std::max(depth, d));
            EXPECT_LE(added.rect.max.x, shelves.width());
            EXPECT_LE(added.rect.max.z, shelves.depth());
            const std::int32_t last = placed.empty() ? 0 : placed.back().pass;
            EXPECT_TRUE(spot.pass == last || spot.pass == last + 1);
            for (const Placed& other : placed)
                EXPECT_TRUE(other.pass != added.pass || intersection(other.rect, added.rect).empty());
            placed.push_back(added);
        }
    }
}

TEST(Shelves, FourQuartersOfATileShareAPass) {
    Shelves shelves(132, 132, 1);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(shelves.add(66, 66).pass, 0);
    EXPECT_EQ(shelves.add(1, 1).pass, 1);
}

}  // namespace
}  // namespace tilth
