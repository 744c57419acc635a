#include "tilth/gl/objects.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "tilth/gl/api.h"
#include "tilth/gl/offset_pointer.h"
#include "tilth/gl/pixel_store.h"

namespace tilth::gl {
namespace {

GLint gl_wrap(Wrap wrap) {
    switch (wrap) {
        case Wrap::ClampToEdge:
            return GL_CLAMP_TO_EDGE;
        case Wrap::Repeat:
            return GL_REPEAT;
        case Wrap::MirroredRepeat:
            return GL_MIRRORED_REPEAT;
    }
    return GL_CLAMP_TO_EDGE;
}

GLint gl_min_filter(Filter filter) {
    switch (filter) {
        case Filter::Nearest:
            return GL_NEAREST;
        case Filter::Linear:
            return GL_LINEAR;
        case Filter::NearestMipNearest:
            return GL_NEAREST_MIPMAP_NEAREST;
        case Filter::LinearMipNearest:
            return GL_LINEAR_MIPMAP_NEAREST;
        case Filter::Trilinear:
            return GL_LINEAR_MIPMAP_LINEAR;
    }
    return GL_NEAREST;
}

bool is_nearest(Filter filter) { return filter == Filter::Nearest || filter == Filter::NearestMipNearest; }

Result<void> check_spec(const Capabilities& caps, std::string_view label, const TextureSpec& spec, int most_levels) {
    const auto refused = [&](const auto&... what) {
        return Error{ErrorCode::InvalidArgument, text("texture \"", label, "\": ", what...)};
    };
    if (spec.width < 1 || spec.height < 1 || spec.width > caps.max_texture_size || spec.height > caps.max_texture_size)
        return refused("size is ", spec.width, " x ", spec.height, ", this driver allows 1 to ", caps.max_texture_size,
                       " texels a side");
    if (spec.levels < 0 || spec.levels > most_levels)
        return refused("levels is ", spec.levels, ", allowed are 1 to ", most_levels, ", or 0 for all");
    if (!is_nearest(spec.filter) && !info_of(spec.format).filterable)
        return refused("filter: ", info_of(spec.format).name, " is an integer format, which allows only nearest");
    return {};
}

}  // namespace

Result<Texture2D> Texture2D::create(Device& device, std::string_view label, const TextureSpec& wanted) {
    TextureSpec spec = wanted;
    const int most_levels =
        static_cast<int>(std::bit_width(static_cast<unsigned>(std::max({spec.width, spec.height, 1}))));
    if (Result<void> valid = check_spec(device.capabilities(), label, spec, most_levels); !valid) return valid.error();
    if (spec.levels == 0) spec.levels = most_levels;

    const Api& gl = device.gl();
    const FormatInfo& format = info_of(spec.format);
    device.set_aside_errors();
    GLuint id = 0;
    gl.GenTextures(1, &id);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id);
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);  // else the null pointer below would be an offset into it
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, spec.levels - 1);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, gl_wrap(spec.wrap));
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, gl_wrap(spec.wrap));
    Texture2D texture;
    texture.spec_ = spec;
    for (int level = 0; level < spec.levels; ++level) {
        const int width = texture.width(level), height = texture.height(level);
        gl.TexImage2D(GL_TEXTURE_2D, level, static_cast<GLint>(format.internal), width, height, 0, format.layout,
                      format.type, nullptr);
        texture.bytes_ += static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) *
                          static_cast<std::uint64_t>(format.stored_bytes);
    }
    device.add_live(ObjectKind::Texture, id, texture.bytes_, label);
    texture.handle_ = detail::Handle(device, ObjectKind::Texture, id);
    texture.serial_ = device.next_serial();
    if (const unsigned error = device.next_error(); error != GL_NO_ERROR)
        return out_of_memory("texture", label, texture.bytes_, error);
    texture.set_filter(spec.filter);
    device.label(GL_TEXTURE, id, label);
    return texture;
}

void Texture2D::upload(int level, const Rect& rect, const void* texels, int row_texels) {
    TILTH_EXPECTS(rect.min_x >= 0 && rect.min_y >= 0 && rect.max_x <= width(level) && rect.max_y <= height(level),
                  "upload outside the texture");
    if (rect.empty()) return;
    const Api& gl = handle_.gl();
    const FormatInfo& format = info_of(spec_.format);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    set_unpack(gl, row_texels);
    gl.TexSubImage2D(GL_TEXTURE_2D, level, rect.min_x, rect.min_y, rect.width(), rect.height(), format.layout,
                     format.type, texels);
}

void Texture2D::upload(int level, const Rect& rect, const Buffer& source, std::size_t offset_bytes, int row_texels) {
    TILTH_EXPECTS(rect.min_x >= 0 && rect.min_y >= 0 && rect.max_x <= width(level) && rect.max_y <= height(level),
                  "upload outside the texture");
    if (rect.empty()) return;
    const Api& gl = handle_.gl();
    const FormatInfo& format = info_of(spec_.format);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, source.id());
    set_unpack(gl, row_texels);
    gl.TexSubImage2D(GL_TEXTURE_2D, level, rect.min_x, rect.min_y, rect.width(), rect.height(), format.layout,
                     format.type, offset_pointer(offset_bytes));
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

void Texture2D::read(int level, void* texels) const {
    const Api& gl = handle_.gl();
    const FormatInfo& format = info_of(spec_.format);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    set_pack(gl);
    gl.GetTexImage(GL_TEXTURE_2D, level, format.layout, format.type, texels);
}

void Texture2D::set_filter(Filter filter) {
    const Api& gl = handle_.gl();
    spec_.filter = filter;
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, gl_min_filter(filter));
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, is_nearest(filter) ? GL_NEAREST : GL_LINEAR);
}

void Texture2D::set_level_range(int base, int max) {
    TILTH_EXPECTS(base >= 0 && base <= max && max < levels(), "not levels of the texture");
    const Api& gl = handle_.gl();
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_BASE_LEVEL, base);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, max);
}

void Texture2D::bind(int unit) const {
    const Api& gl = handle_.gl();
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.BindSampler(static_cast<GLuint>(unit), 0);
}

Result<TextureBuffer> TextureBuffer::create(Device& device, std::string_view label, Format format, std::size_t texels,
                                            BufferUsage usage, const void* initial) {
    const FormatInfo& info = info_of(format);
    const auto most = static_cast<std::size_t>(device.capabilities().max_buffer_texels);
    if (texels > most)
        return Error{ErrorCode::InvalidArgument,
                     text("buffer texture \"", label, "\": has ", texels, " texels, this driver allows ", most)};
    Result<Buffer> buffer =
        Buffer::create(device, label, texels * static_cast<std::size_t>(info.stored_bytes), usage, initial);
    if (!buffer) return buffer.error();
    const Api& gl = device.gl();
    TextureBuffer made(*std::move(buffer));
    GLuint id = 0;
    gl.GenTextures(1, &id);
    device.add_live(ObjectKind::Texture, id, 0, label);
    made.texture_ = detail::Handle(device, ObjectKind::Texture, id);
    made.internal_format_ = info.internal;
    made.texel_bytes_ = info.stored_bytes;
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_BUFFER, id);
    gl.TexBuffer(GL_TEXTURE_BUFFER, info.internal, made.buffer_.id());
    device.label(GL_TEXTURE, id, label);
    if (const unsigned error = device.next_error(); error != GL_NO_ERROR)
        return Error{ErrorCode::Unsupported,
                     text("buffer texture \"", label, "\": ", info.name, " refused (", error_name(error), ")")};
    return made;
}

void TextureBuffer::replace(std::span<const std::byte> data) {
    buffer_.replace(data);
    // Some drivers keep the size that the buffer had when it was attached.
    const Api& gl = texture_.gl();
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_BUFFER, id());
    gl.TexBuffer(GL_TEXTURE_BUFFER, internal_format_, buffer_.id());
}

void TextureBuffer::bind(int unit) const {
    const Api& gl = texture_.gl();
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(GL_TEXTURE_BUFFER, id());
}

}  // namespace tilth::gl
