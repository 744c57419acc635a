// Between which codes a part of a map lies.
#pragma once

#include <algorithm>
#include <cstdint>

#include "tilth/ground/detail_field.h"
#include "tilth/ground/height_field.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Lowest and highest height code, both included; min > max: of nothing.
struct CodeRange {
    std::uint32_t min = 0xffff'ffffu, max = 0;

    void include(CodeRange other) { min = std::min(min, other.min), max = std::max(max, other.max); }
    void include(const std::uint32_t* codes, std::int32_t count) {
        for (std::int32_t i = 0; i < count; ++i) {
            min = std::min(min, codes[i]);
            max = std::max(max, codes[i]);
        }
    }
    friend bool operator==(const CodeRange&, const CodeRange&) = default;
};

/// Every code there is: of what is not known.
inline constexpr CodeRange kAllCodes{0, 0xffff'ffffu};

/// Exact, of `part`, which lies in `page`; `codes` nullptr: untouched ground. Cost: a look at each texel.
CodeRange range_in(const PageCodes* codes, PageIndex page, const TexelRect& part);
/// Exact, of `rect`, which lies inside the map.
CodeRange range_in(const HeightField& field, const TexelRect& rect);
CodeRange range_in(const DetailField& field, const TexelRect& rect);

}  // namespace tilth
