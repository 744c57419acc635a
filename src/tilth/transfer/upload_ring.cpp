#include "tilth/transfer/upload_ring.h"

#include "tilth/core/log.h"

namespace tilth {

Result<UploadRing> UploadRing::create(gl::Device& device, std::size_t slot_bytes, int slots) {
    if (slot_bytes == 0 || slots < 1)
        return Error{ErrorCode::InvalidArgument,
                     text("upload ring: has ", slots, " slots of ", slot_bytes, " bytes, each must be at least 1")};
    UploadRing ring;
    ring.device_ = &device;
    ring.slot_bytes_ = slot_bytes;
    if (device.capabilities().buffer_storage) {
        const Result<void> made = ring.make_slots(device, slots, true);
        if (made) return ring;
        log(LogLevel::Warning,
            text("upload ring: mapped for each use instead of persistently: ", made.error().message));
    }
    const Result<void> made = ring.make_slots(device, slots, false);
    if (!made) return made.error();
    return ring;
}

Result<void> UploadRing::make_slots(gl::Device& device, int slots, bool persistent) {
    slots_.clear();
    for (int i = 0; i < slots; ++i) {
        const std::string label = text("upload ring, slot ", i);
        Result<gl::Buffer> buffer = persistent
                                        ? gl::Buffer::create_persistent(device, label, slot_bytes_)
                                        : gl::Buffer::create(device, label, slot_bytes_, gl::BufferUsage::Stream);
        if (!buffer) return buffer.error();
        slots_.push_back({*std::move(buffer), std::nullopt});
    }
    return {};
}

std::optional<std::span<std::byte>> UploadRing::begin(std::size_t size) {
    TILTH_EXPECTS(open_ == Open::No, "a second begin without an end");
    TILTH_ASSERT(size > 0 && size <= slot_bytes_, text("begin of ", size, " bytes in slots of ", slot_bytes_));
    Slot& slot = slots_[next_];
    if (slot.in_flight && !slot.in_flight->signaled()) return std::nullopt;
    slot.in_flight.reset();
    std::byte* memory = slot.buffer.mapped();
    const bool persistent = memory != nullptr;
    if (!persistent) memory = slot.buffer.map_write(0, size);
    if (memory == nullptr) return std::nullopt;
    open_ = persistent ? Open::Readable : Open::Mapped;
    open_bytes_ = size;
    return std::span(memory, size);
}

void UploadRing::make_readable() {
    if (open_ == Open::Mapped) open_ = slots_[next_].buffer.unmap() ? Open::Readable : Open::Lost;
}

bool UploadRing::to_texture(gl::Texture2D& texture, int level, const gl::Rect& rect, std::size_t offset_bytes,
                            gl::TransferStats& stats) {
    TILTH_EXPECTS(open_ != Open::No, "to_texture outside begin and end");
    const gl::FormatInfo& format = gl::info_of(texture.format());
    const std::size_t bytes = static_cast<std::size_t>(rect.count()) * static_cast<std::size_t>(format.transfer_bytes);
    TILTH_EXPECTS(offset_bytes + bytes <= open_bytes_,
                  text(bytes, " bytes from ", offset_bytes, " on are more than the ", open_bytes_, " that begin gave"));
    TILTH_EXPECTS(offset_bytes % static_cast<std::size_t>(format.transfer_bytes / format.components) == 0,
                  text("offset ", offset_bytes, " is not a multiple of the size of a component of ", format.name));
    make_readable();
    if (open_ == Open::Lost) return false;
    if (rect.empty()) return true;
    texture.upload(level, rect, slots_[next_].buffer, offset_bytes);
    open_ = Open::BeingRead;
    stats.bytes_up += bytes;
    return true;
}

void UploadRing::end() {
    TILTH_EXPECTS(open_ != Open::No, "end without a begin");
    make_readable();
    if (open_ == Open::BeingRead) {
        slots_[next_].in_flight = gl::Fence::insert(*device_);
        next_ = (next_ + 1) % slots_.size();
    }
    open_ = Open::No;
}

}  // namespace tilth
