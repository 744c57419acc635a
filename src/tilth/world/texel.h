// Texels of a map and rectangles of them. Texel (i, j) of a map lies on its post (i, j): i along +x, j along +z.
#pragma once

#include <algorithm>
#include <cstdint>

namespace tilth {

/// A texel of one map, by its index in the whole map (never in a tile).
struct Texel {
    std::int32_t x = 0, z = 0;
    friend bool operator==(const Texel&, const Texel&) = default;
};

/// A rectangle of texels, half-open: `min` belongs to it, `max` does not. Empty when max <= min on either axis.
struct TexelRect {
    Texel min, max;

    friend bool operator==(const TexelRect&, const TexelRect&) = default;

    [[nodiscard]] constexpr std::int32_t width() const { return std::max(0, max.x - min.x); }
    [[nodiscard]] constexpr std::int32_t depth() const { return std::max(0, max.z - min.z); }
    [[nodiscard]] constexpr bool empty() const { return max.x <= min.x || max.z <= min.z; }
    [[nodiscard]] constexpr std::int64_t count() const { return std::int64_t{width()} * depth(); }
    [[nodiscard]] constexpr bool contains(Texel t) const {
        return t.x >= min.x && t.x < max.x && t.z >= min.z && t.z < max.z;
    }
};

/// The texels in both; empty if there are none.
constexpr TexelRect intersection(const TexelRect& a, const TexelRect& b) {
    return {{std::max(a.min.x, b.min.x), std::max(a.min.z, b.min.z)},
            {std::min(a.max.x, b.max.x), std::min(a.max.z, b.max.z)}};
}

/// The smallest rectangle that holds both; an empty one adds nothing.
constexpr TexelRect bounds_of(const TexelRect& a, const TexelRect& b) {
    if (a.empty()) return b;
    if (b.empty()) return a;
    return {{std::min(a.min.x, b.min.x), std::min(a.min.z, b.min.z)},
            {std::max(a.max.x, b.max.x), std::max(a.max.z, b.max.z)}};
}

/// `rect` grown by `margin` texels on each side (shrunk if negative).
constexpr TexelRect expanded(const TexelRect& rect, std::int32_t margin) {
    return {{rect.min.x - margin, rect.min.z - margin}, {rect.max.x + margin, rect.max.z + margin}};
}

}  // namespace tilth
