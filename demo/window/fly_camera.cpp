#include "demo/window/fly_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tilth::demo {

namespace {

constexpr double kMostPitch = 89 * std::numbers::pi / 180;

Vec3d cross(const Vec3d& a, const Vec3d& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

Vec3d normalised(const Vec3d& v) {
    const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return {v.x / length, v.y / length, v.z / length};
}

FlyCamera turned(FlyCamera camera, const Commands& commands) {
    camera.yaw_rad += commands.yaw_rad;
    camera.pitch_rad = std::clamp(camera.pitch_rad + commands.pitch_rad, -kMostPitch, kMostPitch);
    return camera;
}

}  // namespace

Vec3d FlyCamera::forward() const {
    return {std::sin(yaw_rad) * std::cos(pitch_rad), std::sin(pitch_rad), -std::cos(yaw_rad) * std::cos(pitch_rad)};
}

Vec3d FlyCamera::right() const { return {std::cos(yaw_rad), 0, std::sin(yaw_rad)}; }

FlyCamera FlyCamera::looking(const Vec3d& eye, const Vec3d& forward) {
    const Vec3d f = normalised(forward);
    return {eye, std::atan2(f.x, -f.z), std::clamp(std::asin(std::clamp(f.y, -1.0, 1.0)), -kMostPitch, kMostPitch)};
}

FlyCamera moved(FlyCamera camera, const Commands& commands) {
    camera = turned(camera, commands);
    const Vec3d f = camera.forward(), r = camera.right();
    camera.eye.x += r.x * commands.move.x + f.x * commands.move.z;
    camera.eye.y += commands.move.y + f.y * commands.move.z;
    camera.eye.z += r.z * commands.move.x + f.z * commands.move.z;
    return camera;
}

FlyCamera walked(FlyCamera camera, const Commands& commands) {
    camera = turned(camera, commands);
    const Vec3d r = camera.right();
    camera.eye.x += r.x * commands.move.x + r.z * commands.move.z;  // ahead on the ground is (r.z, -r.x)
    camera.eye.z += r.z * commands.move.x - r.x * commands.move.z;
    return camera;
}

WorldPos far_corner(const GridSpec& grid, WorldPos at) {
    const WorldPos last = grid.world({grid.width - 1, grid.depth - 1});
    const WorldPos middle{(grid.origin.x + last.x) / 2, (grid.origin.z + last.z) / 2};
    return {at.x < middle.x ? last.x : grid.origin.x, at.z < middle.z ? last.z : grid.origin.z};
}

Vec3d ray_through(const View& view, const Vec3d& right, double pixel_x, double pixel_y) {
    const Vec3d f = normalised(view.forward), up = cross(right, f);
    const double half = std::tan(view.fov_y_rad / 2);
    const double x = (2 * pixel_x / view.width - 1) * half * view.width / view.height,
                 y = (1 - 2 * pixel_y / view.height) * half;
    return {f.x + right.x * x + up.x * y, f.y + right.y * x + up.y * y, f.z + right.z * x + up.z * y};
}

}  // namespace tilth::demo
