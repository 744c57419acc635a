#include "demo/window/foot_steps.h"

#include <algorithm>
#include <cmath>

#include "tilth/ground/path.h"

namespace tilth::demo {

BootSize boots_for(double texel_m) {
    BootSize boots;
    const double scale = std::max(1.0, texel_m * 30);
    boots.radius_m *= scale, boots.depth_m *= scale, boots.stride_m *= scale, boots.side_m *= scale;
    return boots;
}

void FootSteps::stop() {
    path_.release();
    from_.reset();
}

std::vector<StampRequest> FootSteps::step(WorldPos at, const BootSize& boots, ShapeId boot) {
    const bool began = !from_.has_value();
    const WorldPos from = from_.value_or(at);
    const double dx = at.x - from.x, dz = at.z - from.z, length_m = std::hypot(dx, dz);
    from_ = at;
    if (began || length_m == 0) return {};
    if (length_m > 16 * boots.stride_m) {  // nobody walks that far in a frame
        path_.release();
        return {};
    }
    std::vector<StampRequest> prints;
    for (const WorldPos& place : path_.drag(at, boots.stride_m)) {
        // A path of one step that begins (left foot) or ends (right foot) at this place; its own rule turns and
        // mirrors.
        const double step_x = dx / length_m * boots.stride_m, step_z = dz / length_m * boots.stride_m;
        const std::size_t foot = right_ ? 1 : 0;
        const WorldPos left = {place.x - step_x * double(foot), place.z - step_z * double(foot)};
        PathRequest path{.stamp = {.shape = boot,
                                   .centre = {},
                                   .radius_m = boots.radius_m,
                                   .amplitude_m = -boots.depth_m,
                                   .map = MapChoice::Detail,
                                   .rule = StampRule::Min,
                                   .level_m = {},
                                   .rotation_rad = 0,
                                   .mirror = true,
                                   .key = {}},
                         .points = {left, {left.x + 1.5 * step_x, left.z + 1.5 * step_z}},
                         .spacing_m = boots.stride_m,
                         .alternate_m = boots.side_m};
        const auto pair = stamps_along(path);
        if (!pair || pair->size() <= foot) continue;
        prints.push_back((*pair)[foot]);
        right_ = !right_;
    }
    return prints;
}

}  // namespace tilth::demo
