#include "tilth/gl/objects.h"

#include <utility>

#include "tilth/gl/api.h"

namespace tilth::gl {

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
