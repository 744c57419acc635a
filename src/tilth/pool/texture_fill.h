// Whole textures filled with one value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/objects.h"

namespace tilth {

/// A value for every texel: as a shader would write it, and as it lies in client memory.
struct FillValue {
    float red = 0, green = 0;  ///< unorm formats: the middle of the wanted step, (bits + 0.25) / largest
    std::uint32_t texel = 0;   ///< the format's transfer layout, lowest byte first
};

/// Clears through a framebuffer of its own, with everything off that could change the value on its way; where the
/// driver uploads faster than it clears (`gl::Quirks::uploads_beat_clears`), by uploads. Never waits for the GPU. GL
/// state: framebuffer, colour mask, scissor, dither, sRGB, pixel store; the caller holds a `gl::StateGuard`.
class TextureFill {
public:
    static Result<TextureFill> create(gl::Device& device);

    /// Every texel of `level` becomes `value`; `texture` is of a format that can be drawn to, with 2 or 4 bytes a
    /// texel.
    void run(gl::Texture2D& texture, int level, const FillValue& value);

private:
    TextureFill(gl::Device& device, gl::Framebuffer framebuffer)
        : device_(&device), framebuffer_(std::move(framebuffer)) {}
    void upload(gl::Texture2D& texture, int level, std::uint32_t texel);

    gl::Device* device_;
    gl::Framebuffer framebuffer_;
    std::vector<std::byte> strip_;
};

}  // namespace tilth
