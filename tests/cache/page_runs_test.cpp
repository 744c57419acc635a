#include "tilth/cache/page_runs.h"

#include <gtest/gtest.h>

#include <random>

namespace tilth {
namespace {

std::set<PageIndex> random_pages(std::mt19937& random) {
    std::set<PageIndex> pages;
    const int count = std::uniform_int_distribution(1, 60)(random);
    std::uniform_int_distribution place(-4, 6);
    for (int i = 0; i < count; ++i) pages.insert({place(random), place(random)});
    return pages;
}

// Every texel of every page of the set that lies in the clip is in exactly one rectangle, and no other texel is.
TEST(PageRuns, RectanglesCoverThePagesOnce) {
    std::mt19937 random(1);
    const TexelRect clip{{-130, -70}, {300, 333}};
    for (int run = 0; run < 200; ++run) {
        const std::set<PageIndex> pages = random_pages(random);
        const std::vector<TexelRect> rects = rects_of(pages, clip);
        std::int64_t covered = 0, wanted = 0;
        for (const PageIndex page : pages) wanted += intersection(texels_of(page), clip).count();
        for (const TexelRect& rect : rects) {
            covered += rect.count();
            const PageRect of = pages_of(rect);
            for (std::int32_t x = of.min.x; x < of.max.x; ++x)
                for (std::int32_t z = of.min.z; z < of.max.z; ++z) EXPECT_TRUE(pages.contains({x, z}));
            for (const TexelRect& other : rects) EXPECT_TRUE(&other == &rect || intersection(rect, other).empty());
            EXPECT_EQ(intersection(rect, clip), rect);
        }
        EXPECT_EQ(covered, wanted);
    }
}

TEST(PageRuns, ABlockOfPagesIsOneRectangle) {
    std::set<PageIndex> pages;
    add_pages(pages, {{64, 0}, {257, 190}});
    EXPECT_EQ(pages.size(), 4u * 3u);
    const std::vector<TexelRect> rects = rects_of(pages, {{-1000, -1000}, {1000, 1000}});
    ASSERT_EQ(rects.size(), 1u);
    EXPECT_EQ(rects.front(), (TexelRect{{64, 0}, {320, 192}}));
}

TEST(PageRuns, TakenRunsEmptyTheSet) {
    std::mt19937 random(2);
    const TexelRect clip{{-1000, -1000}, {1000, 1000}};
    for (int run = 0; run < 200; ++run) {
        std::set<PageIndex> pages = random_pages(random);
        const auto count = static_cast<std::int64_t>(pages.size());
        std::int64_t texels = 0;
        while (!pages.empty()) {
            const TexelRect rect = take_run(pages, 3, clip);
            EXPECT_LE(rect.count(), 3 * kPageTexels * kPageTexels);
            texels += rect.count();
        }
        EXPECT_EQ(texels, count * kPageTexels * kPageTexels);
    }
    std::set<PageIndex> outside{{100, 100}};
    EXPECT_TRUE(take_run(outside, 3, clip).empty());
    EXPECT_TRUE(outside.empty());
}

}  // namespace
}  // namespace tilth
