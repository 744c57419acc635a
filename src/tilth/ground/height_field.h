// A dense map of height codes: the coarse ground on the CPU.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tilth/world/height_codec.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Height codes of a width x depth map, row by row, row with +z. With `bits16` codes are kept as code << 16, so that
/// one arithmetic serves both; the low half is then always zero.
class HeightField {
public:
    HeightField() = default;
    HeightField(std::int32_t width, std::int32_t depth, std::uint32_t code = kMidCode);

    [[nodiscard]] std::int32_t width() const { return width_; }
    [[nodiscard]] std::int32_t depth() const { return depth_; }
    [[nodiscard]] TexelRect rect() const { return {{0, 0}, {width_, depth_}}; }

    /// `t` lies inside.
    [[nodiscard]] std::uint32_t code(Texel t) const { return codes_[index(t)]; }
    void set_code(Texel t, std::uint32_t code) { codes_[index(t)] = code; }

    [[nodiscard]] std::span<const std::uint32_t> codes() const { return codes_; }
    [[nodiscard]] std::span<std::uint32_t> codes() { return codes_; }
    [[nodiscard]] std::uint32_t* row(std::int32_t z) { return codes_.data() + std::size_t(z) * std::size_t(width_); }
    [[nodiscard]] const std::uint32_t* row(std::int32_t z) const {
        return codes_.data() + std::size_t(z) * std::size_t(width_);
    }

private:
    [[nodiscard]] std::size_t index(Texel t) const { return std::size_t(t.z) * std::size_t(width_) + std::size_t(t.x); }
    std::int32_t width_ = 0, depth_ = 0;
    std::vector<std::uint32_t> codes_;
};

}  // namespace tilth
