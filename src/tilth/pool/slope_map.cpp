#include "tilth/pool/slope_map.h"

#include <utility>

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
    return SlopeMap(std::move(*texture), width, depth, format);
}

std::uint64_t SlopeMap::bytes() const { return texture_.bytes(); }

}  // namespace tilth
