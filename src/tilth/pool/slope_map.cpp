#include "tilth/pool/slope_map.h"

#include <utility>

#include "tilth/core/checks.h"

namespace tilth {

SlopeMap::SlopeMap(gl::Texture2D texture, const SlopeSpec& spec)
    : texture_(std::move(texture)),
      origin_(spec.rect.min),
      width_(spec.rect.width()),
      depth_(spec.rect.depth()),
      format_(spec.format) {}

Result<SlopeMap> SlopeMap::create(gl::Device& device, const SlopeSpec& spec) {
    TILTH_EXPECTS(spec.levels >= 1 && spec.levels <= SlopeMap::kLevels, "a slope map has 1 to 8 levels");
    const std::int32_t step = 1 << (spec.levels - 1);
    const auto padded = [step](std::int32_t size) { return (size + step - 1) / step * step; };
    Result<gl::Texture2D> texture =
        gl::Texture2D::create(device, spec.label,
                              {.format = spec.format == SlopeFormat::rg8 ? gl::Format::Rg8 : gl::Format::Rg16F,
                               .width = padded(spec.rect.width()),
                               .height = padded(spec.rect.depth()),
                               .levels = spec.levels,
                               .filter = spec.levels == 1 ? gl::Filter::Linear : gl::Filter::LinearMipNearest});
    if (!texture) return texture.error();
    Result<gl::Framebuffer> framebuffer = gl::Framebuffer::create(device, spec.label);
    if (!framebuffer) return framebuffer.error();
    const gl::Texture2D* const target[] = {&*texture};
    framebuffer->attach(target);
    if (const Result<void> complete = framebuffer->check(); !complete) return complete.error();
    Result<TextureFill> fill = TextureFill::create(device);
    if (!fill) return fill.error();
    SlopeMap made(std::move(*texture), spec);
    made.clear(*fill);
    return made;
}

void SlopeMap::clear(TextureFill& fill) {
    // The padding too: a filter's weight of 0 times an undefined half float may be NaN.
    const FillValue flat = format_ == SlopeFormat::rg8
                               ? FillValue{.red = 128.25f / 255.0f, .green = 128.25f / 255.0f, .texel = 0x8080}
                               : FillValue{};
    for (std::int32_t level = 0; level < levels(); ++level) fill.run(texture_, level, flat);
}

std::uint64_t SlopeMap::bytes() const { return texture_.bytes(); }

}  // namespace tilth
