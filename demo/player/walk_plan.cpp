#include "demo/player/walk_plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tilth::demo {

namespace {
/// Steps of 0.016667 s must add up to 1 s after 60 frames although their sum is rounded; a share of one step.
constexpr double kStepSlack = 1e-6;
}  // namespace

double WalkPlan::distance_m(std::int64_t frame) const { return frame >= frames ? length_m : step_m * double(frame); }

WorldPos WalkPlan::position(std::int64_t frame) const {
    if (frame >= frames) return to;
    const double share = distance_m(frame) / length_m;
    return {from.x + (to.x - from.x) * share, from.z + (to.z - from.z) * share};
}

WalkPlan plan_walk(WorldPos from, const WalkStep& walk) {
    WalkPlan plan{.from = from, .to = walk.to, .length_m = std::hypot(walk.to.x - from.x, walk.to.z - from.z)};
    plan.step_m = walk.speed_m_per_s * walk.dt_s;
    plan.frames = static_cast<std::int64_t>(std::min(1e15, std::ceil(plan.length_m / plan.step_m - kStepSlack)));
    if (plan.length_m > 0) plan.frames = std::max<std::int64_t>(plan.frames, 1);
    return plan;
}

std::size_t prints_until(double distance_m, double stride_m) {
    return static_cast<std::size_t>(std::floor(distance_m / stride_m + 1e-9)) + 1;
}

WaitPlan plan_wait(const WaitStep& wait) {
    WaitPlan plan{wait.frames, wait.dt_s};
    if (!wait.seconds) return plan;
    const double cycle_s = std::accumulate(wait.dt_s.begin(), wait.dt_s.end(), 0.0);
    if (!(cycle_s > 0)) return plan;  // refused by the reader, unless no time is asked for
    const double cycles = std::max(0.0, std::floor(*wait.seconds / cycle_s - kStepSlack));
    plan.frames = static_cast<std::int64_t>(cycles) * static_cast<std::int64_t>(wait.dt_s.size());
    for (double passed_s = cycles * cycle_s;;) {
        const double dt_s = plan.dt(plan.frames);
        if (passed_s >= *wait.seconds - kStepSlack * std::max(dt_s, cycle_s / double(wait.dt_s.size()))) break;
        passed_s += dt_s;
        ++plan.frames;
    }
    return plan;
}

}  // namespace tilth::demo
