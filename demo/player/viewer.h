// Where the viewer stands and looks, and what a frame is seen with.
#pragma once

#include "demo/scenario/scenario.h"
#include "tilth/render/view.h"

namespace tilth::demo {

struct Viewer {
    Vec3d eye;
    Vec3d forward{0, -0.35, -1};
};

/// Over the map's centre, 10 m above the ground: where a scenario starts.
Viewer viewer_at_centre(const Ground& ground);

/// The viewer's frame at a picture size. The near plane follows the height above the ground: `above_ground_m` / 20
/// within 0.05 to 5 m, so that pictures from the air keep their depth precision.
View view_of(const Viewer& viewer, const ViewPart& part, double above_ground_m);

/// Light, fog and tint of a scenario. `low_m` and `high_m`: the range of the original heights.
Shading shading_of(const ViewPart& part, double low_m, double high_m);

}  // namespace tilth::demo
