#include "tilth/pool/texture_fill.h"

#include <utility>

#include "tilth/gl/api.h"

namespace tilth {

Result<TextureFill> TextureFill::create(gl::Device& device) {
    Result<gl::Framebuffer> framebuffer = gl::Framebuffer::create(device, "texture fill");
    if (!framebuffer) return framebuffer.error();
    return TextureFill(device, std::move(*framebuffer));
}

void TextureFill::run(const gl::Texture2D& texture, int level, float red, float green) {
    const gl::Api& gl = device_->gl();
    const gl::Texture2D* const target[] = {&texture};
    framebuffer_.attach(target, level);
    TILTH_EXPECTS(framebuffer_.check().ok(), framebuffer_.check().error().message);
    for (const GLenum capability : {GL_DITHER, GL_SCISSOR_TEST, GL_FRAMEBUFFER_SRGB, GL_RASTERIZER_DISCARD})
        gl.Disable(capability);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    const float value[] = {red, green, 0, 0};
    gl.ClearBufferfv(GL_COLOR, 0, value);
}

}  // namespace tilth
