// Which recipe a block takes by its distance, without GL.
#include <gtest/gtest.h>

#include <algorithm>

#include "tilth/render/backends/backend_plan.h"

namespace tilth {
namespace {

double faded(double distance_m, FadeRange range) {
    const double t = std::clamp((range.to_m - distance_m) / (double{range.to_m} - range.from_m), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

bool has(const ReliefRecipe& recipe, const char* feature) {
    return std::any_of(recipe.features.begin(), recipe.features.end(),
                       [&](const auto& entry) { return entry.first == feature; });
}

TEST(HybridPlan, EveryBlockTakesARecipeThatShowsAllThatIsToBeSeenOnIt) {
    for (const double reach_m : {3.0, 17.3, 400.0})
        for (const double tessellated : {0.05, 0.35, 0.9})
            for (const double blend : {0.02, 0.15, 0.5}) {
                DetailSettings settings{.backend = DetailBackend::Hybrid, .tessellated = tessellated, .blend = blend};
                const BackendPlan plan = plan_hybrid({.settings = settings, .reach_m = reach_m, .texels_per_post = 3});
                ASSERT_EQ(plan.recipes.size(), 3u);
                EXPECT_LT(plan.displaced.from_m, plan.displaced.to_m);
                EXPECT_LE(plan.displaced.to_m, plan.all.to_m * 1.000001f) << "the mesh shows what nothing else does";
                for (int i = 0; i <= 400; ++i)
                    for (int j = i; j <= 400; ++j) {
                        const double nearest = reach_m * i / 390, farthest = reach_m * j / 390;
                        const std::size_t chosen = plan.recipe_of(nearest, farthest);
                        ASSERT_LT(chosen, plan.recipes.size());
                        const ReliefRecipe& recipe = plan.recipes[chosen];
                        // Fades fall, so the ends of the block tell whether any of it is displaced or traced.
                        const bool displaced = std::min(faded(nearest, plan.displaced), faded(nearest, plan.all)) > 0;
                        const bool traced = farthest > plan.displaced.from_m && nearest < plan.all.to_m;
                        if (displaced) {
                            ASSERT_TRUE(has(recipe, "RELIEF_MESH")) << nearest << " to " << farthest << " m";
                        }
                        if (traced) {
                            ASSERT_TRUE(has(recipe, "PARALLAX")) << nearest << " to " << farthest << " m";
                        }
                    }
            }
}

TEST(HybridPlan, NearBlocksAreMeshAloneAndTheRingIsParallaxAlone) {
    const DetailSettings settings{.backend = DetailBackend::Hybrid};
    const BackendPlan plan = plan_hybrid({.settings = settings, .reach_m = 100, .texels_per_post = 3});
    const ReliefRecipe& near = plan.recipes[plan.recipe_of(0, 34)];
    const ReliefRecipe& blend = plan.recipes[plan.recipe_of(30, 60)];
    const ReliefRecipe& ring = plan.recipes[plan.recipe_of(51, 120)];
    EXPECT_TRUE(near.patches && near.displaces && !has(near, "PARALLAX"));
    EXPECT_TRUE(blend.patches && blend.displaces && has(blend, "PARALLAX"));
    EXPECT_TRUE(!ring.patches && !ring.displaces && has(ring, "PARALLAX") && !has(ring, "RELIEF_MESH"));
    EXPECT_TRUE(ring.stages.tess_control.empty() && ring.stages.tess_evaluation.empty());
}

TEST(TessellationPlan, OneRecipeServesEveryBlock) {
    const DetailSettings settings{.backend = DetailBackend::Tessellation};
    const BackendPlan plan = plan_tessellation({.settings = settings, .reach_m = 100, .texels_per_post = 3});
    ASSERT_EQ(plan.recipes.size(), 1u);
    EXPECT_EQ(plan.recipe_of(0, 1), 0u);
    EXPECT_EQ(plan.recipe_of(0, 1000), 0u);
    EXPECT_TRUE(plan.recipes[0].patches && plan.recipes[0].displaces && has(plan.recipes[0], "RELIEF_MESH"));
    EXPECT_FLOAT_EQ(plan.displaced.from_m, 75);
    EXPECT_FLOAT_EQ(plan.displaced.to_m, 100);
    EXPECT_EQ(plan.all.to_m, plan.displaced.to_m) << "nothing else shows relief";
}

}  // namespace
}  // namespace tilth
