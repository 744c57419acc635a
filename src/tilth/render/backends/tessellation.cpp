// Relief by the tessellator: triangles with detail under them are split to the size of a few pixels.
#include "tilth/render/backends/backend_plan.h"

namespace tilth {

BackendPlan plan_tessellation(const PlanInput& input) {
    BackendPlan plan;
    ReliefRecipe recipe;
    recipe.name = "tessellated relief";
    recipe.features.emplace_back("RELIEF_MESH", "1");
    recipe.stages.tess_control = "render/tessellation/relief.tesc";
    recipe.stages.tess_evaluation = "render/tessellation/relief.tese";
    recipe.patches = true;
    recipe.displaces = true;
    plan.recipes.push_back(recipe);
    plan.displaced = {static_cast<float>(0.75 * input.reach_m), static_cast<float>(input.reach_m)};
    plan.all = plan.displaced;
    return plan;
}

}  // namespace tilth
