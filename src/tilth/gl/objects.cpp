#include "tilth/gl/objects.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "tilth/gl/api.h"

namespace tilth::gl {
namespace detail {

Handle::Handle(Handle&& other) noexcept
    : device_(other.device_), id_(std::exchange(other.id_, 0)), kind_(other.kind_) {}

Handle& Handle::operator=(Handle&& other) noexcept {
    if (this == &other) return *this;
    reset();
    device_ = other.device_;
    id_ = std::exchange(other.id_, 0);
    kind_ = other.kind_;
    return *this;
}

void Handle::reset() {
    if (id_ == 0) return;
    const Api& api = gl();
    switch (kind_) {
        case ObjectKind::Texture:
            api.DeleteTextures(1, &id_);
            break;
        case ObjectKind::Buffer:
            api.DeleteBuffers(1, &id_);
            break;
        case ObjectKind::VertexArray:
            api.DeleteVertexArrays(1, &id_);
            break;
        case ObjectKind::Framebuffer:
            api.DeleteFramebuffers(1, &id_);
            break;
        case ObjectKind::Program:
            api.DeleteProgram(id_);
            break;
        case ObjectKind::Query:
            api.DeleteQueries(1, &id_);
            break;
    }
    device_->remove_live(kind_, id_);
    id_ = 0;
}

}  // namespace detail

namespace {

/// A transfer's whole pixel-store state: nothing of it may be left to what the host did before.
void set_unpack(const Api& gl, int row_texels) {
    gl.PixelStorei(GL_UNPACK_SWAP_BYTES, GL_FALSE);
    gl.PixelStorei(GL_UNPACK_LSB_FIRST, GL_FALSE);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl.PixelStorei(GL_UNPACK_ROW_LENGTH, row_texels);
    gl.PixelStorei(GL_UNPACK_SKIP_ROWS, 0);
    gl.PixelStorei(GL_UNPACK_SKIP_PIXELS, 0);
    gl.PixelStorei(GL_UNPACK_IMAGE_HEIGHT, 0);
    gl.PixelStorei(GL_UNPACK_SKIP_IMAGES, 0);
}

void set_pack(const Api& gl) {
    gl.PixelStorei(GL_PACK_SWAP_BYTES, GL_FALSE);
    gl.PixelStorei(GL_PACK_LSB_FIRST, GL_FALSE);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.PixelStorei(GL_PACK_ROW_LENGTH, 0);
    gl.PixelStorei(GL_PACK_SKIP_ROWS, 0);
    gl.PixelStorei(GL_PACK_SKIP_PIXELS, 0);
    gl.PixelStorei(GL_PACK_IMAGE_HEIGHT, 0);
    gl.PixelStorei(GL_PACK_SKIP_IMAGES, 0);
}

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

GLenum gl_usage(BufferUsage usage) {
    switch (usage) {
        case BufferUsage::Static:
            return GL_STATIC_DRAW;
        case BufferUsage::Dynamic:
            return GL_DYNAMIC_DRAW;
        case BufferUsage::Stream:
            return GL_STREAM_DRAW;
        case BufferUsage::ReadBack:
            return GL_STREAM_READ;
    }
    return GL_STATIC_DRAW;
}

GLenum gl_target(BufferTarget target) {
    switch (target) {
        case BufferTarget::Vertex:
            return GL_ARRAY_BUFFER;
        case BufferTarget::Uniform:
            return GL_UNIFORM_BUFFER;
        case BufferTarget::PixelUnpack:
            return GL_PIXEL_UNPACK_BUFFER;
        case BufferTarget::PixelPack:
            return GL_PIXEL_PACK_BUFFER;
    }
    return GL_ARRAY_BUFFER;
}

GLenum gl_type(AttributeType type) {
    switch (type) {
        case AttributeType::Float:
            return GL_FLOAT;
        case AttributeType::HalfFloat:
            return GL_HALF_FLOAT;
        case AttributeType::Int:
            return GL_INT;
        case AttributeType::UInt:
            return GL_UNSIGNED_INT;
        case AttributeType::Short:
            return GL_SHORT;
        case AttributeType::UShort:
            return GL_UNSIGNED_SHORT;
        case AttributeType::Byte:
            return GL_BYTE;
        case AttributeType::UByte:
            return GL_UNSIGNED_BYTE;
    }
    return GL_FLOAT;
}

const void* offset_pointer(std::size_t offset_bytes) { return reinterpret_cast<const void*>(offset_bytes); }

Error out_of_memory(const char* what, std::string_view label, std::uint64_t bytes, unsigned gl_error) {
    return {ErrorCode::OutOfMemory, text(what, " \"", label, "\": the driver refused ", bytes, " bytes (",
                                         error_name(gl_error), "); use fewer or smaller tiles")};
}

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

// ---- Texture2D

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

void Texture2D::generate_mipmaps() {
    const Api& gl = handle_.gl();
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.GenerateMipmap(GL_TEXTURE_2D);
}

void Texture2D::set_filter(Filter filter) {
    const Api& gl = handle_.gl();
    spec_.filter = filter;
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, gl_min_filter(filter));
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, is_nearest(filter) ? GL_NEAREST : GL_LINEAR);
}

void Texture2D::bind(int unit) const {
    const Api& gl = handle_.gl();
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(GL_TEXTURE_2D, id());
    gl.BindSampler(static_cast<GLuint>(unit), 0);
}

// ---- Buffer

Result<Buffer> Buffer::create(Device& device, std::string_view label, std::size_t bytes, BufferUsage usage,
                              const void* initial) {
    const Api& gl = device.gl();
    device.set_aside_errors();
    Buffer buffer;
    buffer.bytes_ = bytes;
    buffer.usage_ = gl_usage(usage);
    GLuint id = 0;
    gl.GenBuffers(1, &id);
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, id);
    gl.BufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), initial, buffer.usage_);
    device.add_live(ObjectKind::Buffer, id, bytes, label);
    buffer.handle_ = detail::Handle(device, ObjectKind::Buffer, id);
    if (const unsigned error = device.next_error(); error != GL_NO_ERROR)
        return out_of_memory("buffer", label, bytes, error);
    device.label(GL_BUFFER, id, label);
    return buffer;
}

void Buffer::upload(std::size_t offset_bytes, std::span<const std::byte> data) {
    TILTH_EXPECTS(offset_bytes + data.size() <= bytes_, "upload beyond the end of the buffer");
    const Api& gl = handle_.gl();
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, id());
    gl.BufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset_bytes), static_cast<GLsizeiptr>(data.size()),
                     data.data());
}

void Buffer::replace(std::span<const std::byte> data) {
    const Api& gl = handle_.gl();
    if (data.size() > bytes_) {
        bytes_ = std::max(data.size(), 2 * bytes_);
        handle_.device().resize_live(ObjectKind::Buffer, id(), bytes_);
    }
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, id());
    gl.BufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes_), nullptr, usage_);
    gl.BufferSubData(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(data.size()), data.data());
}

void Buffer::read(std::size_t offset_bytes, std::span<std::byte> data) const {
    const Api& gl = handle_.gl();
    gl.BindBuffer(GL_COPY_READ_BUFFER, id());
    gl.GetBufferSubData(GL_COPY_READ_BUFFER, static_cast<GLintptr>(offset_bytes), static_cast<GLsizeiptr>(data.size()),
                        data.data());
}

void Buffer::bind(BufferTarget target) const { handle_.gl().BindBuffer(gl_target(target), id()); }

void Buffer::bind_uniform(int binding) const { bind_uniform(binding, 0, bytes_); }

void Buffer::bind_uniform(int binding, std::size_t offset_bytes, std::size_t size_bytes) const {
    handle_.gl().BindBufferRange(GL_UNIFORM_BUFFER, static_cast<GLuint>(binding), id(),
                                 static_cast<GLintptr>(offset_bytes), static_cast<GLsizeiptr>(size_bytes));
}

const std::byte* Buffer::map_read(std::size_t offset_bytes, std::size_t size_bytes) {
    const Api& gl = handle_.gl();
    gl.BindBuffer(GL_COPY_READ_BUFFER, id());
    return static_cast<const std::byte*>(gl.MapBufferRange(GL_COPY_READ_BUFFER, static_cast<GLintptr>(offset_bytes),
                                                           static_cast<GLsizeiptr>(size_bytes), GL_MAP_READ_BIT));
}

std::byte* Buffer::map_write(std::size_t offset_bytes, std::size_t size_bytes) {
    const Api& gl = handle_.gl();
    gl.BindBuffer(GL_COPY_READ_BUFFER, id());
    return static_cast<std::byte*>(
        gl.MapBufferRange(GL_COPY_READ_BUFFER, static_cast<GLintptr>(offset_bytes), static_cast<GLsizeiptr>(size_bytes),
                          GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_RANGE_BIT | GL_MAP_UNSYNCHRONIZED_BIT));
}

bool Buffer::unmap() {
    const Api& gl = handle_.gl();
    gl.BindBuffer(GL_COPY_READ_BUFFER, id());
    return gl.UnmapBuffer(GL_COPY_READ_BUFFER) == GL_TRUE;
}

// ---- TextureBuffer

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

// ---- VertexArray

Result<VertexArray> VertexArray::create(Device& device, std::string_view label) {
    VertexArray array;
    GLuint id = 0;
    device.gl().GenVertexArrays(1, &id);
    device.add_live(ObjectKind::VertexArray, id, 0, label);
    array.handle_ = detail::Handle(device, ObjectKind::VertexArray, id);
    array.bind();  // a name becomes an object when it is first bound
    device.label(GL_VERTEX_ARRAY, id, label);
    return array;
}

void VertexArray::bind() const { handle_.gl().BindVertexArray(id()); }

void VertexArray::float_attribute(int location, const Buffer& buffer, int components, AttributeType type,
                                  int stride_bytes, std::size_t offset_bytes, int divisor, bool normalized) {
    const Api& gl = handle_.gl();
    const auto index = static_cast<GLuint>(location);
    bind();
    buffer.bind(BufferTarget::Vertex);
    gl.EnableVertexAttribArray(index);
    gl.VertexAttribPointer(index, components, gl_type(type), normalized ? GL_TRUE : GL_FALSE, stride_bytes,
                           offset_pointer(offset_bytes));
    gl.VertexAttribDivisor(index, static_cast<GLuint>(divisor));
}

void VertexArray::int_attribute(int location, const Buffer& buffer, int components, AttributeType type,
                                int stride_bytes, std::size_t offset_bytes, int divisor) {
    const Api& gl = handle_.gl();
    const auto index = static_cast<GLuint>(location);
    bind();
    buffer.bind(BufferTarget::Vertex);
    gl.EnableVertexAttribArray(index);
    gl.VertexAttribIPointer(index, components, gl_type(type), stride_bytes, offset_pointer(offset_bytes));
    gl.VertexAttribDivisor(index, static_cast<GLuint>(divisor));
}

void VertexArray::index_buffer(const Buffer& buffer) {
    bind();
    handle_.gl().BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer.id());
}

// ---- Framebuffer

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

// ---- Program

Program::Program(Device& device, ProgramRecipe recipe, unsigned id) : recipe_(std::move(recipe)) {
    device.add_live(ObjectKind::Program, id, 0, recipe_.label);
    handle_ = detail::Handle(device, ObjectKind::Program, id);
}

void Program::adopt(unsigned id) {
    Device& device = handle_.device();
    device.add_live(ObjectKind::Program, id, 0, recipe_.label);
    handle_ = detail::Handle(device, ObjectKind::Program, id);
    ++generation_;
    for (std::size_t i = 0; i < names_.size(); ++i)
        locations_[i] = device.gl().GetUniformLocation(id, names_[i].c_str());
    for (const auto& [name, unit] : std::exchange(samplers_, {})) sampler(name, unit);
    for (const auto& [name, binding] : std::exchange(blocks_, {})) uniform_block(name, binding);
}

void Program::bind() const { handle_.gl().UseProgram(id()); }

Uniform Program::uniform(std::string_view name) {
    const auto known = std::find(names_.begin(), names_.end(), name);
    if (known == names_.end()) {
        names_.emplace_back(name);
        locations_.push_back(handle_.gl().GetUniformLocation(id(), names_.back().c_str()));
        return {static_cast<int>(names_.size()) - 1};
    }
    return {static_cast<int>(known - names_.begin())};
}

void Program::sampler(std::string_view name, int unit) {
    bind();
    set(uniform(name), unit);
    std::erase_if(samplers_, [&](const auto& entry) { return entry.first == name; });
    samplers_.emplace_back(name, unit);
}

void Program::uniform_block(std::string_view name, int binding) {
    const Api& gl = handle_.gl();
    const std::string terminated(name);
    const GLuint index = gl.GetUniformBlockIndex(id(), terminated.c_str());
    if (index != GL_INVALID_INDEX) gl.UniformBlockBinding(id(), index, static_cast<GLuint>(binding));
    std::erase_if(blocks_, [&](const auto& entry) { return entry.first == name; });
    blocks_.emplace_back(terminated, binding);
}

void Program::set(Uniform u, int x) const { handle_.gl().Uniform1i(location(u), x); }
void Program::set(Uniform u, unsigned x) const { handle_.gl().Uniform1ui(location(u), x); }
void Program::set(Uniform u, float x) const { handle_.gl().Uniform1f(location(u), x); }
void Program::set(Uniform u, int x, int y) const { handle_.gl().Uniform2i(location(u), x, y); }
void Program::set(Uniform u, int x, int y, int z, int w) const { handle_.gl().Uniform4i(location(u), x, y, z, w); }
void Program::set(Uniform u, float x, float y) const { handle_.gl().Uniform2f(location(u), x, y); }
void Program::set(Uniform u, float x, float y, float z) const { handle_.gl().Uniform3f(location(u), x, y, z); }
void Program::set(Uniform u, float x, float y, float z, float w) const {
    handle_.gl().Uniform4f(location(u), x, y, z, w);
}
void Program::set_ivec4s(Uniform u, std::span<const std::int32_t> values) const {
    handle_.gl().Uniform4iv(location(u), static_cast<GLsizei>(values.size() / 4), values.data());
}
void Program::set_vec4s(Uniform u, std::span<const float> values) const {
    handle_.gl().Uniform4fv(location(u), static_cast<GLsizei>(values.size() / 4), values.data());
}
void Program::set_mat3(Uniform u, const float* column_major) const {
    handle_.gl().UniformMatrix3fv(location(u), 1, GL_FALSE, column_major);
}
void Program::set_mat4(Uniform u, const float* column_major) const {
    handle_.gl().UniformMatrix4fv(location(u), 1, GL_FALSE, column_major);
}

// ---- Query

Result<Query> Query::create(Device& device, std::string_view label, QueryKind kind) {
    const Capabilities& caps = device.capabilities();
    if (kind == QueryKind::VertexInvocations && !caps.pipeline_statistics)
        return Error{ErrorCode::Unsupported,
                     text("query \"", label, "\": ", caps.renderer, " has no GL_ARB_pipeline_statistics_query")};
    if (kind == QueryKind::TimeElapsed && caps.timer_query_bits == 0)
        return Error{ErrorCode::Unsupported, text("query \"", label, "\": ", caps.renderer, " has no timer queries")};
    Query query;
    switch (kind) {
        case QueryKind::TimeElapsed:
            query.target_ = GL_TIME_ELAPSED;
            break;
        case QueryKind::SamplesPassed:
            query.target_ = GL_SAMPLES_PASSED;
            break;
        case QueryKind::PrimitivesGenerated:
            query.target_ = GL_PRIMITIVES_GENERATED;
            break;
        case QueryKind::VertexInvocations:
            query.target_ = GL_VERTEX_SHADER_INVOCATIONS_ARB;
            break;
    }
    GLuint id = 0;
    device.gl().GenQueries(1, &id);
    device.add_live(ObjectKind::Query, id, 0, label);
    query.handle_ = detail::Handle(device, ObjectKind::Query, id);
    // Becomes an object, and can be labelled, only by its first use; begin() would be one.
    return query;
}

void Query::begin() { handle_.gl().BeginQuery(target_, handle_.id()); }
void Query::end() { handle_.gl().EndQuery(target_); }

bool Query::available() const {
    GLuint available = 0;
    handle_.gl().GetQueryObjectuiv(handle_.id(), GL_QUERY_RESULT_AVAILABLE, &available);
    return available != 0;
}

std::uint64_t Query::result() const {
    GLuint64 result = 0;
    handle_.gl().GetQueryObjectui64v(handle_.id(), GL_QUERY_RESULT, &result);
    return result;
}

// ---- Fence

Fence Fence::insert(Device& device) { return {device, device.gl().FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)}; }

Fence::~Fence() {
    if (sync_ != nullptr) device_->gl().DeleteSync(static_cast<GLsync>(sync_));
}

Fence::Fence(Fence&& other) noexcept
    : device_(other.device_),
      sync_(std::exchange(other.sync_, nullptr)),
      flushed_(other.flushed_),
      passed_(other.passed_) {}

Fence& Fence::operator=(Fence&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(sync_, other.sync_);
    std::swap(flushed_, other.flushed_);
    std::swap(passed_, other.passed_);
    return *this;
}

bool Fence::signaled() { return wait(0); }

bool Fence::wait(std::uint64_t timeout_ns) {
    if (passed_) return true;
    const GLbitfield flags = flushed_ ? 0 : GL_SYNC_FLUSH_COMMANDS_BIT;
    flushed_ = true;
    const GLenum status = device_->gl().ClientWaitSync(static_cast<GLsync>(sync_), flags, timeout_ns);
    passed_ = status == GL_ALREADY_SIGNALED || status == GL_CONDITION_SATISFIED;
    return passed_;
}

}  // namespace tilth::gl
