#include "tilth/render/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace tilth {
namespace {

constexpr double kSnap = 1048576.0;  // 1 / 2^-20 m

glm::dvec3 to_glm(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3d from_glm(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
bool finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
double snapped(double metres) { return std::floor(metres * kSnap + 0.5) / kSnap; }

Error refused(const char* field, double value, const char* allowed) {
    return {ErrorCode::InvalidArgument, text("view.", field, " is ", value, "; allowed is ", allowed)};
}

Result<void> check(const View& view) {
    if (!finite(view.eye)) return Error{ErrorCode::InvalidArgument, "view.eye is not finite"};
    if (!finite(view.forward)) return Error{ErrorCode::InvalidArgument, "view.forward is not finite"};
    if (!finite(view.up)) return Error{ErrorCode::InvalidArgument, "view.up is not finite"};
    if (view.forward == Vec3d{}) return Error{ErrorCode::InvalidArgument, "view.forward is zero; give it a direction"};
    if (!std::isfinite(view.fov_y_rad)) return refused("fov_y_rad", view.fov_y_rad, "a finite angle in radians");
    if (view.width < 0) return refused("width", view.width, "0 (draws nothing) or more pixels");
    if (view.height < 0) return refused("height", view.height, "0 (draws nothing) or more pixels");
    if (!std::isfinite(view.near_m) || view.near_m <= 0) return refused("near_m", view.near_m, "above 0 and finite");
    if (!(view.far_m > view.near_m)) return refused("far_m", view.far_m, "more than near_m; infinity is");
    return {};
}

/// Unit vector however long or short the input (a host may pass 1e-200 or 1e200).
glm::dvec3 direction(const Vec3d& v) {
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return glm::normalize(to_glm(v) / largest);
}

/// A direction for "up" that is not parallel to `forward`: the wish, else -z (a map seen from above has north on top),
/// else x.
glm::dvec3 right_of(const glm::dvec3& forward, const Vec3d& wish) {
    const glm::dvec3 candidates[] = {wish == Vec3d{} ? glm::dvec3(0, 1, 0) : direction(wish), {0, 0, -1}, {1, 0, 0}};
    for (const glm::dvec3& up : candidates) {
        const glm::dvec3 right = glm::cross(forward, up);
        if (glm::length(right) > 1e-6) return glm::normalize(right);
    }
    return {1, 0, 0};  // not reached: -z and x are not parallel
}

/// Clip depth of standard views is -1..1, of reversed ones 1 (near) to 0 (far).
glm::dmat4 projection(const View& view, double tangent) {
    const double n = view.near_m, f = view.far_m;
    const bool infinite = std::isinf(f);
    glm::dmat4 m(0.0);
    m[0][0] = 1.0 / (tangent * view.width / view.height);
    m[1][1] = 1.0 / tangent;
    m[2][3] = -1;
    if (view.depth == DepthConvention::Reversed) {
        m[2][2] = infinite ? 0 : n / (f - n);
        m[3][2] = infinite ? n : n * f / (f - n);
    } else {
        m[2][2] = infinite ? -1 : -(f + n) / (f - n);
        m[3][2] = infinite ? -2 * n : -2 * n * f / (f - n);
    }
    return m;
}

}  // namespace

Result<Camera> make_camera(const View& view, const GridSpec& grid, const HeightCodec& codec) {
    if (Result<void> checked = check(view); !checked) return checked.error();
    Camera camera;
    if (view.width == 0 || view.height == 0) return camera;

    camera.eye_x_m = snapped(view.eye.x - grid.origin.x);
    camera.eye_z_m = snapped(view.eye.z - grid.origin.z);
    camera.eye_y_m = snapped(view.eye.y - codec.middle_m);
    camera.eye_posts = {camera.eye_x_m / grid.spacing_m, camera.eye_z_m / grid.spacing_m};
    // No clipmap of 16 levels reaches further than 2^25 posts.
    if (std::abs(camera.eye_posts.x) > 1073741824.0 || std::abs(camera.eye_posts.z) > 1073741824.0) return camera;
    camera.draws = true;
    const double base_x = std::floor(camera.eye_posts.x), base_z = std::floor(camera.eye_posts.z);
    camera.base_x = static_cast<std::int32_t>(base_x);
    camera.base_z = static_cast<std::int32_t>(base_z);
    camera.fraction_x_m = static_cast<float>(camera.eye_x_m - base_x * grid.spacing_m);
    camera.fraction_z_m = static_cast<float>(camera.eye_z_m - base_z * grid.spacing_m);
    const double code = std::floor(camera.eye_y_m / codec.code_quantum_m() + 2147483648.0);
    camera.eye_code = static_cast<std::uint32_t>(std::clamp(code, 0.0, 4294967295.0));
    camera.eye_above_code_m = static_cast<float>(
        camera.eye_y_m - (static_cast<double>(camera.eye_code) - 2147483648.0) * codec.code_quantum_m());

    const glm::dvec3 forward = direction(view.forward), right = right_of(forward, view.up);
    const glm::dvec3 up = glm::cross(right, forward);
    camera.forward = from_glm(forward), camera.right = from_glm(right), camera.up = from_glm(up);
    glm::dmat4 rotation(1.0);
    for (int axis = 0; axis < 3; ++axis) {
        rotation[axis][0] = right[axis];
        rotation[axis][1] = up[axis];
        rotation[axis][2] = -forward[axis];
    }
    const double tangent = std::tan(std::clamp(view.fov_y_rad, 0.001, 3.1) / 2);
    camera.pixels_per_radian = view.height / (2 * tangent);
    const glm::dmat4 clip = projection(view, tangent) * rotation;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            camera.clip_from_relative[static_cast<std::size_t>(column * 4 + row)] =
                static_cast<float>(clip[column][row]);

    // Gribb & Hartmann, Fast Extraction of Viewing Frustum Planes, 2001: rows of the matrix.
    const glm::dmat4 rows = glm::transpose(clip);
    const bool reversed = view.depth == DepthConvention::Reversed;
    const glm::dvec4 planes[] = {rows[3] + rows[0],
                                 rows[3] - rows[0],
                                 rows[3] + rows[1],
                                 rows[3] - rows[1],
                                 reversed ? rows[2] : rows[3] + rows[2],
                                 rows[3] - rows[2]};
    for (std::size_t p = 0; p < 6; ++p) camera.planes[p] = {planes[p].x, planes[p].y, planes[p].z, planes[p].w};
    return camera;
}

bool is_culled(const RelativeBox& box, const Camera& camera) {
    for (const std::array<double, 4>& plane : camera.planes) {
        // The corner furthest along the plane's normal.
        const double x = plane[0] * (plane[0] > 0 ? box.max.x : box.min.x);
        const double y = plane[1] * (plane[1] > 0 ? box.max.y : box.min.y);
        const double z = plane[2] * (plane[2] > 0 ? box.max.z : box.min.z);
        const double margin = 1e-5 * (std::abs(x) + std::abs(y) + std::abs(z) + std::abs(plane[3]));
        if (x + y + z + plane[3] < -margin) return true;
    }
    return false;
}

}  // namespace tilth
