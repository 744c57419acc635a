// Between which codes a tile's ground lies, block by block: tells which stamps can saturate. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "tilth/ground/code_range.h"
#include "tilth/ground/page.h"
#include "tilth/world/height_codec.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Lowest and highest code of each page's part of a rectangle of the map. Never narrower than the truth.
/// Memory: 8 bytes per 64 x 64 texels.
class CodeBounds {
public:
    using Range = CodeRange;

    /// Of untouched ground.
    explicit CodeBounds(const TexelRect& held)
        : held_(held),
          pages_(pages_of(held)),
          ranges_(static_cast<std::size_t>(pages_.max.x - pages_.min.x) *
                      static_cast<std::size_t>(pages_.max.z - pages_.min.z),
                  {kMidCode, kMidCode}) {}

    /// Holds every code of `rect`, as far as it lies in what is held; if nothing does, no code at all (min > max).
    [[nodiscard]] Range query(const TexelRect& rect) const {
        Range all;
        for_each_page(pages_of(intersection(rect, held_)), [&](PageIndex page) { all.include(ranges_[index(page)]); });
        return all;
    }
    /// Codes of `rect` may now also lie in `range`.
    void widen(const TexelRect& rect, Range range) {
        for_each_page(pages_of(intersection(rect, held_)),
                      [&](PageIndex page) { ranges_[index(page)].include(range); });
    }
    /// Codes of `rect` now lie in `range`: pages that it covers forget what they held before.
    void put(const TexelRect& rect, Range range) {
        for_each_page(pages_of(intersection(rect, held_)), [&](PageIndex page) {
            const TexelRect whole = intersection(texels_of(page), held_);
            if (intersection(rect, whole) == whole)
                ranges_[index(page)] = range;
            else
                ranges_[index(page)].include(range);
        });
    }

private:
    [[nodiscard]] std::size_t index(PageIndex page) const {
        return static_cast<std::size_t>(page.z - pages_.min.z) * static_cast<std::size_t>(pages_.max.x - pages_.min.x) +
               static_cast<std::size_t>(page.x - pages_.min.x);
    }
    TexelRect held_;
    PageRect pages_;
    std::vector<Range> ranges_;
};

}  // namespace tilth
