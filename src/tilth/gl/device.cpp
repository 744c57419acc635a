#include "tilth/gl/device.h"

#include <algorithm>

#include "tilth/core/log.h"
#include "tilth/gl/api.h"

namespace tilth::gl {
namespace {

GLADapiproc proc_from(void* get_proc, const char* name) {
    return reinterpret_cast<GLADapiproc>(reinterpret_cast<GetProc>(get_proc)(name));
}

std::string string_of(const Api& gl, GLenum name) {
    const GLubyte* value = gl.GetString(name);
    return value != nullptr ? reinterpret_cast<const char*>(value) : "";
}

int integer_of(const Api& gl, GLenum name) {
    GLint value = 0;
    gl.GetIntegerv(name, &value);
    return value;
}

std::vector<std::string> extensions_of(const Api& gl) {
    std::vector<std::string> names;
    const int count = integer_of(gl, GL_NUM_EXTENSIONS);
    names.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
        names.emplace_back(reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))));
    std::sort(names.begin(), names.end());
    return names;
}

Capabilities capabilities_of(const Api& gl) {
    Capabilities c;
    c.version = {integer_of(gl, GL_MAJOR_VERSION), integer_of(gl, GL_MINOR_VERSION)};
    c.vendor = string_of(gl, GL_VENDOR);
    c.renderer = string_of(gl, GL_RENDERER);
    c.version_text = string_of(gl, GL_VERSION);
    c.extensions = extensions_of(gl);
    c.max_texture_size = integer_of(gl, GL_MAX_TEXTURE_SIZE);
    c.max_array_layers = integer_of(gl, GL_MAX_ARRAY_TEXTURE_LAYERS);
    c.max_buffer_texels = integer_of(gl, GL_MAX_TEXTURE_BUFFER_SIZE);
    c.max_uniform_block_bytes = integer_of(gl, GL_MAX_UNIFORM_BLOCK_SIZE);
    c.max_vertex_textures = integer_of(gl, GL_MAX_VERTEX_TEXTURE_IMAGE_UNITS);
    c.max_texture_units = integer_of(gl, GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS);
    c.max_colour_attachments = integer_of(gl, GL_MAX_COLOR_ATTACHMENTS);
    c.max_geometry_vertices = integer_of(gl, GL_MAX_GEOMETRY_OUTPUT_VERTICES);
    gl.GetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &c.timer_query_bits);

    // The extension string decides: Mesa hands out entry points of extensions that it does not have.
    c.debug = gl.KHR_debug != 0;
    c.buffer_storage = gl.ARB_buffer_storage != 0;
    c.clip_control = gl.ARB_clip_control != 0;
    c.copy_image = gl.ARB_copy_image != 0;
    c.texture_barrier = gl.ARB_texture_barrier != 0;
    c.pipeline_statistics = gl.ARB_pipeline_statistics_query != 0;
    // Its shaders are GLSL 4.00, which the extension alone does not promise.
    c.tessellation = gl.ARB_tessellation_shader != 0 && c.version >= Version{4, 0};
    c.viewport_array = gl.ARB_viewport_array != 0;
    c.draw_buffers_blend = gl.ARB_draw_buffers_blend != 0;
    c.fixed_index_restart = c.version >= Version{4, 3} || c.has_extension("GL_ARB_ES3_compatibility");
    if (c.tessellation) {
        c.max_patch_vertices = integer_of(gl, GL_MAX_PATCH_VERTICES);
        c.max_tessellation_level = integer_of(gl, GL_MAX_TESS_GEN_LEVEL);
    }
    if (gl.EXT_texture_filter_anisotropic != 0 || gl.ARB_texture_filter_anisotropic != 0)
        gl.GetFloatv(GL_MAX_TEXTURE_MAX_ANISOTROPY_EXT, &c.max_anisotropy);
    return c;
}

std::string kind_of(GLenum type) {
    switch (type) {
        case GL_DEBUG_TYPE_ERROR:
            return "error";
        case GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR:
            return "deprecated";
        case GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR:
            return "undefined";
        case GL_DEBUG_TYPE_PORTABILITY:
            return "portability";
        case GL_DEBUG_TYPE_PERFORMANCE:
            return "performance";
        default:
            return "other";
    }
}

void GLAD_API_PTR on_debug_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                   const GLchar* message, const void* user) {
    // Our own groups come back as messages of the application; notifications are chatter.
    if (severity == GL_DEBUG_SEVERITY_NOTIFICATION || source == GL_DEBUG_SOURCE_APPLICATION) return;
    DebugMessage entry;
    entry.severity = severity == GL_DEBUG_SEVERITY_HIGH     ? DebugSeverity::High
                     : severity == GL_DEBUG_SEVERITY_MEDIUM ? DebugSeverity::Medium
                                                            : DebugSeverity::Low;
    entry.id = id;
    entry.kind = kind_of(type);
    entry.text = length >= 0 ? std::string(message, static_cast<std::size_t>(length)) : std::string(message);
    static_cast<Device*>(const_cast<void*>(user))->add_message(std::move(entry));
}

const char* name_of(ObjectKind kind) {
    switch (kind) {
        case ObjectKind::Texture:
            return "texture";
        case ObjectKind::Buffer:
            return "buffer";
        case ObjectKind::VertexArray:
            return "vertex array";
        case ObjectKind::Framebuffer:
            return "framebuffer";
        case ObjectKind::Program:
            return "program";
        case ObjectKind::Query:
            return "query";
    }
    return "object";
}

}  // namespace

bool Capabilities::has_extension(std::string_view name) const {
    return std::binary_search(extensions.begin(), extensions.end(), name);
}

std::string error_name(unsigned gl_error) {
    switch (gl_error) {
        case GL_NO_ERROR:
            return "GL_NO_ERROR";
        case GL_INVALID_ENUM:
            return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE:
            return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION:
            return "GL_INVALID_OPERATION";
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            return "GL_INVALID_FRAMEBUFFER_OPERATION";
        case GL_OUT_OF_MEMORY:
            return "GL_OUT_OF_MEMORY";
        case GL_STACK_UNDERFLOW:
            return "GL_STACK_UNDERFLOW";
        case GL_STACK_OVERFLOW:
            return "GL_STACK_OVERFLOW";
        default:
            return text("GL error ", gl_error);
    }
}

/// What the host had before our debug callback.
struct Device::HostDebug {
    void* callback = nullptr;
    void* user = nullptr;
    bool output = false, synchronous = false;
};

Device::Device() : api_(std::make_unique<Api>()) {}

Device::~Device() {
    for (const LiveObject& object : live_)
        log(LogLevel::Error,
            text("GL ", name_of(object.kind), " ", object.id, " \"", object.label, "\" (", object.bytes,
                 " bytes) is still alive when its device is destroyed; destroy its owner first"));
    if (host_debug_) remove_debug_callback();
}

Result<std::unique_ptr<Device>> Device::create(GetProc get_proc, DeviceOptions options) {
    if (get_proc == nullptr)
        return Error{ErrorCode::InvalidArgument, "get_proc: is null; pass the look-up function of your context"};
    std::unique_ptr<Device> device(new Device);
    Api& gl = *device->api_;
    const int loaded = gladLoadGLContextUserPtr(&gl, proc_from, reinterpret_cast<void*>(get_proc));
    if (loaded == 0)
        return Error{ErrorCode::GlContext,
                     "no GL context is current on this thread (GL_VERSION cannot be read); make one current first"};
    const Version version{GLAD_VERSION_MAJOR(loaded), GLAD_VERSION_MINOR(loaded)};
    if (version < Version{3, 3})
        return Error{ErrorCode::GlContext,
                     text("the GL context is ", string_of(gl, GL_VERSION), " on ", string_of(gl, GL_RENDERER),
                          "; tilth needs 3.3 core: ask for a 3.3 core profile when creating the context, or update "
                          "the driver")};
    // A table may have holes when get_proc belongs to another library than the context.
    if (gl.DrawElementsInstanced == nullptr || gl.BindSampler == nullptr || gl.VertexAttribDivisor == nullptr ||
        gl.FenceSync == nullptr || gl.TexBuffer == nullptr)
        return Error{ErrorCode::GlContext, text("GL ", string_of(gl, GL_VERSION),
                                                " lacks functions of 3.3; get_proc must be that of the library which "
                                                "made the context")};
    device->capabilities_ = capabilities_of(gl);
    device->quirks_ = quirks_of(device->capabilities_.vendor, device->capabilities_.renderer);
    if (options.collect_debug_messages) {
        if (!device->capabilities_.debug)
            return Error{ErrorCode::Unsupported,
                         "collect_debug_messages: the context lacks GL_KHR_debug and has no messages to collect"};
        device->install_debug_callback();
    }
    return device;
}

void Device::install_debug_callback() {
    const Api& gl = *api_;
    host_debug_ = std::make_unique<HostDebug>();
    gl.GetPointerv(GL_DEBUG_CALLBACK_FUNCTION, &host_debug_->callback);
    gl.GetPointerv(GL_DEBUG_CALLBACK_USER_PARAM, &host_debug_->user);
    host_debug_->output = gl.IsEnabled(GL_DEBUG_OUTPUT) != 0;
    host_debug_->synchronous = gl.IsEnabled(GL_DEBUG_OUTPUT_SYNCHRONOUS) != 0;
    gl.DebugMessageCallback(on_debug_message, this);
    gl.Enable(GL_DEBUG_OUTPUT);
    gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
}

void Device::remove_debug_callback() {
    const Api& gl = *api_;
    gl.DebugMessageCallback(reinterpret_cast<GLDEBUGPROC>(host_debug_->callback), host_debug_->user);
    if (!host_debug_->output) gl.Disable(GL_DEBUG_OUTPUT);
    if (!host_debug_->synchronous) gl.Disable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
}

void Device::add_message(DebugMessage message) {
    if (messages_.size() < kMaxDebugMessages)
        messages_.push_back(std::move(message));
    else
        ++dropped_messages_;
}

std::vector<DebugMessage> Device::take_debug_messages() {
    std::vector<DebugMessage> taken = std::move(messages_);
    messages_.clear();
    if (dropped_messages_ > 0)
        taken.push_back({DebugSeverity::Low, 0, "other", text(dropped_messages_, " more messages were dropped")});
    dropped_messages_ = 0;
    return taken;
}

unsigned Device::next_error() { return api_->GetError(); }

void Device::set_aside_errors() {
    // A lost context may answer for ever: sixteen is more flags than any implementation has.
    for (int i = 0; i < 16; ++i) {
        const unsigned error = next_error();
        if (error == GL_NO_ERROR) return;
        errors_set_aside_.push_back(error_name(error));
    }
}

std::vector<std::string> Device::take_errors() {
    set_aside_errors();
    std::vector<std::string> taken = std::move(errors_set_aside_);
    errors_set_aside_.clear();
    return taken;
}

void Device::label(unsigned gl_namespace, unsigned id, std::string_view label_text) {
    if (!capabilities_.debug) return;
    // 256 is the least GL_MAX_LABEL_LENGTH, terminator included.
    const std::size_t length = std::min<std::size_t>(label_text.size(), 255);
    api_->ObjectLabel(gl_namespace, id, static_cast<GLsizei>(length), label_text.data());
}

void Device::add_live(ObjectKind kind, unsigned id, std::uint64_t bytes, std::string_view label_text) {
    live_.push_back({kind, id, bytes, std::string(label_text)});
    resident_bytes_ += bytes;
}

void Device::resize_live(ObjectKind kind, unsigned id, std::uint64_t bytes) {
    for (LiveObject& object : live_) {
        if (object.kind != kind || object.id != id) continue;
        resident_bytes_ += bytes - object.bytes;
        object.bytes = bytes;
        return;
    }
}

void Device::remove_live(ObjectKind kind, unsigned id) {
    const auto found = std::find_if(live_.begin(), live_.end(),
                                    [&](const LiveObject& object) { return object.kind == kind && object.id == id; });
    TILTH_ASSERT(found != live_.end(), "a GL object is deleted twice, or was not registered");
    resident_bytes_ -= found->bytes;
    *found = std::move(live_.back());
    live_.pop_back();
}

Error out_of_memory(const char* what, std::string_view label, std::uint64_t bytes, unsigned gl_error) {
    return {ErrorCode::OutOfMemory, text(what, " \"", label, "\": the driver refused ", bytes, " bytes (",
                                         error_name(gl_error), "); use fewer or smaller tiles")};
}

}  // namespace tilth::gl
