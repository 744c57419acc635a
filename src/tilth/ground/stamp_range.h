// What a stamp can do to heights that are known by their bounds only.
#pragma once

#include <cstdint>

#include "tilth/ground/prepared_stamp.h"

namespace tilth {

/// Bounds of codes after a stamp, and whether one of them can have left the range.
struct StampRange {
    std::uint32_t min = 0, max = 0;
    bool may_saturate = false;
};

/// Bounds after `stamp`, applied to codes between `min` and `max`. Never narrower than the truth.
StampRange range_after(const PreparedStamp& stamp, std::uint32_t min, std::uint32_t max);

}  // namespace tilth
