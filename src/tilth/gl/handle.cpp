#include "tilth/gl/objects.h"

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

}  // namespace tilth::gl
