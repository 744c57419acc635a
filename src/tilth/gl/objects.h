// GL objects as move-only members: each has one owner, one label, and dies with its owner.
//
// Threads: the one that owns the context. GL state: every member may change bindings (texture unit 0, copy buffers,
// pixel store, ...), all of them in `kTouchedState`; callers that must keep the host's state hold a `StateGuard`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/format.h"

namespace tilth::gl {

/// Pixels of one level of a texture, half-open: `min` belongs to it, `max` does not. y is GL's row, the library's z.
struct Rect {
    std::int32_t min_x = 0, min_y = 0, max_x = 0, max_y = 0;

    [[nodiscard]] constexpr std::int32_t width() const { return max_x > min_x ? max_x - min_x : 0; }
    [[nodiscard]] constexpr std::int32_t height() const { return max_y > min_y ? max_y - min_y : 0; }
    [[nodiscard]] constexpr bool empty() const { return width() == 0 || height() == 0; }
    [[nodiscard]] constexpr std::int64_t count() const { return std::int64_t{width()} * height(); }
    friend bool operator==(const Rect&, const Rect&) = default;
};

namespace detail {
/// A GL name and its device; zero when moved from.
class Handle {
public:
    Handle() = default;
    Handle(Device& device, ObjectKind kind, unsigned id) : device_(&device), id_(id), kind_(kind) {}
    ~Handle() { reset(); }
    Handle(Handle&& other) noexcept;
    Handle& operator=(Handle&& other) noexcept;
    [[nodiscard]] unsigned id() const { return id_; }
    [[nodiscard]] Device& device() const { return *device_; }
    [[nodiscard]] const Api& gl() const { return device_->gl(); }
    [[nodiscard]] bool valid() const { return id_ != 0; }
    void reset();

private:
    Device* device_ = nullptr;
    unsigned id_ = 0;
    ObjectKind kind_ = ObjectKind::Texture;
};
}  // namespace detail

class Buffer;

enum class Filter {
    Nearest,
    Linear,
    NearestMipNearest,  ///< nearest texel of the nearest level
    LinearMipNearest,   ///< linear within the nearest level
    Trilinear,          ///< linear within and between levels
};
enum class Wrap { ClampToEdge, Repeat, MirroredRepeat };

struct TextureSpec {
    Format format = Format::Rgba8;
    int width = 1, height = 1;  ///< texels of level 0
    int levels = 1;             ///< 1 to 1 + log2 of the larger side; 0 means all of them
    Filter filter = Filter::Nearest;
    Wrap wrap = Wrap::ClampToEdge;
};

/// A 2D texture whose levels are all allocated at creation. Content is undefined until written.
class Texture2D {
public:
    /// Fails with InvalidArgument (a size over the driver's limit, levels that do not exist, linear filtering of an
    /// integer format) or OutOfMemory.
    static Result<Texture2D> create(Device& device, std::string_view label, const TextureSpec& spec);

    [[nodiscard]] unsigned id() const { return handle_.id(); }
    [[nodiscard]] int width() const { return spec_.width; }
    [[nodiscard]] int height() const { return spec_.height; }
    [[nodiscard]] int width(int level) const { return spec_.width >> level > 0 ? spec_.width >> level : 1; }
    [[nodiscard]] int height(int level) const { return spec_.height >> level > 0 ? spec_.height >> level : 1; }
    [[nodiscard]] int levels() const { return spec_.levels; }
    [[nodiscard]] Format format() const { return spec_.format; }
    [[nodiscard]] Rect bounds(int level = 0) const { return {0, 0, width(level), height(level)}; }
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
    /// Differs between all textures ever made by a device, unlike GL's id, which is used again.
    [[nodiscard]] std::uint64_t serial() const { return serial_; }

    /// Writes `rect` of `level` from client memory in the format's transfer layout (`info_of`).
    /// `row_texels` is the distance between two rows of `texels`; 0 means the width of `rect`.
    void upload(int level, const Rect& rect, const void* texels, int row_texels = 0);
    /// The same from a buffer, starting at `offset_bytes` in it; does not wait for the copy.
    void upload(int level, const Rect& rect, const Buffer& source, std::size_t offset_bytes, int row_texels = 0);
    /// Reads a whole level in the transfer layout. Waits for the GPU: tests, dumps and saves at rest only.
    void read(int level, void* texels) const;
    void set_filter(Filter filter);
    /// Shows samplers the levels `base` to `max` only, both included; 0 to levels() - 1 is all of them, as at creation.
    /// A pass may then write a level below `base` or above the one that is sampled. texelFetch counts its level from
    /// `base`.
    void set_level_range(int base, int max);
    /// Binds to `unit`, without a sampler object: the texture's own filter and wrap hold.
    void bind(int unit) const;

private:
    Texture2D() = default;
    detail::Handle handle_;
    TextureSpec spec_;
    std::uint64_t bytes_ = 0, serial_ = 0;
};

enum class BufferUsage { Static, Dynamic, Stream, ReadBack };

/// What a buffer is bound as.
enum class BufferTarget { Vertex, Uniform, PixelUnpack, PixelPack };

class Buffer {
public:
    /// Content is undefined unless `initial` points to `bytes` bytes. Fails with OutOfMemory.
    static Result<Buffer> create(Device& device, std::string_view label, std::size_t bytes,
                                 BufferUsage usage = BufferUsage::Static, const void* initial = nullptr);
    /// A buffer of fixed size whose memory stays mapped for writing (`mapped`) while GL reads from it; what is written
    /// there is seen by every later command, without a call. The caller knows by a fence that no command still reads
    /// what it overwrites. `upload`, `replace`, `read` and the other maps are not allowed on it. Fails with Unsupported
    /// without `Capabilities::buffer_storage`, with OutOfMemory where the driver refuses the memory or the mapping.
    static Result<Buffer> create_persistent(Device& device, std::string_view label, std::size_t bytes);

    [[nodiscard]] unsigned id() const { return handle_.id(); }
    [[nodiscard]] std::size_t bytes() const { return bytes_; }
    /// All bytes of a persistent buffer; nullptr of any other.
    [[nodiscard]] std::byte* mapped() const { return mapped_; }

    void upload(std::size_t offset_bytes, std::span<const std::byte> data);
    /// Gives the buffer new memory of at least `data` (doubling when it grows) and writes `data` at its start. Does
    /// not wait for draws that still read the old content.
    void replace(std::span<const std::byte> data);
    void read(std::size_t offset_bytes, std::span<std::byte> data) const;  ///< waits
    void bind(BufferTarget target) const;
    void bind_uniform(int binding) const;  ///< the whole buffer, to an indexed uniform binding below 8
    void bind_uniform(int binding, std::size_t offset_bytes, std::size_t size_bytes) const;

    /// Memory of the buffer for reading, valid until `unmap`; nullptr if the driver refuses. Waits unless every
    /// command that writes the range is known by a fence to be done.
    const std::byte* map_read(std::size_t offset_bytes, std::size_t size_bytes);
    /// Memory for writing the range, whose old content is lost; not synchronised: the caller knows by a fence that
    /// no command reads it any more.
    std::byte* map_write(std::size_t offset_bytes, std::size_t size_bytes);
    /// False if the driver lost the content while it was mapped.
    bool unmap();

private:
    Buffer() = default;
    detail::Handle handle_;
    std::size_t bytes_ = 0;
    unsigned usage_ = 0;
    std::byte* mapped_ = nullptr;  ///< persistently
};

/// A buffer read by shaders as `samplerBuffer` (or `isamplerBuffer`, ...), texel by texel.
class TextureBuffer {
public:
    static Result<TextureBuffer> create(Device& device, std::string_view label, Format format, std::size_t texels,
                                        BufferUsage usage = BufferUsage::Dynamic, const void* initial = nullptr);

    [[nodiscard]] unsigned id() const { return texture_.id(); }
    [[nodiscard]] Buffer& buffer() { return buffer_; }
    [[nodiscard]] std::size_t texels() const { return buffer_.bytes() / static_cast<std::size_t>(texel_bytes_); }
    [[nodiscard]] std::uint64_t bytes() const { return buffer_.bytes(); }
    void upload(std::size_t offset_bytes, std::span<const std::byte> data) { buffer_.upload(offset_bytes, data); }
    /// As `Buffer::replace`; the texture sees the new memory.
    void replace(std::span<const std::byte> data);
    void bind(int unit) const;

private:
    TextureBuffer(Buffer buffer) : buffer_(std::move(buffer)) {}
    Buffer buffer_;
    detail::Handle texture_;
    unsigned internal_format_ = 0;
    int texel_bytes_ = 1;
};

enum class AttributeType { Float, HalfFloat, Int, UInt, Short, UShort, Byte, UByte };

class VertexArray {
public:
    static Result<VertexArray> create(Device& device, std::string_view label);

    [[nodiscard]] unsigned id() const { return handle_.id(); }
    void bind() const;
    /// A floating-point input; integer types are converted, to [0, 1] or [-1, 1] if `normalized`.
    /// `divisor` 0 advances per vertex, n per n instances. Changes the vertex-array and array-buffer bindings.
    void float_attribute(int location, const Buffer& buffer, int components, AttributeType type, int stride_bytes,
                         std::size_t offset_bytes, int divisor = 0, bool normalized = false);
    /// An integer input (`int`, `ivec4`, `uvec2`, ...).
    void int_attribute(int location, const Buffer& buffer, int components, AttributeType type, int stride_bytes,
                       std::size_t offset_bytes, int divisor = 0);
    void index_buffer(const Buffer& buffer);

private:
    VertexArray() = default;
    detail::Handle handle_;
};

class Framebuffer {
public:
    static Result<Framebuffer> create(Device& device, std::string_view label);

    [[nodiscard]] unsigned id() const { return handle_.id(); }
    /// Attaches `level` of each texture as colour attachment 0, 1, ... and draws to all of them; binds for drawing
    /// and reading. Attachments left from before are removed. Costs some ten microseconds when something changes.
    void attach(std::span<const Texture2D* const> colours, int level = 0, const Texture2D* depth = nullptr);
    /// Fails with `Unsupported`, naming the label and GL's reason, if the attachments cannot be drawn to.
    [[nodiscard]] Result<void> check() const;
    void bind() const;       ///< for drawing and reading
    void bind_read() const;  ///< for reading (copies), from colour attachment 0
    /// Reads `rect` of colour attachment `attachment` in the transfer layout of `format`. Waits; for tests and dumps.
    void read(const Rect& rect, Format format, void* texels, int attachment = 0) const;

private:
    Framebuffer() = default;
    detail::Handle handle_;
    std::array<std::uint64_t, 8> attached_{};  ///< serials
    std::uint64_t depth_attached_ = 0;
    int level_ = -1;
    int colours_ = -1;
};

/// A uniform of one program, looked up once and kept; stays valid when the program is reloaded.
struct Uniform {
    int index = -1;
};

/// What a program was made from, so that it can be made again.
struct ProgramRecipe {
    std::string label, vertex, geometry, tess_control, tess_evaluation, fragment;
    std::vector<std::pair<std::string, std::string>> features;
    std::vector<std::string> feedback;
};

/// A linked program. Made by `ShaderLibrary`.
///
/// Uniforms: look up once after creation, then `set` while the program is bound. A uniform that the shader does not
/// use is silently skipped, as GL does. Sampler units and block bindings are set once and survive a reload.
class Program {
public:
    [[nodiscard]] unsigned id() const { return handle_.id(); }
    [[nodiscard]] const std::string& label() const { return recipe_.label; }
    [[nodiscard]] const ProgramRecipe& recipe() const { return recipe_; }
    /// Goes up by one with every successful reload.
    [[nodiscard]] int generation() const { return generation_; }

    void bind() const;
    [[nodiscard]] Uniform uniform(std::string_view name);
    /// Reads texture unit `unit` through the sampler called `name`. Binds the program.
    void sampler(std::string_view name, int unit);
    /// Reads the uniform block called `name` from indexed binding `binding`.
    void uniform_block(std::string_view name, int binding);

    // The program must be bound.
    void set(Uniform u, int x) const;
    void set(Uniform u, unsigned x) const;
    void set(Uniform u, float x) const;
    void set(Uniform u, int x, int y) const;
    void set(Uniform u, int x, int y, int z, int w) const;
    void set(Uniform u, float x, float y) const;
    void set(Uniform u, float x, float y, float z) const;
    void set(Uniform u, float x, float y, float z, float w) const;
    void set_ivec4s(Uniform u, std::span<const std::int32_t> values) const;  ///< an array; four values each
    void set_mat4(Uniform u, const float* column_major) const;

private:
    friend class ShaderLibrary;
    Program(Device& device, ProgramRecipe recipe, unsigned id);
    /// Takes over a newly linked GL program and looks everything up again.
    void adopt(unsigned id);
    [[nodiscard]] int location(Uniform u) const { return locations_[static_cast<std::size_t>(u.index)]; }

    detail::Handle handle_;
    ProgramRecipe recipe_;
    int generation_ = 0;
    std::vector<std::string> names_;
    std::vector<int> locations_;
    std::vector<std::pair<std::string, int>> samplers_, blocks_;
};

enum class QueryKind { TimeElapsed, SamplesPassed, PrimitivesGenerated, VertexInvocations };

class Query {
public:
    /// Fails with `Unsupported` if the context lacks the kind.
    static Result<Query> create(Device& device, std::string_view label, QueryKind kind);
    void begin();
    void end();
    [[nodiscard]] bool available() const;        ///< never waits
    [[nodiscard]] std::uint64_t result() const;  ///< waits until available

private:
    Query() = default;
    detail::Handle handle_;
    unsigned target_ = 0;
};

/// Passed when every command issued before it is done.
class Fence {
public:
    static Fence insert(Device& device);
    ~Fence();
    Fence(Fence&& other) noexcept;
    Fence& operator=(Fence&& other) noexcept;

    /// Never waits. Flushes on the first call, so that a poll once a frame comes to an end.
    [[nodiscard]] bool signaled();
    /// Waits at most `timeout_ns`; true if passed. Not for frames.
    bool wait(std::uint64_t timeout_ns);

private:
    Fence(Device& device, void* sync) : device_(&device), sync_(sync) {}
    Device* device_ = nullptr;
    void* sync_ = nullptr;
    bool flushed_ = false, passed_ = false;
};

}  // namespace tilth::gl
