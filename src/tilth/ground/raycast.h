// Where a ray meets the ground: on the very triangles that are drawn.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "tilth/core/vec.h"
#include "tilth/ground/ground.h"

namespace tilth {

/// Shrinks [begin, end] to where low <= start + slope t <= high; empty (end < begin) where that is nowhere.
inline void clip_ray(double start, double slope, double low, double high, double& begin, double& end) {
    if (slope == 0) {
        if (start < low || start > high) end = -std::numeric_limits<double>::infinity();
        return;
    }
    const double a = (low - start) / slope, b = (high - start) / slope;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
}

/// Distance along `direction` (normalised inside) from `from` to the first point of the ray on or under the surface
/// coarse + detail, metres; empty if there is none within `max_m` or before the ray leaves the map. 0 when `from` lies
/// under the ground. Exact up to the rounding of doubles: the surface is linear between the grid lines and diagonals
/// that the ray's shadow crosses, so only those places are looked at. Cost: three heights a cell crossed. A direction
/// that is zero or not finite is a miss.
std::optional<double> raycast(const Ground& ground, const Vec3d& from, const Vec3d& direction, double max_m);

}  // namespace tilth
