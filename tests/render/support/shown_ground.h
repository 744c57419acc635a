// What a depth image says about where the ground was shown, against where it is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "render/support/detail_mesh.h"
#include "tilth/render/view.h"

namespace tilth::test {

/// The rays of a picture's pixels, and the way back from depth, in doubles. Standard depth alone. Shares no code with
/// render/camera.h.
class PixelRays {
public:
    explicit PixelRays(const View& view) : view_(view) {
        forward_ = glm::normalize(glm::dvec3(view.forward.x, view.forward.y, view.forward.z));
        glm::dvec3 up(view.up.x, view.up.y, view.up.z);
        if (glm::length(glm::cross(forward_, up)) <= 1e-6) up = {0, 0, -1};
        right_ = glm::normalize(glm::cross(forward_, up));
        up_ = glm::cross(right_, forward_);
        tangent_ = std::tan(view.fov_y_rad / 2);
    }
    /// Through the middle of pixel (x, y), (0, 0) the lower left; its component along the view direction is 1.
    [[nodiscard]] glm::dvec3 ray(int x, int y) const {
        const double u = (2 * (x + 0.5) / view_.width - 1) * tangent_ * view_.width / view_.height,
                     v = (2 * (y + 0.5) / view_.height - 1) * tangent_;
        return forward_ + u * right_ + v * up_;
    }
    /// Metres along the view direction at which depth `d` lies: the factor of `ray`.
    [[nodiscard]] double along_m(double d) const {
        const double n = view_.near_m, f = view_.far_m;
        return n * f / (f - d * (f - n));
    }
    /// What one step of d moves that by.
    [[nodiscard]] double along_per_depth_m(double along) const {
        return along * along * (view_.far_m - view_.near_m) / (view_.far_m * view_.near_m);
    }
    [[nodiscard]] double pixels_per_radian() const { return view_.height / (2 * tangent_); }

private:
    View view_;
    glm::dvec3 forward_, right_, up_;
    double tangent_;
};

/// How far the ground that a picture shows is from where it is. Errors are in pixels: the height by which the shown
/// point misses the surface at its own (x, z), as tall as it looks from the eye: |dh| cos(elevation) pixels_per_radian
/// / distance.
struct ShownGround {
    long pixels = 0;  ///< looked at: ground in the truth, no farther than asked for
    double rms_px = 0, p99_px = 0, max_px = 0;
    /// Pixels that show another place of the surface: more than a texel from the truth, along the ray. `wrong_inside`:
    /// without those beside which the truth's own depth jumps by more than a texel (3 x 3), where the share of a pixel
    /// decides.
    long wrong = 0, wrong_inside = 0;
    long background = 0;  ///< ground in one of the two pictures alone, at any distance
    /// Errors as a share of what rounding of float depth alone may make of a pixel (`kDepthSteps`): 99th percentile.
    double p99_roundings = 0;
    [[nodiscard]] double wrong_share() const { return pixels > 0 ? static_cast<double>(wrong) / pixels : 0; }
};

/// Depth steps by which a rasteriser may round: z / w has three roundings of half a step below 1, and a plane's
/// interpolation over a picture as many again.
inline constexpr double kDepthSteps = 6;

/// `depth`, `truth`: width * height of the picture and of the brute-force mesh, lowest row first, cleared to 1.
/// Pixels between `from_m` and `to_m` from the eye count, by the truth.
inline ShownGround compare_ground(const View& view, const std::vector<float>& depth, const std::vector<float>& truth,
                                  const ContractSurface& surface, double to_m, double from_m = 0) {
    const PixelRays rays(view);
    ShownGround shown;
    std::vector<double> errors, roundings;
    double squares = 0;
    const auto at = [&](int x, int y) { return static_cast<std::size_t>(y * view.width + x); };
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const double d = depth[at(x, y)], t = truth[at(x, y)];
            if ((d < 1) != (t < 1)) ++shown.background;
            if (d >= 1 || t >= 1) continue;
            const glm::dvec3 ray = rays.ray(x, y);
            const double length = glm::length(ray), true_m = rays.along_m(t) * length;
            if (true_m > to_m || true_m < from_m) continue;
            ++shown.pixels;
            const double along = rays.along_m(d);
            const glm::dvec3 point = ray * along;
            const double distance = glm::length(point), flat = std::hypot(point.x, point.z) / distance;
            const double per_m = flat * rays.pixels_per_radian() / distance;
            const double dh = view.eye.y + point.y - surface.height_m(view.eye.x + point.x, view.eye.z + point.z);
            const double error = std::abs(dh) * per_m;
            errors.push_back(error);
            squares += error * error;
            shown.max_px = std::max(shown.max_px, error);
            // A place that is off by e along the ray is off in height by at most e (|dy| + slope * the rest); allowed
            // for here is ground as steep as 1 in 1.
            const double rounding = kDepthSteps * 0x1p-24 * rays.along_per_depth_m(along) *
                                    (std::abs(ray.y) + std::hypot(ray.x, ray.z)) * per_m;
            roundings.push_back(error / rounding);
            const double texel_m = surface.texel_spacing_m();
            if (std::abs(distance - true_m) <= texel_m) continue;
            ++shown.wrong;
            double low = t, high = t;
            for (int b = std::max(y - 1, 0); b <= std::min(y + 1, view.height - 1); ++b)
                for (int a = std::max(x - 1, 0); a <= std::min(x + 1, view.width - 1); ++a)
                    low = std::min(low, double(truth[at(a, b)])), high = std::max(high, double(truth[at(a, b)]));
            // A smooth slope changes from pixel to pixel, too: a jump is what exceeds that by a texel.
            const double pixel_m = true_m / rays.pixels_per_radian() / std::max(std::abs(ray.y) / length, 0.02);
            const double span = high < 1 ? (rays.along_m(high) - rays.along_m(low)) * length : 1e9;
            if (span <= texel_m + 2 * pixel_m) ++shown.wrong_inside;
        }
    }
    if (errors.empty()) return shown;
    const auto p99 = [](std::vector<double>& of) {
        const auto middle = of.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(of.size() - 1) * 0.99);
        std::nth_element(of.begin(), middle, of.end());
        return *middle;
    };
    shown.p99_px = p99(errors);
    shown.p99_roundings = p99(roundings);
    shown.rms_px = std::sqrt(squares / static_cast<double>(errors.size()));
    return shown;
}

inline void print_ground(const char* name, const ShownGround& g) {
    std::printf(
        "%-28s rms %8.5f  p99 %8.5f  max %8.4f px, p99 %6.2f roundings; wrong %7.4f %% (inside %ld), background %ld of "
        "%ld\n",
        name, g.rms_px, g.p99_px, g.max_px, g.p99_roundings, 100 * g.wrong_share(), g.wrong_inside, g.background,
        g.pixels);
}

}  // namespace tilth::test
