#include "demo/player/viewer.h"

#include <algorithm>
#include <numbers>

namespace tilth::demo {

Viewer viewer_at_centre(const Ground& ground) {
    const GridSpec& grid = ground.map(MapKind::Coarse).grid;
    const WorldPos at{grid.origin.x + grid.spacing_m * (grid.width - 1) / 2,
                      grid.origin.z + grid.spacing_m * (grid.depth - 1) / 2};
    return {.eye = {at.x, ground.height_m(at) + 10, at.z}};
}

View view_of(const Viewer& viewer, const ViewPart& part, double above_ground_m) {
    View view{.eye = viewer.eye, .forward = viewer.forward};
    view.fov_y_rad = part.fov_degrees * std::numbers::pi / 180;
    view.width = part.width, view.height = part.height;
    view.near_m = std::clamp(above_ground_m / 20, 0.05, 5.0);
    view.far_m = 50'000;
    return view;
}

Shading shading_of(const ViewPart& part, double low_m, double high_m) {
    Shading shading;
    shading.fog_colour = part.clear;
    shading.fog_density = part.fog_per_m;
    if (part.to_light) shading.to_light = {float(part.to_light->x), float(part.to_light->y), float(part.to_light->z)};
    if (part.ambient) shading.ambient = float(*part.ambient);
    if (part.diffuse) shading.diffuse = float(*part.diffuse);
    shading.tint_low_m = part.tint_m ? (*part.tint_m)[0] : low_m;
    shading.tint_high_m = part.tint_m ? (*part.tint_m)[1] : high_m;
    return shading;
}

}  // namespace tilth::demo
