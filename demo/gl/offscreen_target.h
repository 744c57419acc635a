// Where the headless sandbox draws: a framebuffer object with colour and depth, and its pixels as pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tilth/core/vec.h"
#include "tilth/gl/objects.h"

namespace tilth::demo {

/// A picture of fixed size in RGBA8, as the terrain renderer asks for: colours are stored as they are drawn.
/// Thread: the one that owns the context.
class OffscreenTarget {
public:
    /// Sizes in pixels. Fails with what GL refuses (size over the driver's limit, memory).
    static Result<OffscreenTarget> create(gl::Device& device, int width, int height);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }

    /// Binds it for drawing, sets its viewport, clears colour (linear RGB) and depth (1).
    void begin(const Vec3f& clear);
    /// Waits until everything drawn is there, so that a frame's time holds its own work. A program may; the library
    /// never.
    void finish();
    /// 8-bit RGB, top row first. Waits.
    [[nodiscard]] std::vector<std::uint8_t> read_rgb8() const;
    /// Depth buffer, 0 near and 1 far, top row first. Waits.
    [[nodiscard]] std::vector<float> read_depth() const;

private:
    OffscreenTarget(gl::Device& device, gl::Texture2D colour, gl::Texture2D depth, gl::Framebuffer framebuffer);

    gl::Device* device_;
    int width_, height_;
    gl::Texture2D colour_, depth_;
    gl::Framebuffer framebuffer_;
};

}  // namespace tilth::demo
