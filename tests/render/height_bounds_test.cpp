// Bounds hold every code of the rectangle asked for, whatever happened before, and are exact where they can be.
#include "tilth/render/height_bounds.h"

#include <gtest/gtest.h>

#include <random>

#include "tilth/source/mirrored_source.h"

namespace tilth {
namespace {

HeightField random_field(std::int32_t width, std::int32_t depth, std::mt19937& random) {
    HeightField field(width, depth);
    for (std::uint32_t& code : field.codes()) code = static_cast<std::uint32_t>(random());
    return field;
}

CodeRange truth(const HeightField& field, const TexelRect& rect) {
    CodeRange range;
    for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
        for (std::int32_t x = rect.min.x; x < rect.max.x; ++x) {
            range.min = std::min(range.min, field.code({x, z}));
            range.max = std::max(range.max, field.code({x, z}));
        }
    return range;
}

TexelRect random_rect(std::int32_t width, std::int32_t depth, std::mt19937& random) {
    const auto pick = [&](std::int32_t n) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(n)); };
    const std::int32_t x = pick(width), z = pick(depth);
    return {{x, z}, {x + 1 + pick(width - x), z + 1 + pick(depth - z)}};
}

TEST(HeightBounds, HoldEveryCodeAfterAnyEdits) {
    std::mt19937 random(1);
    for (const auto& [width, depth] : {std::pair{344, 403}, {64, 64}, {65, 2}, {700, 130}}) {
        HeightField field = random_field(width, depth, random);
        HeightBounds bounds(field);
        for (int edit = 0; edit < 60; ++edit) {
            const TexelRect changed = random_rect(width, depth, random);
            const std::uint32_t base = static_cast<std::uint32_t>(random());
            for (std::int32_t z = changed.min.z; z < changed.max.z; ++z)
                for (std::int32_t x = changed.min.x; x < changed.max.x; ++x)
                    field.set_code({x, z}, base ^ (random() & 255u));
            if (edit % 2 == 0) {
                bounds.widen(changed, field);
            } else {
                const CodeRange range = truth(field, changed);
                bounds.widen_by(changed, range.min, range.max);
            }
            for (int asked = 0; asked < 20; ++asked) {
                const TexelRect rect = random_rect(width, depth, random);
                const CodeRange real = truth(field, rect), found = bounds.query(rect);
                ASSERT_TRUE(found.min <= real.min && found.max >= real.max);
            }
        }
        bounds.widen(field.rect(), field);
        EXPECT_EQ(bounds.query(field.rect()), truth(field, field.rect())) << "exact again after a full recompute";
    }
}

TEST(HeightBounds, WholeBlocksAreExact) {
    std::mt19937 random(2);
    const HeightField field = random_field(512, 256, random);
    const HeightBounds bounds(field);
    for (std::int32_t z = 0; z < 4; ++z)
        for (std::int32_t x = 0; x < 8; ++x) {
            const TexelRect block{{x * 64, z * 64}, {x * 64 + 64, z * 64 + 64}};
            EXPECT_EQ(bounds.query(block), truth(field, block));
            EXPECT_EQ(bounds.query(expanded(block, -20)), truth(field, block)) << "a part is answered by its block";
        }
    EXPECT_EQ(bounds.query({{-50, -50}, {5, 5}}), truth(field, {{0, 0}, {64, 64}})) << "clipped to the map";
}

TEST(HeightBounds, FoldedRangesAreThoseOfTheReflection) {
    for (const std::int32_t n : {2, 3, 5, 8}) {
        for (std::int32_t min = -30; min < 30; ++min) {
            PostRange real{mirrored_index(min, n), mirrored_index(min, n)};
            for (std::int32_t max = min; max < min + 40; ++max) {
                real = {std::min(real.min, mirrored_index(max, n)), std::max(real.max, mirrored_index(max, n))};
                ASSERT_EQ(folded_range(min, max, n), real) << n << ": " << min << ".." << max;
            }
        }
    }
}

}  // namespace
}  // namespace tilth
