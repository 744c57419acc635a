// Tessellated close to the eye, parallax in a ring about that, slopes alone beyond: triangles where silhouettes and
// grazing views tell, pixels where triangles would be smaller than they.
//
//   0          inner       outer                  3/4 reach      reach
//   | mesh ------|--\ /------|-----------------------|--\            |
//   | parallax   |__/ \______|_______________________|___\___________|
#include <algorithm>

#include "tilth/render/backends/backend_plan.h"

namespace tilth {
namespace {

enum Recipe : std::size_t { kMesh, kBlend, kTraced };

ReliefRecipe mesh_recipe(const char* name) {
    ReliefRecipe recipe;
    recipe.name = name;
    recipe.features.emplace_back("RELIEF_MESH", "1");
    recipe.stages.tess_control = "render/tessellation/relief.tesc";
    recipe.stages.tess_evaluation = "render/tessellation/relief.tese";
    recipe.patches = true;
    recipe.displaces = true;
    return recipe;
}

}  // namespace

BackendPlan plan_hybrid(const PlanInput& input) {
    const gl::Features parallax = parallax_features(input);
    ReliefRecipe blend = mesh_recipe("tessellated and traced relief");
    // What is traced may lie before the mesh: its depth is on either side.
    for (const auto& feature : parallax)
        if (feature.first != "DEPTH_ONE_SIDED") blend.features.push_back(feature);
    ReliefRecipe traced;
    traced.name = "traced relief";
    traced.features = parallax;

    BackendPlan plan;
    plan.recipes = {mesh_recipe("tessellated relief"), blend, traced};
    // The blend ends at reach at the latest; what reach fades in its last quarter, both fade.
    const double outer = std::min(input.settings.tessellated + input.settings.blend, 1.0) * input.reach_m;
    const double inner = std::min(input.settings.tessellated * input.reach_m, outer);
    plan.displaced = {static_cast<float>(inner), static_cast<float>(outer)};
    plan.all = {static_cast<float>(0.75 * input.reach_m), static_cast<float>(input.reach_m)};
    // Shaders measure in floats: a block takes a recipe that leaves something out only if no rounding brings it back.
    constexpr double kSlack = 1e-4;
    plan.zones = {{0, inner * (1 - kSlack), kMesh}, {outer * (1 + kSlack), 2 * input.reach_m, kTraced}};
    plan.mixed = kBlend;
    return plan;
}

}  // namespace tilth
