// Pages: the 64 x 64 pieces in which detail codes are kept, moved and stored.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <memory>

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

/// A page and its codes. Copies share the codes: whoever wants to change them makes its own first.
struct Page {
    PageIndex index;
    std::shared_ptr<PageCodes> codes;
};

/// A rectangle of pages, half-open.
struct PageRect {
    PageIndex min, max;
    friend bool operator==(const PageRect&, const PageRect&) = default;
    [[nodiscard]] constexpr bool empty() const { return max.x <= min.x || max.z <= min.z; }
    [[nodiscard]] constexpr bool contains(PageIndex p) const {
        return p.x >= min.x && p.x < max.x && p.z >= min.z && p.z < max.z;
    }
};

constexpr PageIndex page_of(Texel t) { return {t.x >> 6, t.z >> 6}; }  // also of negative texels
constexpr TexelRect texels_of(PageIndex p) {
    return {{p.x * kPageTexels, p.z * kPageTexels}, {(p.x + 1) * kPageTexels, (p.z + 1) * kPageTexels}};
}
/// The pages that meet `rect`.
constexpr PageRect pages_of(const TexelRect& rect) {
    if (rect.empty()) return {};
    const PageIndex last = page_of({rect.max.x - 1, rect.max.z - 1});
    return {page_of(rect.min), {last.x + 1, last.z + 1}};
}
/// Calls `visit(page)` for each page of `pages`, row by row.
template <class Visit>
constexpr void for_each_page(const PageRect& pages, const Visit& visit) {
    for (std::int32_t z = pages.min.z; z < pages.max.z; ++z)
        for (std::int32_t x = pages.min.x; x < pages.max.x; ++x) visit(PageIndex{x, z});
}
constexpr PageRect intersection(const PageRect& a, const PageRect& b) {
    return {{a.min.x > b.min.x ? a.min.x : b.min.x, a.min.z > b.min.z ? a.min.z : b.min.z},
            {a.max.x < b.max.x ? a.max.x : b.max.x, a.max.z < b.max.z ? a.max.z : b.max.z}};
}

}  // namespace tilth
