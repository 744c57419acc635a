#include "tilth/gl/objects.h"

#include <algorithm>

#include "tilth/gl/api.h"

namespace tilth::gl {
namespace {

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

}  // namespace

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

Result<Buffer> Buffer::create_persistent(Device& device, std::string_view label, std::size_t bytes) {
    if (!device.capabilities().buffer_storage)
        return Error{ErrorCode::Unsupported,
                     text("buffer \"", label, "\": ", device.capabilities().renderer,
                          " has no GL_ARB_buffer_storage and cannot map persistently; map it for each use")};
    constexpr GLbitfield access = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    const Api& gl = device.gl();
    device.set_aside_errors();
    Buffer buffer;
    buffer.bytes_ = bytes;
    GLuint id = 0;
    gl.GenBuffers(1, &id);
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, id);
    gl.BufferStorage(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, access);
    device.add_live(ObjectKind::Buffer, id, bytes, label);
    buffer.handle_ = detail::Handle(device, ObjectKind::Buffer, id);
    if (const unsigned error = device.next_error(); error != GL_NO_ERROR)
        return out_of_memory("persistent buffer", label, bytes, error);
    buffer.mapped_ =
        static_cast<std::byte*>(gl.MapBufferRange(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), access));
    if (buffer.mapped_ == nullptr) return out_of_memory("mapping of buffer", label, bytes, device.next_error());
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

}  // namespace tilth::gl
