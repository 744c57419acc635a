// Bytes on their way to textures: a ring of pixel buffers, each closed by its fence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/objects.h"

namespace tilth {

/// Memory that the GPU copies from. A slot is written by the CPU, read by texture uploads, closed by a fence, and not
/// given out again before that fence has passed. Never waits: with all slots in flight, or where the driver refuses to
/// map one, `begin` gives nothing and the caller tries again next frame. Slots are used in order, so only the oldest
/// fence is ever asked for.
/// With GL_ARB_buffer_storage the slots are mapped once, persistently and coherently; otherwise mapped unsynchronised
/// for each use. Upload into textures that no queued draw reads, or before the frame's first draw: software GL waits
/// for the draw otherwise.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
///
///     if (auto bytes = ring.begin(size)) {                    // write them, then
///         ring.to_texture(texture, 0, rect, offset, stats);   // as often as needed
///         ring.end();
///     }
class UploadRing {
public:
    /// `slots` buffers of `slot_bytes`, both at least 1; fails with InvalidArgument otherwise, or with OutOfMemory.
    /// A driver that has persistent mapping and yet refuses one gets the other kind, with a warning in the log.
    static Result<UploadRing> create(gl::Device& device, std::size_t slot_bytes, int slots);

    /// `size` bytes of the next slot, 0 < size <= slot_bytes; empty optional: not now. The memory may be
    /// write-combined: write it once, front to back, and do not read it. What it held before is undefined. Close it
    /// with `end`.
    std::optional<std::span<std::byte>> begin(std::size_t size);
    /// Uploads `rect` of `level` from `offset_bytes` of the slot, rows one behind the other in the format's transfer
    /// layout; GL wants `offset_bytes` to be a multiple of a component's size. After the last byte was written: before
    /// the first of these the memory is unmapped where it is not persistent, and the span of `begin` is dead.
    /// False: the driver lost the content; nothing of it was uploaded, try again next frame.
    bool to_texture(gl::Texture2D& texture, int level, const gl::Rect& rect, std::size_t offset_bytes,
                    gl::TransferStats& stats);
    /// Closes the slot of the last `begin`. One that uploaded nothing is free again at once.
    void end();

    [[nodiscard]] std::size_t slot_bytes() const { return slot_bytes_; }
    [[nodiscard]] bool persistent() const { return slots_.front().buffer.mapped() != nullptr; }
    /// Of all slots together.
    [[nodiscard]] std::uint64_t bytes() const { return std::uint64_t{slot_bytes_} * slots_.size(); }

private:
    struct Slot {
        gl::Buffer buffer;
        std::optional<gl::Fence> in_flight;  ///< behind the last upload that reads the slot
    };
    /// Of the slot between `begin` and `end`.
    enum class Open : std::uint8_t {
        No,
        Mapped,     ///< by `begin`, to be unmapped
        Readable,   ///< GL may read it, nothing does yet
        BeingRead,  ///< by uploads
        Lost,
    };

    UploadRing() = default;
    Result<void> make_slots(gl::Device& device, int slots, bool persistent);
    void make_readable();

    gl::Device* device_ = nullptr;
    std::size_t slot_bytes_ = 0;
    std::vector<Slot> slots_;
    std::size_t next_ = 0;  ///< the slot that is open or will be opened next; also the oldest in flight
    Open open_ = Open::No;
    std::size_t open_bytes_ = 0;
};

}  // namespace tilth
