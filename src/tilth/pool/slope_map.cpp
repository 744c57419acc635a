#include "tilth/pool/slope_map.h"

#include <utility>
#include <vector>

namespace tilth {

SlopeMap::SlopeMap(gl::Texture2D texture, std::int32_t width, std::int32_t depth, SlopeFormat format)
    : texture_(std::move(texture)), width_(width), depth_(depth), format_(format) {}

Result<SlopeMap> SlopeMap::create(gl::Device& device, std::int32_t width, std::int32_t depth, SlopeFormat format) {
    constexpr std::int32_t kStep = 1 << (kLevels - 1);
    const auto padded = [](std::int32_t size) { return (size + kStep - 1) / kStep * kStep; };
    Result<gl::Texture2D> texture =
        gl::Texture2D::create(device, "coarse slopes",
                              {.format = format == SlopeFormat::rg8 ? gl::Format::Rg8 : gl::Format::Rg16F,
                               .width = padded(width),
                               .height = padded(depth),
                               .levels = kLevels,
                               .filter = gl::Filter::LinearMipNearest});
    if (!texture) return texture.error();
    // Flat everywhere, the padding included: a filter's weight of 0 times an undefined half float may be NaN.
    const bool bytes = format == SlopeFormat::rg8;
    for (std::int32_t level = 0; level < kLevels; ++level) {
        const gl::Rect whole = texture->bounds(level);
        const std::vector<std::uint8_t> flat(static_cast<std::size_t>(whole.count()) * (bytes ? 2 : 4),
                                             bytes ? 128 : 0);
        texture->upload(level, whole, flat.data());
    }
    Result<gl::Framebuffer> framebuffer = gl::Framebuffer::create(device, "slope map");
    if (!framebuffer) return framebuffer.error();
    const gl::Texture2D* const target[] = {&*texture};
    framebuffer->attach(target);
    if (const Result<void> complete = framebuffer->check(); !complete) return complete.error();
    return SlopeMap(std::move(*texture), width, depth, format);
}

std::uint64_t SlopeMap::bytes() const { return texture_.bytes(); }

}  // namespace tilth
