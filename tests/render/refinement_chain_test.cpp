// The factors that the geometry shader splits by, and the plan made from them.
#include "tilth/render/backends/refinement_chain.h"

#include <gtest/gtest.h>

#include "tilth/render/backends/backend_plan.h"

namespace tilth {
namespace {

using Chain = std::vector<std::int32_t>;

TEST(RefinementChain, SmallestStepsToTheLargestDivisor) {
    EXPECT_EQ(refinement_chain(1, 16), (Chain{1}));
    EXPECT_EQ(refinement_chain(2, 16), (Chain{1, 2}));
    EXPECT_EQ(refinement_chain(3, 16), (Chain{1, 3}));
    EXPECT_EQ(refinement_chain(4, 16), (Chain{1, 2, 4}));
    EXPECT_EQ(refinement_chain(5, 16), (Chain{1, 5}));
    EXPECT_EQ(refinement_chain(6, 16), (Chain{1, 2, 6}));
    EXPECT_EQ(refinement_chain(8, 16), (Chain{1, 2, 4, 8}));
    EXPECT_EQ(refinement_chain(11, 16), (Chain{1, 2, 4, 8}));
    EXPECT_EQ(refinement_chain(12, 16), (Chain{1, 2, 6}));
    EXPECT_EQ(refinement_chain(16, 16), (Chain{1, 2, 4, 8}));
    EXPECT_EQ(refinement_chain(16, 4), (Chain{1, 2, 4}));
    EXPECT_EQ(refinement_chain(6, 4), (Chain{1, 3}));
    EXPECT_EQ(refinement_chain(3, 2), (Chain{1, 2}));
    EXPECT_EQ(refinement_chain(9, 16), (Chain{1, 2, 4, 8}));
    EXPECT_EQ(refinement_chain(22, 5), (Chain{1, 2, 4}));
}

// For every map and every setting: from 1, each divides the next; the last divides the texels and is as large as may
// be, or no divisor is more than half of that and it is the largest power of two.
TEST(RefinementChain, IsNestedAndEndsAsHighAsItMay) {
    for (std::int32_t texels = 1; texels <= 64; ++texels) {
        for (std::int32_t most = 1; most <= 64; ++most) {
            const Chain chain = refinement_chain(texels, most);
            ASSERT_FALSE(chain.empty());
            EXPECT_EQ(chain.front(), 1);
            EXPECT_LE(chain.size(), 4u);
            for (std::size_t i = 1; i < chain.size(); ++i) {
                EXPECT_GT(chain[i], chain[i - 1]);
                EXPECT_EQ(chain[i] % chain[i - 1], 0);
            }
            const std::int32_t wanted = std::min({most, kMostGeometryFactor, texels});
            EXPECT_LE(chain.back(), wanted);
            EXPECT_GT(2 * chain.back(), wanted) << texels << ", " << most;
            if (texels % chain.back() == 0) {
                for (std::int32_t larger = chain.back() + 1; larger <= wanted; ++larger)
                    EXPECT_NE(texels % larger, 0) << larger << " divides " << texels;
            } else {
                for (std::int32_t divisor = wanted / 2 + 1; divisor <= wanted; ++divisor)
                    EXPECT_NE(texels % divisor, 0) << divisor << " divides " << texels;
            }
        }
    }
}

TEST(RefinementChain, UniformRepeatsTheLast) {
    EXPECT_EQ(refinement_uniform(Chain{1}), (std::array<std::int32_t, 4>{1, 1, 1, 1}));
    EXPECT_EQ(refinement_uniform(Chain{1, 3}), (std::array<std::int32_t, 4>{1, 3, 3, 3}));
    EXPECT_EQ(refinement_uniform(Chain{1, 2, 4, 8}), (std::array<std::int32_t, 4>{1, 2, 4, 8}));
}

// A geometry shader declares no more vertices than its map can ask for, and never more than GL allows.
TEST(GeometryPlan, DeclaresWhatTheMapNeeds) {
    const struct {
        std::int32_t texels_per_post;
        const char *factor, *vertices;
    } cases[] = {{1, "1", "3"}, {3, "3", "15"}, {4, "4", "24"}, {9, "8", "80"}, {16, "8", "80"}};
    const DetailSettings settings{.backend = DetailBackend::Geometry};
    for (const auto& c : cases) {
        const BackendPlan plan =
            plan_geometry({.settings = settings, .reach_m = 40, .texels_per_post = c.texels_per_post});
        ASSERT_EQ(plan.recipes.size(), 1u);
        gl::Features expected{{"RELIEF_MESH", "1"}, {"MAX_FACTOR", c.factor}, {"MAX_VERTICES", c.vertices}};
        if (c.texels_per_post == 9) expected.emplace_back("BETWEEN_TEXELS", "1");
        EXPECT_EQ(plan.recipes[0].features, expected) << c.texels_per_post;
        EXPECT_EQ(plan.recipes[0].stages.geometry, "render/geometry/refine.geom");
        EXPECT_TRUE(plan.recipes[0].displaces);
        EXPECT_EQ(plan.recipe_of(0, 1e6), 0u);
        EXPECT_FLOAT_EQ(plan.displaced.from_m, 30);
        EXPECT_FLOAT_EQ(plan.displaced.to_m, 40);
        EXPECT_EQ(plan.all.from_m, plan.displaced.from_m);
        EXPECT_EQ(plan.all.to_m, plan.displaced.to_m);
    }
    // Components of a vertex: clip 4, position 3, alpha, level.
    static_assert(kMostGeometryFactor * (kMostGeometryFactor + 2) * 9 <= 1024);
}

}  // namespace
}  // namespace tilth
