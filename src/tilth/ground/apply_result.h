// What applying stamps did, whichever executor did it.
#pragma once

#include <cstdint>

#include "tilth/world/texel.h"

namespace tilth {

struct ApplyResult {
    TexelRect rect;               ///< texels of the map that may have changed
    std::uint64_t texels = 0;     ///< texels of the stamps' rectangles, visited and written
    std::uint64_t saturated = 0;  ///< texels that would have left the range, counted once a stamp

    ApplyResult& operator+=(const ApplyResult& other) {
        rect = bounds_of(rect, other.rect);
        texels += other.texels;
        saturated += other.saturated;
        return *this;
    }
};

}  // namespace tilth
