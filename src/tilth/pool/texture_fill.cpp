#include "tilth/pool/texture_fill.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "tilth/gl/api.h"

namespace tilth {

Result<TextureFill> TextureFill::create(gl::Device& device) {
    Result<gl::Framebuffer> framebuffer = gl::Framebuffer::create(device, "texture fill");
    if (!framebuffer) return framebuffer.error();
    return TextureFill(device, std::move(*framebuffer));
}

void TextureFill::run(gl::Texture2D& texture, int level, const FillValue& value) {
    if (device_->quirks().uploads_beat_clears) {
        upload(texture, level, value.texel);
        return;
    }
    const gl::Api& gl = device_->gl();
    const gl::Texture2D* const target[] = {&texture};
    framebuffer_.attach(target, level);
    TILTH_EXPECTS(framebuffer_.check().ok(), framebuffer_.check().error().message);
    for (const GLenum capability : {GL_DITHER, GL_SCISSOR_TEST, GL_FRAMEBUFFER_SRGB, GL_RASTERIZER_DISCARD})
        gl.Disable(capability);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    const float colour[] = {value.red, value.green, 0, 0};
    gl.ClearBufferfv(GL_COLOR, 0, colour);
}

void TextureFill::upload(gl::Texture2D& texture, int level, std::uint32_t texel) {
    constexpr int kRows = 16;  // a strip that stays in the second-level cache
    const auto bytes = static_cast<std::size_t>(gl::info_of(texture.format()).transfer_bytes);
    const gl::Rect whole = texture.bounds(level);
    const auto texels = static_cast<std::size_t>(whole.width()) * kRows;
    strip_.resize(texels * bytes);
    for (std::size_t i = 0; i < texels; ++i) std::memcpy(strip_.data() + i * bytes, &texel, bytes);
    for (int row = 0; row < whole.max_y; row += kRows)
        texture.upload(level, {0, row, whole.max_x, std::min(row + kRows, whole.max_y)}, strip_.data());
}

}  // namespace tilth
