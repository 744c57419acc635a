// A camera that flies: position, yaw and pitch. Pure.
#pragma once

#include "demo/window/commands.h"
#include "tilth/render/view.h"

namespace tilth::demo {

struct FlyCamera {
    Vec3d eye;
    double yaw_rad = 0;    ///< 0 looks along -z, turning right is positive
    double pitch_rad = 0;  ///< up is positive, within +-89 degrees

    [[nodiscard]] Vec3d forward() const;
    [[nodiscard]] Vec3d right() const;
    static FlyCamera looking(const Vec3d& eye, const Vec3d& forward);
};

/// Moved and turned by one frame's commands. Up and down are the world's.
FlyCamera moved(FlyCamera camera, const Commands& commands);

/// The same on foot: the eye keeps its height, and looking down slows nobody.
FlyCamera walked(FlyCamera camera, const Commands& commands);

/// The corner of a map that is farthest from `at`.
WorldPos far_corner(const GridSpec& grid, WorldPos at);

/// Direction of the ray through a pixel of the view, not normalised. (0, 0) is the picture's top left corner.
Vec3d ray_through(const View& view, const Vec3d& right, double pixel_x, double pixel_y);

}  // namespace tilth::demo
