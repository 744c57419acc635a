// Where rectangles lie side by side in a scratch texture. Pure.
#pragma once

#include <algorithm>
#include <cstdint>

namespace tilth {

/// Places rectangles in rows ("shelves") from left to right; a row is as deep as its deepest rectangle. When the limit
/// is reached, the next rectangle begins another pass over the same texture. A rectangle beyond the limit by itself is
/// placed alone, in a pass of its own.
class Shelves {
public:
    /// Limits in texels, > 0. `align`: columns and rows start at multiples of it, > 0.
    Shelves(std::int32_t most_width, std::int32_t most_depth, std::int32_t align)
        : most_width_(most_width), most_depth_(most_depth), align_(align) {}

    struct Spot {
        std::int32_t pass = 0;  ///< from 0, never decreasing
        std::int32_t x = 0, z = 0;
    };
    Spot add(std::int32_t width, std::int32_t depth) {
        if (x_ > 0 && x_ + width > most_width_) x_ = 0, z_ = aligned(next_z_);
        if (next_z_ > 0 && z_ + depth > most_depth_) ++pass_, x_ = 0, z_ = 0, next_z_ = 0;
        const Spot spot{pass_, x_, z_};
        width_ = std::max(width_, x_ + width);
        depth_ = std::max(depth_, z_ + depth);
        x_ = aligned(x_ + width);
        next_z_ = std::max(next_z_, z_ + depth);
        return spot;
    }

    /// What the texture must hold, over all passes.
    [[nodiscard]] std::int32_t width() const { return width_; }
    [[nodiscard]] std::int32_t depth() const { return depth_; }

private:
    [[nodiscard]] std::int32_t aligned(std::int32_t at) const { return (at + align_ - 1) / align_ * align_; }
    std::int32_t most_width_, most_depth_, align_;
    std::int32_t pass_ = 0, x_ = 0, z_ = 0, next_z_ = 0;
    std::int32_t width_ = 0, depth_ = 0;
};

}  // namespace tilth
