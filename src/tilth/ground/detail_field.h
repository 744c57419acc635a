// The detail map on the CPU: codes in sparse 64 x 64 pages, only where somebody stamped.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>

#include "tilth/world/height_codec.h"
#include "tilth/world/texel.h"

namespace tilth {

inline constexpr std::int32_t kPageTexels = 64;

/// A page by its place in the whole detail map: texels [64 x, 64 x + 64) x [64 z, 64 z + 64).
struct PageIndex {
    std::int32_t x = 0, z = 0;
    friend auto operator<=>(const PageIndex&, const PageIndex&) = default;
};

/// Codes of one page, row by row, row with +z.
using PageCodes = std::array<std::uint32_t, std::size_t(kPageTexels) * kPageTexels>;

/// Detail codes of a whole world. Untouched ground is the code 2^31 and costs nothing.
class DetailField {
public:
    /// `t` may be negative.
    [[nodiscard]] static constexpr PageIndex page_of(Texel t) { return {t.x >> 6, t.z >> 6}; }

    [[nodiscard]] std::uint32_t code(Texel t) const;
    /// The page, made if it is not there (all codes 2^31).
    PageCodes& touch(PageIndex page);
    /// Nullptr where nothing was ever written.
    [[nodiscard]] const PageCodes* find(PageIndex page) const;
    [[nodiscard]] const std::map<PageIndex, std::unique_ptr<PageCodes>>& pages() const { return pages_; }

private:
    std::map<PageIndex, std::unique_ptr<PageCodes>> pages_;
};

}  // namespace tilth
