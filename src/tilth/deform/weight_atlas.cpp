#include "tilth/deform/weight_atlas.h"

#include <algorithm>

namespace tilth {
namespace {

constexpr std::uint32_t kRow = 4096;

}  // namespace

Result<std::uint32_t> WeightAtlas::place(const Shape& shape, std::uint64_t& bytes) {
    if (const auto found = places_.find(shape.hash); found != places_.end()) return found->second;
    const std::uint32_t first = used_;
    const auto count = static_cast<std::uint32_t>(shape.weights.size());
    const auto rows = static_cast<std::int32_t>((first + count + kRow - 1) / kRow);
    weights_.resize(static_cast<std::size_t>(rows) * kRow);
    std::copy(shape.weights.begin(), shape.weights.end(), weights_.begin() + first);
    if (!texture_ || rows > texture_->height()) {
        if (const Result<void> grown = grow(rows, bytes); !grown) return grown.error();
    } else {
        const auto first_row = static_cast<std::int32_t>(first / kRow);
        texture_->upload(0, {0, first_row, kRow, rows}, weights_.data() + static_cast<std::size_t>(first_row) * kRow);
        bytes += static_cast<std::uint64_t>(rows - first_row) * kRow * sizeof(std::int32_t);
    }
    used_ += count;
    places_[shape.hash] = first;
    return first;
}

Result<void> WeightAtlas::grow(std::int32_t rows, std::uint64_t& bytes) {
    const std::int32_t height =
        std::min(device_->capabilities().max_texture_size, std::max(rows, texture_ ? 2 * texture_->height() : 4));
    if (rows > height) return Error{ErrorCode::Unsupported, "the stamp images together exceed the largest texture"};
    Result<gl::Texture2D> texture = gl::Texture2D::create(
        *device_, "stamp weights", {.format = gl::Format::R32I, .width = static_cast<int>(kRow), .height = height});
    if (!texture) return texture.error();
    texture_ = std::move(*texture);
    texture_->upload(0, {0, 0, static_cast<std::int32_t>(kRow), rows}, weights_.data());
    bytes += static_cast<std::uint64_t>(rows) * kRow * sizeof(std::int32_t);
    return {};
}

}  // namespace tilth
