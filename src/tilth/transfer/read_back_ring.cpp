#include "tilth/transfer/read_back_ring.h"

#include <cstring>

#include "tilth/gl/api.h"
#include "tilth/gl/offset_pointer.h"
#include "tilth/gl/pixel_store.h"

namespace tilth {
namespace {

std::size_t bytes_of(const ReadBackRing::Piece& piece) {
    const gl::FormatInfo& format = gl::info_of(piece.texture->format());
    return static_cast<std::size_t>(piece.rect.count()) * static_cast<std::size_t>(format.transfer_bytes);
}

}  // namespace

Result<ReadBackRing> ReadBackRing::create(gl::Device& device, std::size_t slot_bytes, int slots) {
    if (slot_bytes == 0 || slots < 1)
        return Error{ErrorCode::InvalidArgument,
                     text("read-back ring: has ", slots, " slots of ", slot_bytes, " bytes, each must be at least 1")};
    Result<gl::Framebuffer> framebuffer = gl::Framebuffer::create(device, "read-back ring");
    if (!framebuffer) return framebuffer.error();
    ReadBackRing ring(device, slot_bytes, *std::move(framebuffer));
    for (int i = 0; i < slots; ++i) {
        Result<gl::Buffer> buffer =
            gl::Buffer::create(device, text("read-back ring, slot ", i), slot_bytes, gl::BufferUsage::ReadBack);
        if (!buffer) return buffer.error();
        ring.slots_.push_back({*std::move(buffer), std::nullopt, 0, 0});
    }
    return ring;
}

ReadBackRing::Slot* ReadBackRing::free_slot() {
    for (Slot& slot : slots_) {
        if (slot.ticket != 0) continue;
        if (slot.in_flight && !slot.in_flight->signaled()) continue;  // cancelled, and GL still writes it
        slot.in_flight.reset();
        return &slot;
    }
    return nullptr;
}

ReadBackRing::Slot* ReadBackRing::slot_of(std::uint64_t ticket) {
    for (Slot& slot : slots_)
        if (slot.ticket == ticket && ticket != 0) return &slot;
    return nullptr;
}

std::optional<std::uint64_t> ReadBackRing::begin(std::span<const Piece> pieces, gl::TransferStats& stats) {
    std::size_t size = 0;
    for (const Piece& piece : pieces) size += bytes_of(piece);
    TILTH_ASSERT(size > 0 && size <= slot_bytes_, text("read-back of ", size, " bytes in slots of ", slot_bytes_));
    Slot* slot = free_slot();
    if (slot == nullptr) return std::nullopt;

    const gl::Api& gl = device_->gl();
    gl::set_pack(gl);
    gl.ClampColor(GL_CLAMP_READ_COLOR, GL_FALSE);  // else negative SNORM values read as 0
    slot->buffer.bind(gl::BufferTarget::PixelPack);
    std::size_t offset_bytes = 0;
    for (const Piece& piece : pieces) {
        if (piece.rect.empty()) continue;
        const gl::FormatInfo& format = gl::info_of(piece.texture->format());
        TILTH_EXPECTS(!format.depth, "read-back of a depth texture");
        TILTH_EXPECTS(piece.rect.min_x >= 0 && piece.rect.min_y >= 0 && piece.rect.max_x <= piece.texture->width() &&
                          piece.rect.max_y <= piece.texture->height(),
                      "read-back from outside the texture");
        TILTH_EXPECTS(offset_bytes % static_cast<std::size_t>(format.transfer_bytes / format.components) == 0,
                      text("a piece of ", format.name, " starts at byte ", offset_bytes));
        const gl::Texture2D* const attachments[] = {piece.texture};
        framebuffer_.attach(attachments);
        // For reading alone: a driver may finish all draws before it reads what is also bound to be drawn to (llvmpipe
        // does: tens of milliseconds behind a heavy draw).
        gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
        gl.ReadPixels(piece.rect.min_x, piece.rect.min_y, piece.rect.width(), piece.rect.height(), format.layout,
                      format.type, const_cast<void*>(gl::offset_pointer(offset_bytes)));
        offset_bytes += bytes_of(piece);
    }
    framebuffer_.attach({});
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);

    slot->in_flight = gl::Fence::insert(*device_);
    slot->ticket = ++last_ticket_;
    slot->size = size;
    stats.bytes_down += size;
    return slot->ticket;
}

ReadBackRing::State ReadBackRing::poll(std::uint64_t ticket,
                                       const std::function<void(std::span<const std::byte>)>& take) {
    Slot* slot = slot_of(ticket);
    TILTH_EXPECTS(slot != nullptr, text("ticket ", ticket, " is spent, or never was"));
    if (slot == nullptr) return State::Failed;
    if (!slot->in_flight->signaled()) return State::Pending;
    const std::size_t size = slot->size;
    slot->in_flight.reset();
    slot->ticket = 0;
    const std::byte* memory = slot->buffer.map_read(0, size);
    if (memory == nullptr) return State::Failed;
    std::memcpy(copy_.data(), memory, size);
    if (!slot->buffer.unmap()) return State::Failed;
    take(std::span<const std::byte>(copy_).first(size));
    return State::Done;
}

void ReadBackRing::cancel(std::uint64_t ticket) {
    Slot* slot = slot_of(ticket);
    TILTH_EXPECTS(slot != nullptr, text("ticket ", ticket, " is spent, or never was"));
    if (slot != nullptr) slot->ticket = 0;
}

}  // namespace tilth
