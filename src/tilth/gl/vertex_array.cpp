#include "tilth/gl/objects.h"

#include "tilth/gl/api.h"
#include "tilth/gl/offset_pointer.h"

namespace tilth::gl {
namespace {

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

}  // namespace

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

}  // namespace tilth::gl
