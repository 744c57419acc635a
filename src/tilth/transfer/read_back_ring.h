// Texels on their way back: a ring of pixel buffers, each closed by its fence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/objects.h"

namespace tilth {

/// Copies rectangles of textures into pixel buffers and hands the bytes over once their fence has passed. A buffer is
/// never mapped before that. Never waits in `begin` and `poll`; software GL itself waits in glReadPixels for the draws
/// before it (`gl::Quirks::readback_waits`), which no order of calls can avoid.
/// The mapped bytes are copied once more before they are handed over: only the unmapping tells whether the driver kept
/// them, and nobody shall see bytes that it lost.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class ReadBackRing {
public:
    /// `slots` buffers of `slot_bytes`, both at least 1; fails with InvalidArgument otherwise, or with OutOfMemory.
    static Result<ReadBackRing> create(gl::Device& device, std::size_t slot_bytes, int slots);

    /// One rectangle of level 0 of a texture that can be drawn to; not of a depth format.
    struct Piece {
        const gl::Texture2D* texture = nullptr;
        gl::Rect rect;
    };
    /// Starts copying `pieces`, one behind the other in the format's transfer layout, in all at least one texel and at
    /// most `slot_bytes`; GL wants each to start at a multiple of its component's size. Empty rectangles are skipped.
    /// The ticket, or nothing where no slot is free now. Attaching each new texture costs some ten microseconds.
    std::optional<std::uint64_t> begin(std::span<const Piece> pieces, gl::TransferStats& stats);

    enum class State : std::uint8_t { Pending, Done, Failed };
    /// Done: `take` was called with the bytes, the ticket is spent. Failed: the driver could not map the buffer or lost
    /// it, the ticket is spent, nothing was taken. Never waits. `take` must not call `poll`.
    State poll(std::uint64_t ticket, const std::function<void(std::span<const std::byte>)>& take);
    /// Gives a ticket up; its slot is free again once its fence has passed.
    void cancel(std::uint64_t ticket);

    [[nodiscard]] std::size_t slot_bytes() const { return slot_bytes_; }
    /// Of all slots together; the copy, one slot large, is client memory and does not count.
    [[nodiscard]] std::uint64_t bytes() const { return std::uint64_t{slot_bytes_} * slots_.size(); }

private:
    struct Slot {
        gl::Buffer buffer;
        std::optional<gl::Fence> in_flight;  ///< behind the copies into the buffer; none: the slot is free
        std::uint64_t ticket = 0;            ///< 0: nobody waits for the bytes
        std::size_t size = 0;
    };

    ReadBackRing(gl::Device& device, std::size_t slot_bytes, gl::Framebuffer framebuffer)
        : device_(&device), slot_bytes_(slot_bytes), framebuffer_(std::move(framebuffer)), copy_(slot_bytes) {}
    Slot* free_slot();
    Slot* slot_of(std::uint64_t ticket);

    gl::Device* device_;
    std::size_t slot_bytes_;
    gl::Framebuffer framebuffer_;  ///< attached to nothing between calls, else it would keep deleted textures alive
    std::vector<Slot> slots_;
    std::vector<std::byte> copy_;
    std::uint64_t last_ticket_ = 0;
};

}  // namespace tilth
