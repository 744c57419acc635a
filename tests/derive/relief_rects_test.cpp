// The window that follows the viewer: what came in, where it lies in the texture, which nodes read it. Against every
// texel looked at one by one.
#include "tilth/derive/relief_rects.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

class ReliefRects : public ::testing::Test {
protected:
    std::int32_t between(std::int32_t low, std::int32_t high) {  // both included
        return low + static_cast<std::int32_t>(random_.next() % static_cast<std::uint64_t>(high - low + 1));
    }
    TexelRect rect(std::int32_t low, std::int32_t high, std::int32_t most) {
        const Texel min{between(low, high), between(low, high)};
        return {min, {min.x + between(1, most), min.z + between(1, most)}};
    }
    /// How many of `rects` hold `texel`.
    static int times(const std::vector<TexelRect>& rects, Texel texel) {
        int count = 0;
        for (const TexelRect& rect : rects) count += rect.contains(texel) ? 1 : 0;
        return count;
    }
    SplitMix64 random_{17};
};

/// Modulo by looking for it, so that it shares nothing with a division.
std::int32_t modulo(std::int32_t value, std::int32_t size) {
    while (value < 0) value += size;
    while (value >= size) value -= size;
    return value;
}

TEST_F(ReliefRects, TheSquareStandsOnItsStepAboutTheEye) {
    for (int trial = 0; trial < 2000; ++trial) {
        const std::int32_t size = 256 << between(0, 3), step = 1 << between(0, 6);
        const Texel eye{between(-5000, 5000), between(-5000, 5000)};
        const TexelRect square = relief_square(eye, size, step);
        ASSERT_EQ(square.width(), size);
        ASSERT_EQ(square.depth(), size);
        ASSERT_EQ(modulo(square.min.x, step), 0) << eye.x << " step " << step;
        ASSERT_EQ(modulo(square.min.z, step), 0) << eye.z << " step " << step;
        ASSERT_LE(2 * std::abs(eye.x - square.min.x - size / 2), step) << eye.x;
        ASSERT_LE(2 * std::abs(eye.z - square.min.z - size / 2), step) << eye.z;
    }
}

TEST_F(ReliefRects, WhatCameInIsTheSquareWithoutTheOneBefore) {
    for (int trial = 0; trial < 300; ++trial) {
        const std::int32_t size = 16, reach = trial % 2 == 0 ? 6 : 25;
        const TexelRect before{{-8, -5}, {-8 + size, -5 + size}};
        const Texel by{between(-reach, reach), between(-reach, reach)};
        const TexelRect now{{before.min.x + by.x, before.min.z + by.z}, {before.max.x + by.x, before.max.z + by.z}};
        const std::vector<TexelRect> in = newly_covered(before, now);
        const bool meet = !intersection(before, now).empty();
        ASSERT_LE(in.size(), meet ? 2u : 1u);
        for (std::int32_t z = -50; z < 50; ++z)
            for (std::int32_t x = -50; x < 50; ++x)
                ASSERT_EQ(times(in, {x, z}), now.contains({x, z}) && !before.contains({x, z}) ? 1 : 0)
                    << x << ", " << z << " moved by " << by.x << ", " << by.z;
    }
    EXPECT_TRUE(newly_covered({{3, 4}, {7, 8}}, {{3, 4}, {7, 8}}).empty());
    EXPECT_EQ(newly_covered({}, {{3, 4}, {7, 8}}), (std::vector<TexelRect>{{{3, 4}, {7, 8}}}));
    EXPECT_TRUE(newly_covered({{3, 4}, {7, 8}}, {}).empty());
}

TEST_F(ReliefRects, WrappedPartsCoverTheRectangleOnceEachTexelAtItsModulo) {
    constexpr std::int32_t kSize = 16;
    for (int trial = 0; trial < 500; ++trial) {
        const TexelRect whole = rect(-40, 40, kSize);
        const std::vector<WrappedPart> parts = wrapped_parts(whole, kSize);
        ASSERT_LE(parts.size(), 4u);
        std::vector<TexelRect> covered;
        for (const WrappedPart& part : parts) {
            covered.push_back(part.map);
            ASSERT_FALSE(part.map.empty());
            for (std::int32_t z = part.map.min.z; z < part.map.max.z; ++z)
                for (std::int32_t x = part.map.min.x; x < part.map.max.x; ++x) {
                    ASSERT_EQ(part.at.x + x - part.map.min.x, modulo(x, kSize));
                    ASSERT_EQ(part.at.z + z - part.map.min.z, modulo(z, kSize));
                }
        }
        for (std::int32_t z = -60; z < 60; ++z)
            for (std::int32_t x = -60; x < 60; ++x)
                ASSERT_EQ(times(covered, {x, z}), whole.contains({x, z}) ? 1 : 0) << x << ", " << z;
    }
    EXPECT_TRUE(wrapped_parts({}, kSize).empty());
}

TEST_F(ReliefRects, StaleNodesAreThoseThatReadAChangedTexel) {
    for (int trial = 0; trial < 300; ++trial) {
        const std::int32_t level = between(0, 5), side = 2 << level;
        const TexelRect changed = rect(-100, 100, 40);
        const TexelRect stale = stale_nodes(changed, level);
        for (std::int32_t z = -150 / side - 2; z <= 150 / side + 2; ++z)
            for (std::int32_t x = -150 / side - 2; x <= 150 / side + 2; ++x) {
                // Its texels, those of its far sides included.
                const TexelRect read{{x * side, z * side}, {(x + 1) * side + 1, (z + 1) * side + 1}};
                ASSERT_EQ(stale.contains({x, z}), !intersection(read, changed).empty())
                    << "node " << x << ", " << z << " of level " << level << ", changed " << changed.min.x << ", "
                    << changed.min.z << " to " << changed.max.x << ", " << changed.max.z;
            }
    }
    EXPECT_TRUE(stale_nodes({{5, 5}, {5, 9}}, 0).empty());
}

TEST_F(ReliefRects, WrappedRectanglesAreTheTexelsOfTheTextureOnce) {
    constexpr std::int32_t kSize = 8;
    for (int trial = 0; trial < 500; ++trial) {
        std::vector<TexelRect> rects;
        for (std::int32_t i = between(0, 5); i >= 0; --i) rects.push_back(rect(-20, 20, 11));  // some are too large
        std::vector<int> expected(kSize * kSize);
        for (const TexelRect& one : rects)
            for (std::int32_t z = one.min.z; z < one.max.z; ++z)
                for (std::int32_t x = one.min.x; x < one.max.x; ++x)
                    expected[static_cast<std::size_t>(modulo(z, kSize) * kSize + modulo(x, kSize))] = 1;
        const std::vector<TexelRect> wrapped = wrapped_rects(rects, kSize);
        for (const TexelRect& one : wrapped) ASSERT_EQ(intersection(one, {{0, 0}, {kSize, kSize}}), one);
        for (std::int32_t z = 0; z < kSize; ++z)
            for (std::int32_t x = 0; x < kSize; ++x)
                ASSERT_EQ(times(wrapped, {x, z}), expected[static_cast<std::size_t>(z * kSize + x)]) << x << ", " << z;
    }
}

TEST_F(ReliefRects, TakenAndRestAreTheWhole) {
    for (int trial = 0; trial < 500; ++trial) {
        const TexelRect whole = rect(-20, 20, 30);
        std::vector<TexelRect> rest{whole};
        std::vector<TexelRect> from;
        std::vector<std::vector<TexelRect>> parts;
        for (int i = 0; i < 4; ++i) {
            from.push_back(rect(-30, 30, 25));
            parts.push_back(taken(rest, from.back()));
        }
        for (std::int32_t z = -25; z < 55; ++z)
            for (std::int32_t x = -25; x < 55; ++x) {
                bool free = whole.contains({x, z});  // the first that holds it takes it
                for (std::size_t i = 0; i < from.size(); ++i) {
                    const bool takes = free && from[i].contains({x, z});
                    ASSERT_EQ(times(parts[i], {x, z}), takes ? 1 : 0) << x << ", " << z << " by " << i;
                    free = free && !takes;
                }
                ASSERT_EQ(times(rest, {x, z}), free ? 1 : 0) << x << ", " << z;
            }
    }
}

}  // namespace
}  // namespace tilth
