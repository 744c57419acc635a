#include "tilth/gl/objects.h"

#include "tilth/gl/api.h"
#include "tilth/gl/pixel_store.h"

namespace tilth::gl {

Result<Framebuffer> Framebuffer::create(Device& device, std::string_view label) {
    Framebuffer framebuffer;
    GLuint id = 0;
    device.gl().GenFramebuffers(1, &id);
    device.add_live(ObjectKind::Framebuffer, id, 0, label);
    framebuffer.handle_ = detail::Handle(device, ObjectKind::Framebuffer, id);
    framebuffer.bind();
    device.label(GL_FRAMEBUFFER, id, label);
    return framebuffer;
}

void Framebuffer::attach(std::span<const Texture2D* const> colours, int level, const Texture2D* depth) {
    TILTH_ASSERT(colours.size() <= attached_.size(), "more than eight colour attachments");
    const Api& gl = handle_.gl();
    bind();
    const bool other_level = level != level_;
    for (std::size_t i = 0; i < attached_.size(); ++i) {
        const Texture2D* colour = i < colours.size() ? colours[i] : nullptr;
        const std::uint64_t serial = colour != nullptr ? colour->serial() : 0;
        if (serial == attached_[i] && (serial == 0 || !other_level)) continue;
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i), GL_TEXTURE_2D,
                                colour != nullptr ? colour->id() : 0, colour != nullptr ? level : 0);
        attached_[i] = serial;
    }
    const std::uint64_t depth_serial = depth != nullptr ? depth->serial() : 0;
    if (depth_serial != depth_attached_) {
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth != nullptr ? depth->id() : 0,
                                0);
        depth_attached_ = depth_serial;
    }
    level_ = level;
    if (colours_ == static_cast<int>(colours.size())) return;
    colours_ = static_cast<int>(colours.size());
    std::array<GLenum, 8> buffers{};
    for (std::size_t i = 0; i < colours.size(); ++i) buffers[i] = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i);
    if (colours.empty()) {
        gl.DrawBuffer(GL_NONE);
        gl.ReadBuffer(GL_NONE);
    } else {
        gl.DrawBuffers(colours_, buffers.data());
        gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
    }
}

Result<void> Framebuffer::check() const {
    const Api& gl = handle_.gl();
    bind();
    const GLenum status = gl.CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE) return {};
    const char* reason = "status unknown";
    switch (status) {
        case GL_FRAMEBUFFER_UNDEFINED:
            reason = "undefined";
            break;
        case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT:
            reason = "an attachment cannot be drawn to";
            break;
        case GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT:
            reason = "it has no attachment";
            break;
        case GL_FRAMEBUFFER_UNSUPPORTED:
            reason = "this combination of formats is not supported";
            break;
        default:
            break;
    }
    return Error{ErrorCode::Unsupported, text("framebuffer ", id(), " with ", colours_, " colour attachments on ",
                                              handle_.device().capabilities().renderer, ": ", reason)};
}

void Framebuffer::bind() const { handle_.gl().BindFramebuffer(GL_FRAMEBUFFER, id()); }

void Framebuffer::bind_read() const { handle_.gl().BindFramebuffer(GL_READ_FRAMEBUFFER, id()); }

void Framebuffer::read(const Rect& rect, Format format, void* texels, int attachment) const {
    const Api& gl = handle_.gl();
    const FormatInfo& info = info_of(format);
    bind_read();
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    set_pack(gl);
    gl.ClampColor(GL_CLAMP_READ_COLOR, GL_FALSE);  // else negative SNORM values read as 0
    if (!info.depth) gl.ReadBuffer(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachment));
    gl.ReadPixels(rect.min_x, rect.min_y, rect.width(), rect.height(), info.layout, info.type, texels);
    if (!info.depth && attachment != 0) gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
}

}  // namespace tilth::gl
