// A target to draw a terrain into, and what walks say about their frames.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "support/bench_device.h"
#include "tilth/core/hash.h"
#include "tilth/terrain.h"

namespace tilth::bench {

inline double wall_ms() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The `share` of the samples lies below; 1: the longest.
inline double percentile(std::vector<double> samples, double share) {
    if (samples.empty()) return 0;
    std::sort(samples.begin(), samples.end());
    return samples[static_cast<std::size_t>(std::lround(share * static_cast<double>(samples.size() - 1)))];
}

/// From 2 m over the coarse ground at `at`, along +x or -x, slightly down, 90 degrees.
inline View at_eye_height(const Terrain& terrain, WorldPos at, double forward_x = 1) {
    return {.eye = {at.x, terrain.ground().height_m(at, MapSelect::Coarse) + 2, at.z},
            .forward = {forward_x, -0.15, 0},
            .fov_y_rad = std::numbers::pi / 2,
            .near_m = 0.1,
            .far_m = 1000};
}

/// A framebuffer of the shared device, RGBA8 and 32-bit depth.
class Picture {
public:
    Picture(int width, int height)
        : width_(width),
          height_(height),
          colour_(value(gl::Texture2D::create(device(), "bench colour", {gl::Format::Rgba8, width, height}))),
          depth_(value(gl::Texture2D::create(device(), "bench depth", {gl::Format::Depth32F, width, height}))),
          target_(value(gl::Framebuffer::create(device(), "bench target"))) {
        const gl::Texture2D* const colours[] = {&colour_};
        target_.attach(colours, 0, &depth_);
    }
    /// Clears, and queues a picture of the ground; the view's size becomes the picture's.
    void draw(Terrain& terrain, View view) {
        view.width = width_, view.height = height_;
        const gl::Api& gl = device().gl();
        target_.bind();
        gl.Viewport(0, 0, width_, height_);
        gl.DepthMask(GL_TRUE);
        gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        check(terrain.draw(view, {}));
    }
    /// RGBA, the lowest row first. Waits.
    [[nodiscard]] std::vector<std::uint8_t> pixels() {
        std::vector<std::uint8_t> rgba(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 4);
        target_.read(colour_.bounds(), gl::Format::Rgba8, rgba.data());
        return rgba;
    }
    [[nodiscard]] std::uint64_t hash() {
        const std::vector<std::uint8_t> rgba = pixels();
        return hash_bytes(std::as_bytes(std::span(rgba)));
    }

private:
    int width_, height_;
    gl::Texture2D colour_, depth_;
    gl::Framebuffer target_;
};

}  // namespace tilth::bench
