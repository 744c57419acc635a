// Backend "geometry": a geometry shader splits triangles where there is detail under them.
#include <algorithm>
#include <string>

#include "tilth/core/checks.h"
#include "tilth/core/result.h"
#include "tilth/render/backends/backend_plan.h"
#include "tilth/render/backends/refinement_chain.h"

namespace tilth {

std::vector<std::int32_t> refinement_chain(std::int32_t texels_per_post, std::int32_t most_factor) {
    TILTH_EXPECTS(texels_per_post >= 1 && most_factor >= 1,
                  text("refinement_chain: ", texels_per_post, " texels a post, factor ", most_factor));
    const std::int32_t wanted = std::min({most_factor, kMostGeometryFactor, texels_per_post});
    std::int32_t last = wanted;
    while (texels_per_post % last != 0) --last;
    std::vector<std::int32_t> chain{1};
    if (2 * last <= wanted) {  // no divisor that is worth it: between texels
        while (2 * chain.back() <= wanted) chain.push_back(2 * chain.back());
        return chain;
    }
    while (chain.back() < last) {
        std::int32_t step = 2;
        while (last / chain.back() % step != 0) ++step;
        chain.push_back(chain.back() * step);
    }
    return chain;
}

std::array<std::int32_t, 4> refinement_uniform(std::span<const std::int32_t> chain) {
    std::array<std::int32_t, 4> four{};
    for (std::size_t i = 0; i < four.size(); ++i) four[i] = chain[std::min(i, chain.size() - 1)];
    return four;
}

BackendPlan plan_geometry(const PlanInput& input) {
    const std::int32_t finest = refinement_chain(input.texels_per_post, input.settings.refinement.most_factor).back();
    ReliefRecipe recipe;
    recipe.name = "geometry";
    recipe.features = {{"RELIEF_MESH", "1"},
                       {"MAX_FACTOR", std::to_string(finest)},
                       {"MAX_VERTICES", std::to_string(finest * (finest + 2))}};
    if (input.texels_per_post % finest != 0) recipe.features.emplace_back("BETWEEN_TEXELS", "1");
    recipe.stages.geometry = "render/geometry/refine.geom";
    recipe.displaces = true;
    BackendPlan plan;
    plan.recipes = {std::move(recipe)};
    plan.all = {static_cast<float>(0.75 * input.reach_m), static_cast<float>(input.reach_m)};
    plan.displaced = plan.all;
    return plan;
}

}  // namespace tilth
