// A walk as numbers: where the viewer is in each frame, and which footprints have been made by then. No GL.
#pragma once

#include <cstdint>
#include <vector>

#include "demo/scenario/scenario.h"

namespace tilth::demo {

/// A straight walk at a constant speed. Frame f (from 1) ends at `position(f)`; the last one exactly at its goal.
struct WalkPlan {
    WorldPos from, to;
    double length_m = 0;
    double step_m = 0;        ///< each frame
    std::int64_t frames = 0;  ///< 0: the viewer is there already

    [[nodiscard]] double distance_m(std::int64_t frame) const;
    [[nodiscard]] WorldPos position(std::int64_t frame) const;
};

WalkPlan plan_walk(WorldPos from, const WalkStep& walk);

/// How many prints lie within `distance_m` of the start: one at the start, then one every `stride_m`.
std::size_t prints_until(double distance_m, double stride_m);

/// Frames of a `wait` by its list of time steps: how many, and the step of each.
struct WaitPlan {
    std::int64_t frames = 0;
    std::vector<double> dt_s;
    [[nodiscard]] double dt(std::int64_t frame) const { return dt_s[static_cast<std::size_t>(frame) % dt_s.size()]; }
};

/// With `seconds`, as many frames as it takes until the steps add up to it.
WaitPlan plan_wait(const WaitStep& wait);

}  // namespace tilth::demo
