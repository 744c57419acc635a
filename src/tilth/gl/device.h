// The current GL context as the library sees it: function table, facts asked for once, messages, live objects.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/api_fwd.h"
#include "tilth/gl/get_proc.h"
#include "tilth/gl/quirks.h"

namespace tilth::gl {

struct Version {
    int major = 0, minor = 0;
    friend auto operator<=>(const Version&, const Version&) = default;
};

/// What the context can do beyond GL 3.3 core, and its limits. Asked for once, when the device is created.
struct Capabilities {
    Version version;
    std::string vendor, renderer, version_text;
    int max_texture_size = 0;  ///< texels a side
    int max_array_layers = 0;
    int max_buffer_texels = 0;  ///< of a buffer texture
    int max_uniform_block_bytes = 0;
    int max_vertex_textures = 0;  ///< texture units a vertex shader may read
    int max_texture_units = 0;    ///< of all shader stages together
    int max_colour_attachments = 0;
    int max_geometry_vertices = 0;
    int max_patch_vertices = 0;      ///< 0 without tessellation
    int max_tessellation_level = 0;  ///< 0 without tessellation
    float max_anisotropy = 1;        ///< 1 without the extension
    int timer_query_bits = 0;        ///< 0: no timer queries; see also `Quirks::timer_queries_lie`
    bool debug = false;              ///< labels, groups, messages (GL_KHR_debug)
    bool buffer_storage = false;
    bool clip_control = false;
    bool copy_image = false;
    bool texture_barrier = false;
    bool pipeline_statistics = false;
    bool tessellation = false;
    bool viewport_array = false;
    bool draw_buffers_blend = false;
    bool fixed_index_restart = false;     ///< GL_PRIMITIVE_RESTART_FIXED_INDEX exists
    std::vector<std::string> extensions;  ///< sorted

    /// Whether the context advertises `name`, e.g. "GL_ARB_sparse_texture". A non-null entry point proves nothing.
    [[nodiscard]] bool has_extension(std::string_view name) const;
};

enum class DebugSeverity { Low, Medium, High };

/// A message of the driver (GL_KHR_debug), without notifications.
struct DebugMessage {
    DebugSeverity severity = DebugSeverity::Low;
    std::uint32_t id = 0;
    std::string kind;  ///< "error", "deprecated", "undefined", "portability", "performance", "other"
    std::string text;
};

struct DeviceOptions {
    /// Installs a synchronous debug callback for as long as the device lives, and puts the host's back afterwards.
    /// For tests and debugging: a context has only one callback, so a host that has its own keeps it by default.
    bool collect_debug_messages = false;
};

enum class ObjectKind { Texture, Buffer, VertexArray, Framebuffer, Program, Query };

/// A GL object that the library owns now, for leak reports and for `resident.gpu_bytes`.
struct LiveObject {
    ObjectKind kind = ObjectKind::Texture;
    unsigned id = 0;
    std::uint64_t bytes = 0;
    std::string label;
};

/// The context that every GL class works on. All of them keep a reference, so it must outlive them: destroying it
/// first is reported as a leak, with labels.
///
/// Thread: the one that owns the context, for every member. Creation reads state and, unless asked to collect debug
/// messages, changes none. The context must be current whenever the device or anything made from it is used.
class Device {
public:
    /// Loads the function table through `get_proc` from the context that is current on this thread.
    /// Fails with `ErrorCode::GlContext` below GL 3.3, without the core profile's functions, or with no context, and
    /// with `Unsupported` when messages are asked for that the context cannot give.
    static Result<std::unique_ptr<Device>> create(GetProc get_proc, DeviceOptions options = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    [[nodiscard]] const Api& gl() const { return *api_; }
    [[nodiscard]] const Capabilities& capabilities() const { return capabilities_; }
    [[nodiscard]] const Quirks& quirks() const { return quirks_; }

    /// Messages since the last `take_debug_messages()`; at most `kMaxDebugMessages`, the rest are only counted.
    static constexpr std::size_t kMaxDebugMessages = 256;
    [[nodiscard]] const std::vector<DebugMessage>& debug_messages() const { return messages_; }
    std::vector<DebugMessage> take_debug_messages();

    /// Drains glGetError: the names of all pending errors, oldest first, including those set aside by creations that
    /// had to look for their own. May stall a threaded driver; not for every frame.
    std::vector<std::string> take_errors();

    [[nodiscard]] const std::vector<LiveObject>& live_objects() const { return live_; }
    /// Bytes of all live textures and buffers, as computed from their formats and sizes.
    [[nodiscard]] std::uint64_t resident_bytes() const { return resident_bytes_; }

    // For the classes of objects.h.
    void set_aside_errors();
    [[nodiscard]] unsigned next_error();
    void label(unsigned gl_namespace, unsigned id, std::string_view text);
    void add_live(ObjectKind kind, unsigned id, std::uint64_t bytes, std::string_view label);
    void resize_live(ObjectKind kind, unsigned id, std::uint64_t bytes);
    void remove_live(ObjectKind kind, unsigned id);
    [[nodiscard]] std::uint64_t next_serial() { return ++serial_; }
    void add_message(DebugMessage message);

private:
    Device();
    void install_debug_callback();
    void remove_debug_callback();

    std::unique_ptr<Api> api_;
    Capabilities capabilities_;
    Quirks quirks_;
    std::vector<DebugMessage> messages_;
    std::uint64_t dropped_messages_ = 0;
    std::vector<std::string> errors_set_aside_;
    std::vector<LiveObject> live_;
    std::uint64_t resident_bytes_ = 0;
    std::uint64_t serial_ = 0;

    struct HostDebug;
    std::unique_ptr<HostDebug> host_debug_;  ///< the host's callback and switches while ours is installed
};

/// "GL_INVALID_OPERATION" for 0x0502, and so on.
std::string error_name(unsigned gl_error);

/// What creating `label` reports when GL refuses `bytes` bytes.
Error out_of_memory(const char* what, std::string_view label, std::uint64_t bytes, unsigned gl_error);

}  // namespace tilth::gl
