// Copies of texels from one texture to another, exact bits, on the GPU.
#pragma once

#include <span>

#include "tilth/core/result.h"
#include "tilth/gl/objects.h"

namespace tilth::gl {

/// One rectangle: `from` in the source, its size, and where its corner goes in the target.
struct CopyRect {
    Rect from;
    std::int32_t to_x = 0, to_y = 0;
};

/// Copies level 0 of one texture into another of the same format. Uses glCopyImageSubData where the context has it,
/// else glCopyTexSubImage2D through a read framebuffer. Cost: one call a rectangle; on llvmpipe under a microsecond to
/// 64 x 64. GL state: may touch the framebuffer bindings and texture unit 0.
class TextureCopy {
public:
    static Result<TextureCopy> create(Device& device);
    void run(const Texture2D& source, const Texture2D& target, std::span<const CopyRect> rects);

private:
    TextureCopy(Device& device, Framebuffer framebuffer) : device_(&device), framebuffer_(std::move(framebuffer)) {}
    Device* device_;
    Framebuffer framebuffer_;
};

}  // namespace tilth::gl
