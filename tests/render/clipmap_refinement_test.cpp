// Refinement changes which vertices are drawn, never what is covered; and it is 0 wherever refined and other ground
// meet.
#include "tilth/render/clipmap_refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tilth/core/shared_glsl.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {
namespace {

const HeightCodec kCodec{0, 1.0 / 64};

/// Flat, with noise in one corner region: some ground wants refinement, some does not.
HeightField partly_rough(std::int32_t width, std::int32_t depth) {
    std::mt19937 random(5);
    HeightField field(width, depth);
    for (std::int32_t z = 0; z < depth / 2; ++z)
        for (std::int32_t x = 0; x < width / 2; ++x)
            field.set_code({x, z}, kMidCode + static_cast<std::uint32_t>(random() % (64u << 16)));
    return field;
}

struct Drawn {
    ClipmapSettings settings{.n = 63, .levels = 4, .blend = 0.1, .refine_above_px = 1};
    ClipmapLayout layout;
    ClipmapRefinement refinement;
    DrawnBlocks blocks;
    Camera camera;
};

Drawn drawn_at(const HeightField& field, const HeightBounds& bounds, double x, double z) {
    Drawn d;
    const GridSpec grid{{0, 0}, 1, field.width(), field.depth()};
    View view;
    view.eye = {x, 2, z};
    view.width = 1600, view.height = 900;
    d.camera = *make_camera(view, grid, kCodec);
    d.layout = clipmap_layout(d.settings, d.camera.eye_posts, field.width() - 1, field.depth() - 1);
    d.refinement = clipmap_refinement(d.settings, d.layout, d.camera, {grid, kCodec, false, bounds});
    d.blocks = drawn_blocks(d.layout, d.refinement, field.width() - 1, field.depth() - 1);
    return d;
}

TEST(ClipmapRefinement, CoversTheSameGroundOnce) {
    const HeightField field = partly_rough(344, 403);
    const HeightBounds bounds(field);
    for (const auto& [x, z] : {std::pair{90.3, 100.7}, {171.0, 200.0}, {343.0, 402.0}, {-20.0, 60.0}}) {
        const Drawn d = drawn_at(field, bounds, x, z);
        std::vector<int> before(343 * 402), after(343 * 402);
        const auto add = [](const ClipmapBlock& b, std::vector<int>& cells) {
            const auto post = [&](std::int32_t v, std::int32_t last) { return std::min(v << b.level, last); };
            for (std::int32_t j = post(b.z, 402); j < post(b.z + b.depth, 402); ++j)
                for (std::int32_t i = post(b.x, 343); i < post(b.x + b.width, 343); ++i)
                    ++cells[static_cast<std::size_t>(j * 343 + i)];
        };
        int refined = 0, plain = 0;
        for (const ClipmapBlock& b : d.layout.blocks) add(b, before);
        for (const DrawnBlock& b : d.blocks.blocks) {
            add(b.block, after);
            (b.base_level == b.block.level ? plain : refined)++;
            ASSERT_TRUE(b.base_level == b.block.level || b.base_level == b.block.level + 1);
            ASSERT_TRUE(b.block.width <= kBlockQuads && b.block.depth <= kBlockQuads);
        }
        EXPECT_EQ(before, after);
        EXPECT_GT(refined, 0) << x;
        EXPECT_GT(plain, 0) << x;
    }
}

// Along every stitch of a refined block, and on every unrefined block of a ring, the refinement shows exactly nothing.
TEST(ClipmapRefinement, IsZeroWhereOtherGroundBegins) {
    const HeightField field = partly_rough(513, 513);
    const HeightBounds bounds(field);
    int stitches = 0, shown = 0;
    for (int step = 0; step < 40; ++step) {
        const Drawn d = drawn_at(field, bounds, 100 + 5.77 * step, 150 + 3.1 * step);
        const auto weight = [&](std::int32_t level, std::int32_t x, std::int32_t z) {
            const double away = std::max(std::abs(x - d.camera.eye_posts.x), std::abs(z - d.camera.eye_posts.z));
            return d.refinement.weight_at(level, x, z) *
                   shared::refinement_fade(static_cast<float>(std::ldexp(away, -level)), d.settings.n, level == 3);
        };
        for (const DrawnBlock& s : d.blocks.stitches) {
            if (s.base_level == s.block.level) continue;
            ++stitches;
            for (std::int32_t i = 0; i <= std::max(s.block.width, s.block.depth); ++i) {
                const std::int32_t x = std::min((s.block.x + std::min(i, s.block.width)) << s.block.level, 512);
                const std::int32_t z = std::min((s.block.z + std::min(i, s.block.depth)) << s.block.level, 512);
                ASSERT_EQ(weight(s.base_level, x, z), 0.0f) << "step " << step << ", post " << x << ", " << z;
            }
        }
        for (const DrawnBlock& b : d.blocks.blocks) {
            if (b.block.level == 0 && b.base_level == 0) continue;
            const std::int32_t x = (b.block.x + b.block.width / 2) << b.block.level;
            const std::int32_t z = (b.block.z + b.block.depth / 2) << b.block.level;
            if (b.base_level == b.block.level) {
                ASSERT_EQ(weight(b.base_level, x, z), 0.0f);
            } else {
                shown += weight(b.base_level, x, z) > 0;
            }
        }
    }
    EXPECT_GT(stitches, 100);
    EXPECT_GT(shown, 100);
}

TEST(ClipmapRefinement, SmoothGroundIsNotRefined) {
    HeightField slope(513, 513);
    for (std::int32_t z = 0; z < 513; ++z)
        for (std::int32_t x = 0; x < 513; ++x)
            slope.set_code({x, z}, kMidCode + static_cast<std::uint32_t>(x + 2 * z) * 65536u);
    const HeightBounds bounds(slope);
    const Drawn d = drawn_at(slope, bounds, 250, 250);
    EXPECT_EQ(d.blocks.blocks.size(), d.layout.blocks.size());
    EXPECT_EQ(d.blocks.stitches.size(), d.layout.stitches.size());
}

// A spike of known height on flat ground: every level whose vertices see it differs by it, elsewhere nothing does.
TEST(HeightBoundsErrors, AreThoseOfTheNextFinerLevel) {
    HeightField field(513, 513);
    field.set_code({129, 200}, kMidCode + 1000);  // odd in x: only a vertex of level 0
    field.set_code({260, 300}, kMidCode + 500);   // a vertex of levels 0, 1 and 2
    HeightBounds bounds(field);
    const auto at = [&](std::int32_t level, std::int32_t x, std::int32_t z) {
        return bounds.level_error(level, {{x, z}, {x + 1, z + 1}});
    };
    EXPECT_EQ(at(1, 129, 200), 1000u);
    EXPECT_EQ(at(2, 129, 200), 0u);
    // Level 1 has the spike as a vertex: its surface is a pyramid there, 250 high at the posts between.
    EXPECT_EQ(at(1, 260, 300), 250u);
    EXPECT_EQ(at(3, 260, 300), 500u) << "level 2 has the vertex, level 3 has not";
    EXPECT_EQ(at(4, 260, 300), 0u);
    EXPECT_EQ(at(1, 400, 400), 0u);
    field.set_code({129, 200}, kMidCode);
    bounds.widen({{129, 200}, {130, 201}}, field);
    EXPECT_EQ(at(1, 129, 200), 1000u) << "errors only grow";
    field.set_code({131, 200}, kMidCode + 3000);
    bounds.widen({{131, 200}, {132, 201}}, field);
    EXPECT_EQ(at(1, 129, 200), 3000u);
    field.set_code({131, 200}, kMidCode);
    bounds.widen({{120, 180}, {200, 300}}, field);
    EXPECT_EQ(at(1, 129, 200), 0u) << "exact again after the whole cell changed";
    bounds.widen_by({{400, 400}, {410, 410}}, kMidCode - 300, kMidCode);
    EXPECT_EQ(at(1, 400, 400), 300u) << "as far as the range grew";
}

}  // namespace
}  // namespace tilth
