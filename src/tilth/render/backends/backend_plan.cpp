#include "tilth/render/backends/backend_plan.h"

namespace tilth {

std::size_t BackendPlan::recipe_of(double nearest_m, double farthest_m) const {
    for (const Zone& zone : zones)
        if (nearest_m >= zone.from_m && farthest_m <= zone.to_m) return zone.recipe;
    return mixed;
}

BackendPlan plan_backend(const PlanInput& input) {
    switch (input.settings.backend) {
        case DetailBackend::None:
            break;
        case DetailBackend::Parallax:
            return plan_parallax(input);
        case DetailBackend::Geometry:
            return plan_geometry(input);
        case DetailBackend::Tessellation:
            return plan_tessellation(input);
        case DetailBackend::Hybrid:
            return plan_hybrid(input);
    }
    return {};
}

}  // namespace tilth
