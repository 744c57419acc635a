#include "tilth/gl/texture_copy.h"

#include "tilth/gl/api.h"

namespace tilth::gl {

Result<TextureCopy> TextureCopy::create(Device& device) {
    Result<Framebuffer> framebuffer = Framebuffer::create(device, "texture copy");
    if (!framebuffer) return framebuffer.error();
    return TextureCopy(device, std::move(*framebuffer));
}

void TextureCopy::run(const Texture2D& source, const Texture2D& target, std::span<const CopyRect> rects) {
    const Api& gl = device_->gl();
    if (device_->capabilities().copy_image) {
        for (const CopyRect& r : rects)
            gl.CopyImageSubData(source.id(), GL_TEXTURE_2D, 0, r.from.min_x, r.from.min_y, 0, target.id(),
                                GL_TEXTURE_2D, 0, r.to_x, r.to_y, 0, r.from.width(), r.from.height(), 1);
        return;
    }
    const Texture2D* const attachments[] = {&source};
    framebuffer_.attach(attachments);
    framebuffer_.bind_read();
    target.bind(0);
    for (const CopyRect& r : rects)
        gl.CopyTexSubImage2D(GL_TEXTURE_2D, 0, r.to_x, r.to_y, r.from.min_x, r.from.min_y, r.from.width(),
                             r.from.height());
}

}  // namespace tilth::gl
