// Which slopes are stale: none too few, none twice.
#include "tilth/derive/slope_rects.h"

#include <gtest/gtest.h>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

static_assert(mip_texels({{0, 0}, {5, 5}}, 1) == TexelRect{{0, 0}, {3, 3}});
static_assert(mip_texels({{1, 1}, {2, 2}}, 1).empty());
static_assert(stale_slopes({{3, 3}, {4, 4}}, {{0, 0}, {9, 9}}, SlopeStencil::Fourth) == TexelRect{{1, 1}, {6, 6}});
static_assert(stale_slopes({{0, 0}, {4, 4}}, {{0, 0}, {4, 4}}, SlopeStencil::Central) == TexelRect{{0, 0}, {4, 4}});

TEST(SlopeRects, MipTexelsAreThosePostsThatTheLevelHas) {
    SplitMix64 random{4};
    for (int trial = 0; trial < 500; ++trial) {
        const auto at = [&] { return static_cast<std::int32_t>(random.next() % 70); };
        TexelRect posts{{at(), at()}, {at(), at()}};
        const std::int32_t level = static_cast<std::int32_t>(random.next() % 5);
        const TexelRect texels = mip_texels(posts, level);
        for (std::int32_t z = -1; z < 71; ++z)
            for (std::int32_t x = -1; x < 71; ++x)
                EXPECT_EQ(!posts.empty() && posts.contains({x << level, z << level}),
                          !posts.empty() && texels.contains({x, z}));
    }
}

std::vector<TexelRect> random_rects(std::uint64_t seed, std::size_t count) {
    SplitMix64 random{seed};
    std::vector<TexelRect> rects;
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = [&](std::uint64_t span) { return static_cast<std::int32_t>(random.next() % span); };
        const Texel min{at(180), at(180)};
        rects.push_back({min, {min.x + at(60), min.z + at(60)}});
    }
    return rects;
}

TEST(SlopeRects, DisjointCoversTheSameTexelsOnce) {
    for (std::uint64_t seed = 1; seed < 12; ++seed) {
        const std::vector<TexelRect> rects = random_rects(seed, 30);
        std::vector<int> times(240 * 240, 0);
        for (const TexelRect& rect : disjoint(rects))
            for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
                for (std::int32_t x = rect.min.x; x < rect.max.x; ++x) ++times[static_cast<std::size_t>(z * 240 + x)];
        for (std::int32_t z = 0; z < 240; ++z)
            for (std::int32_t x = 0; x < 240; ++x) {
                bool wanted = false;
                for (const TexelRect& rect : rects) wanted = wanted || rect.contains({x, z});
                ASSERT_EQ(times[static_cast<std::size_t>(z * 240 + x)], wanted ? 1 : 0) << x << ", " << z;
            }
    }
}

TEST(SlopeRects, ManyRectanglesAreCoveredWithoutOverlap) {
    const std::vector<TexelRect> rects = random_rects(77, 2000);
    std::vector<int> times(320 * 320, 0);
    for (const TexelRect& rect : disjoint(rects))
        for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
            for (std::int32_t x = rect.min.x; x < rect.max.x; ++x) ++times[static_cast<std::size_t>(z * 320 + x)];
    for (const TexelRect& rect : rects)
        for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
            for (std::int32_t x = rect.min.x; x < rect.max.x; ++x)
                ASSERT_EQ(times[static_cast<std::size_t>(z * 320 + x)], 1);
}

TEST(SlopeRects, ATileDerivesItsInteriorAndOneTexelAroundItAndTheMapsEdge) {
    for (const SlopeStencil stencil : {SlopeStencil::Central, SlopeStencil::Fourth}) {
        const TexelRect map{{0, 0}, {300, 300}}, interior{{128, 0}, {256, 128}};
        const std::int32_t apron = stencil_reach(stencil) + 1;
        const TexelRect held = intersection(expanded(interior, apron), map);
        const TexelRect derived = derivable_slopes(held, map, stencil);
        EXPECT_EQ(derived, intersection(expanded(interior, 1), map));
        for (const TexelRect& changed : random_rects(5, 40)) {  // a stale slope is one whose stencil meets the change
            const TexelRect stale = stale_slopes(changed, held, map, stencil);
            for (std::int32_t z = derived.min.z; z < derived.max.z; ++z)
                for (std::int32_t x = derived.min.x; x < derived.max.x; ++x) {
                    const std::int32_t reach = stencil_reach(stencil);
                    const bool reads = !intersection({{x - reach, z}, {x + reach + 1, z + 1}}, changed).empty() ||
                                       !intersection({{x, z - reach}, {x + 1, z + reach + 1}}, changed).empty();
                    ASSERT_TRUE(!reads || stale.contains({x, z})) << x << ", " << z;
                }
        }
        EXPECT_EQ(derivable_slopes(map, map, stencil), map);
    }
}

}  // namespace
}  // namespace tilth
