// Whole textures filled with one value, on the GPU.
#pragma once

#include <span>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/objects.h"

namespace tilth {

/// Clears through a framebuffer of its own, with everything off that could change the value on its way. Never waits for
/// the GPU and moves no bytes. GL state: framebuffer, colour mask, scissor, dither, sRGB; the caller holds a
/// `gl::StateGuard`.
class TextureFill {
public:
    static Result<TextureFill> create(gl::Device& device);

    /// Every texel of `level` becomes (red, green), as a shader that writes them would leave it; `texture` is of a format
    /// that can be drawn to. For unorm formats give the middle of the wanted step: (bits + 0.25) / largest.
    void run(const gl::Texture2D& texture, int level, float red, float green = 0);

private:
    TextureFill(gl::Device& device, gl::Framebuffer framebuffer)
        : device_(&device), framebuffer_(std::move(framebuffer)) {}
    gl::Device* device_;
    gl::Framebuffer framebuffer_;
};

}  // namespace tilth
