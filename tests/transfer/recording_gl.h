// A GL that watches: it passes every call on to the context's own functions, records those that matter to transfers,
// finds violations of their order, and injects faults. It comes in through the look-up function that a device is made
// from, so nothing in the library knows of it.
#pragma once

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "support/gl_context.h"

namespace tilth::test {

/// One at a time. The rules it watches:
///   - a buffer that texels are packed into is not mapped before a fence behind that was seen to have passed;
///   - a buffer that an upload reads is neither mapped nor (persistent) free to be written (`busy`) before that;
///   - nothing reads or writes a buffer that is mapped and not persistent;
///   - nothing waits: no glFinish, no timeout but 0, no glWaitSync, no call that reads into client memory.
class RecordingGl {
public:
    struct Settings {
        bool buffer_storage = true;  ///< false: the context says that it has no GL_ARB_buffer_storage
    };
    explicit RecordingGl(Settings settings) : settings_(settings) {
        if (current_ != nullptr) std::abort();
        current_ = this;
        device_ = value(gl::Device::create(&RecordingGl::look_up));
    }
    ~RecordingGl() {
        device_.reset();
        current_ = nullptr;
    }
    RecordingGl(const RecordingGl&) = delete;
    RecordingGl& operator=(const RecordingGl&) = delete;

    [[nodiscard]] gl::Device& device() { return *device_; }

    // ---- Faults: each counts down as it strikes.
    int maps_refused = 0;   ///< glMapBufferRange returns nullptr
    int contents_lost = 0;  ///< what is mapped next holds garbage, and its glUnmapBuffer returns false
    int polls_expired = 0;  ///< glClientWaitSync returns GL_TIMEOUT_EXPIRED

    // ---- What was seen.
    std::vector<std::string> calls;       ///< names of recorded calls, in order
    std::vector<std::string> violations;  ///< of the rules above

    [[nodiscard]] std::ptrdiff_t count(std::string_view name) const {
        return std::count(calls.begin(), calls.end(), name);
    }
    /// Whether `memory` lies in a mapped buffer that uploads may still read.
    [[nodiscard]] bool busy(const std::byte* memory) const {
        for (const auto& [id, mapping] : mapped_)
            if (memory >= mapping.memory && memory < mapping.memory + mapping.size) return users_.contains(id);
        return false;
    }

private:
    struct Mapping {
        const std::byte* memory = nullptr;
        std::size_t size = 0;
        bool persistent = false, writes = false, lost = false;
        std::vector<std::byte> garbage;
    };
    /// The commands that use a buffer: 0 while no fence stands behind them.
    using Users = std::map<GLuint, GLsync>;

    static gl::GetProc real_get_proc() { return test_context(default_route()).context->get_proc(); }
    template <class Function>
    static Function real(const char* name) {
        return reinterpret_cast<Function>(real_get_proc()(name));
    }
    static GLuint bound(GLenum target) {
        const GLenum binding = target == GL_PIXEL_PACK_BUFFER     ? GL_PIXEL_PACK_BUFFER_BINDING
                               : target == GL_PIXEL_UNPACK_BUFFER ? GL_PIXEL_UNPACK_BUFFER_BINDING
                               : target == GL_ARRAY_BUFFER        ? GL_ARRAY_BUFFER_BINDING
                                                                  : target;  // copy targets name their own binding
        GLint id = 0;
        real<PFNGLGETINTEGERVPROC>("glGetIntegerv")(binding, &id);
        return static_cast<GLuint>(id);
    }
    void violate(const std::string& what) { violations.push_back(what); }
    static bool strikes(int& fault) { return fault > 0 && fault-- > 0; }

    void use(const char* name, GLuint buffer) {
        const auto mapping = mapped_.find(buffer);
        if (mapping != mapped_.end() && !mapping->second.persistent)
            violate(text(name, " uses buffer ", buffer, " while it is mapped"));
        users_[buffer] = nullptr;
    }

    static void* GLAD_API_PTR map_buffer_range(GLenum target, GLintptr offset, GLsizeiptr size, GLbitfield access) {
        RecordingGl& self = *current_;
        self.calls.emplace_back("glMapBufferRange");
        const GLuint id = bound(target);
        if (self.users_.contains(id))
            self.violate(text("buffer ", id, " is mapped for ", (access & GL_MAP_READ_BIT) != 0 ? "reading" : "writing",
                              " before its fence has passed"));
        if (strikes(self.maps_refused)) return nullptr;
        void* memory = real<PFNGLMAPBUFFERRANGEPROC>("glMapBufferRange")(target, offset, size, access);
        Mapping mapping{static_cast<const std::byte*>(memory), static_cast<std::size_t>(size),
                        (access & GL_MAP_PERSISTENT_BIT) != 0, (access & GL_MAP_WRITE_BIT) != 0};
        if (!mapping.persistent && strikes(self.contents_lost)) {
            mapping.lost = true;
            mapping.garbage.assign(mapping.size, std::byte{0xee});
            if (mapping.writes) std::memset(memory, 0xee, mapping.size);
            memory = mapping.garbage.data();  // stays where it is when the vector moves
        }
        self.mapped_[id] = std::move(mapping);
        return memory;
    }
    static GLboolean GLAD_API_PTR unmap_buffer(GLenum target) {
        RecordingGl& self = *current_;
        self.calls.emplace_back("glUnmapBuffer");
        const auto mapping = self.mapped_.find(bound(target));
        const bool lost = mapping != self.mapped_.end() && mapping->second.lost;
        if (mapping == self.mapped_.end())
            self.violate("a buffer is unmapped that is not mapped");
        else
            self.mapped_.erase(mapping);
        const GLboolean kept = real<PFNGLUNMAPBUFFERPROC>("glUnmapBuffer")(target);
        return lost ? GL_FALSE : kept;
    }
    static void GLAD_API_PTR delete_buffers(GLsizei count, const GLuint* ids) {
        for (GLsizei i = 0; i < count; ++i) current_->mapped_.erase(ids[i]), current_->users_.erase(ids[i]);
        real<PFNGLDELETEBUFFERSPROC>("glDeleteBuffers")(count, ids);
    }
    static GLsync GLAD_API_PTR fence_sync(GLenum condition, GLbitfield flags) {
        RecordingGl& self = *current_;
        self.calls.emplace_back("glFenceSync");
        const GLsync sync = real<PFNGLFENCESYNCPROC>("glFenceSync")(condition, flags);
        for (auto& [buffer, fence] : self.users_)
            if (fence == nullptr) fence = sync;
        return sync;
    }
    static GLenum GLAD_API_PTR client_wait_sync(GLsync sync, GLbitfield flags, GLuint64 timeout_ns) {
        RecordingGl& self = *current_;
        self.calls.emplace_back("glClientWaitSync");
        if (timeout_ns != 0) self.violate(text("glClientWaitSync waits ", timeout_ns, " ns"));
        if (self.flushed_.insert(sync).second != ((flags & GL_SYNC_FLUSH_COMMANDS_BIT) != 0))
            self.violate("the first poll of a fence flushes, and no other does");
        if (strikes(self.polls_expired)) return GL_TIMEOUT_EXPIRED;
        const GLenum status = real<PFNGLCLIENTWAITSYNCPROC>("glClientWaitSync")(sync, flags, timeout_ns);
        if (status == GL_ALREADY_SIGNALED || status == GL_CONDITION_SATISFIED)
            std::erase_if(self.users_, [&](const auto& user) { return user.second == sync; });
        return status;
    }
    static void GLAD_API_PTR delete_sync(GLsync sync) {
        current_->flushed_.erase(sync);
        real<PFNGLDELETESYNCPROC>("glDeleteSync")(sync);
    }
    static void GLAD_API_PTR read_pixels(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,
                                         void* pixels) {
        RecordingGl& self = *current_;
        self.calls.emplace_back("glReadPixels");
        const GLuint buffer = bound(GL_PIXEL_PACK_BUFFER);
        if (buffer == 0) return self.violate("glReadPixels into client memory waits");
        self.use("glReadPixels", buffer);
        real<PFNGLREADPIXELSPROC>("glReadPixels")(x, y, width, height, format, type, pixels);
    }
    static void GLAD_API_PTR tex_sub_image(GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height,
                                           GLenum format, GLenum type, const void* pixels) {
        RecordingGl& self = *current_;
        self.calls.emplace_back("glTexSubImage2D");
        if (const GLuint buffer = bound(GL_PIXEL_UNPACK_BUFFER); buffer != 0) self.use("glTexSubImage2D", buffer);
        real<PFNGLTEXSUBIMAGE2DPROC>("glTexSubImage2D")(target, level, x, y, width, height, format, type, pixels);
    }
    static void GLAD_API_PTR finish() { current_->violate("glFinish waits"); }
    static void GLAD_API_PTR wait_sync(GLsync, GLbitfield, GLuint64) { current_->violate("glWaitSync"); }
    static void GLAD_API_PTR get_buffer_sub_data(GLenum, GLintptr, GLsizeiptr, void*) {
        current_->violate("glGetBufferSubData waits");
    }
    static void GLAD_API_PTR get_tex_image(GLenum, GLint, GLenum, GLenum, void*) {
        current_->violate("glGetTexImage waits");
    }
    static void* GLAD_API_PTR map_buffer(GLenum, GLenum) {
        current_->violate("glMapBuffer waits");
        return nullptr;
    }
    static const GLubyte* GLAD_API_PTR get_string_i(GLenum name, GLuint index) {
        const GLubyte* answer = real<PFNGLGETSTRINGIPROC>("glGetStringi")(name, index);
        const bool hide = name == GL_EXTENSIONS && !current_->settings_.buffer_storage && answer != nullptr &&
                          std::string_view(reinterpret_cast<const char*>(answer)) == "GL_ARB_buffer_storage";
        return hide ? reinterpret_cast<const GLubyte*>("GL_TILTH_hidden") : answer;
    }

    static void* look_up(const char* name) {
        const std::pair<std::string_view, void*> watched[] = {
            {"glMapBufferRange", reinterpret_cast<void*>(&map_buffer_range)},
            {"glUnmapBuffer", reinterpret_cast<void*>(&unmap_buffer)},
            {"glDeleteBuffers", reinterpret_cast<void*>(&delete_buffers)},
            {"glFenceSync", reinterpret_cast<void*>(&fence_sync)},
            {"glClientWaitSync", reinterpret_cast<void*>(&client_wait_sync)},
            {"glDeleteSync", reinterpret_cast<void*>(&delete_sync)},
            {"glReadPixels", reinterpret_cast<void*>(&read_pixels)},
            {"glTexSubImage2D", reinterpret_cast<void*>(&tex_sub_image)},
            {"glFinish", reinterpret_cast<void*>(&finish)},
            {"glWaitSync", reinterpret_cast<void*>(&wait_sync)},
            {"glGetBufferSubData", reinterpret_cast<void*>(&get_buffer_sub_data)},
            {"glGetTexImage", reinterpret_cast<void*>(&get_tex_image)},
            {"glMapBuffer", reinterpret_cast<void*>(&map_buffer)},
            {"glGetStringi", reinterpret_cast<void*>(&get_string_i)},
        };
        for (const auto& [watched_name, function] : watched)
            if (watched_name == name) return function;
        return real_get_proc()(name);
    }

    static inline RecordingGl* current_ = nullptr;
    Settings settings_;
    std::unique_ptr<gl::Device> device_;
    std::map<GLuint, Mapping> mapped_;
    Users users_;
    std::set<GLsync> flushed_;
};

}  // namespace tilth::test
