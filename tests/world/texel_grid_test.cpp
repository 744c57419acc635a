#include <gtest/gtest.h>

#include <vector>

#include "tilth/world/grid.h"
#include "tilth/world/texel.h"

namespace tilth {
namespace {

/// Every rectangle with corners in -2..3, empty and reversed ones too.
std::vector<TexelRect> small_rects() {
    std::vector<TexelRect> rects;
    for (int a = -2; a <= 3; ++a)
        for (int b = -2; b <= 3; ++b)
            for (int c = -2; c <= 3; ++c)
                for (int d = -2; d <= 3; ++d) rects.push_back({{a, b}, {c, d}});
    return rects;
}

TEST(TexelRect, CountsAndContainsWhatAWalkOverTexelsFinds) {
    for (const TexelRect& rect : small_rects()) {
        std::int64_t found = 0;
        for (int z = -4; z < 6; ++z)
            for (int x = -4; x < 6; ++x) found += rect.contains({x, z}) ? 1 : 0;
        ASSERT_EQ(rect.count(), found);
        ASSERT_EQ(rect.empty(), found == 0);
    }
    EXPECT_EQ((TexelRect{{0, 0}, {1 << 26, 1 << 26}}.count()), std::int64_t{1} << 52);
}

TEST(TexelRect, IntersectionHoldsExactlyTheTexelsOfBothAndBoundsHoldAll) {
    const std::vector<TexelRect> rects = small_rects();
    for (std::size_t i = 0; i < rects.size(); i += 7)
        for (std::size_t j = 0; j < rects.size(); j += 5) {
            const TexelRect &a = rects[i], &b = rects[j], both = intersection(a, b), all = bounds_of(a, b);
            for (int z = -3; z < 5; ++z)
                for (int x = -3; x < 5; ++x) {
                    ASSERT_EQ(both.contains({x, z}), a.contains({x, z}) && b.contains({x, z}));
                    if (a.contains({x, z}) || b.contains({x, z})) {
                        ASSERT_TRUE(all.contains({x, z}));
                    }
                }
            if (!a.empty() && b.empty()) {
                ASSERT_EQ(all, a);
            }
            if (!a.empty() && !b.empty()) {  // smallest: each side is touched by one of them
                ASSERT_TRUE(all.min.x == a.min.x || all.min.x == b.min.x);
                ASSERT_TRUE(all.max.z == a.max.z || all.max.z == b.max.z);
            }
        }
    EXPECT_EQ(expanded({{1, 2}, {3, 5}}, 2), (TexelRect{{-1, 0}, {5, 7}}));
    EXPECT_TRUE(expanded({{1, 2}, {3, 5}}, -1).empty());
}

TEST(GridSpec, PostsAndWorldAreInverse) {
    for (const double origin : {0.0, -100.0, 1e7})
        for (const double spacing : {0.125, 1.0, 0.1, 1.0 / 3}) {
            const GridSpec grid{.origin = {origin, -origin}, .spacing_m = spacing, .width = 1025, .depth = 513};
            for (const Texel t : {Texel{0, 0}, Texel{1, 512}, Texel{1024, 17}}) {
                const WorldPos at = grid.world(t);
                EXPECT_EQ(at.x, origin + spacing * t.x);
                EXPECT_EQ(at.z, -origin + spacing * t.z);
                // Two roundings at the size of the coordinate, seen in posts.
                const double tolerance = (std::abs(origin) + 1024 * spacing) * 0x1p-51 / spacing;
                EXPECT_NEAR(grid.posts(at).x, t.x, tolerance);
                EXPECT_NEAR(grid.posts(at).z, t.z, tolerance);
            }
            EXPECT_EQ(grid.rect(), (TexelRect{{0, 0}, {1025, 513}}));
        }
    const GridSpec grid{.origin = {10, 20}, .spacing_m = 0.5, .width = 4, .depth = 4};
    EXPECT_EQ(grid.posts({10.75, 19.5}).x, 1.5);
    EXPECT_EQ(grid.posts({10.75, 19.5}).z, -1.0);
}

}  // namespace
}  // namespace tilth
