// Parallax: the mesh stays that of the coarse ground, and each pixel follows its ray into the relief.
#include "tilth/render/backends/backend_plan.h"

namespace tilth {
namespace {

const char* feature_of(ParallaxMethod method) {
    switch (method) {
        case ParallaxMethod::Iterative:
            return "PARALLAX_ITERATIVE";
        case ParallaxMethod::Secant:
            return "PARALLAX_SECANT";
        case ParallaxMethod::Exact:
            return "PARALLAX_EXACT";
    }
    return "PARALLAX_EXACT";
}

}  // namespace

gl::Features parallax_features(const PlanInput& input) {
    const ParallaxSettings& parallax = input.settings.parallax;
    gl::Features features{{"PARALLAX", "1"}, {feature_of(parallax.method), "1"}};
    if (parallax.range) features.emplace_back("PARALLAX_RANGE", "1");
    if (parallax.shadow_steps > 0) features.emplace_back("PARALLAX_SHADOWS", "1");
    if (parallax.depth) {
        features.emplace_back("PARALLAX_DEPTH", "1");
        if (input.reversed_depth) features.emplace_back("REVERSED_DEPTH", "1");
        // Nothing above the ground: what is seen lies behind it, and GL may be told so.
        if (parallax.range && parallax.range->highest_m <= 0) features.emplace_back("DEPTH_ONE_SIDED", "1");
    }
    return features;
}

BackendPlan plan_parallax(const PlanInput& input) {
    BackendPlan plan;
    ReliefRecipe& recipe = plan.recipes.emplace_back();
    recipe.name = "parallax";
    recipe.features = parallax_features(input);
    plan.zones.push_back({.from_m = 0, .to_m = input.reach_m, .recipe = 0});
    plan.displaced = {-2, -1};  // gone before the eye
    const auto reach_m = static_cast<float>(input.reach_m);
    plan.all = {0.75f * reach_m, reach_m};
    return plan;
}

}  // namespace tilth
