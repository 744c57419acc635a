#include "tilth/ground/stamp_range.h"

#include <algorithm>

namespace tilth {
namespace {

constexpr std::int64_t kTop = 0xffffffffll;

}  // namespace

StampRange range_after(const PreparedStamp& stamp, std::uint32_t min, std::uint32_t max) {
    const StampParams& s = stamp.params;
    const std::int64_t amplitude = s.amplitude;
    const bool negative = (s.flags & STAMP_NEGATIVE) != 0;
    // One quantum of the high plane: how far rounding to 16 bits can carry.
    const std::int64_t rounding = (s.flags & STAMP_BITS16) != 0 ? 0x10000 : 0;
    std::int64_t low = min, high = max, wanted_low = low, wanted_high = high;
    switch (stamp.rule()) {
        case StampRule::Add: {
            // Weights lie between the shape's extremes; both may have either sign.
            const auto reach = [&](std::int32_t weight) {
                return (amplitude * (negative ? -std::int64_t{weight} : std::int64_t{weight})) / kWeightOne;
            };
            const std::int64_t a = reach(stamp.shape->lowest_weight), b = reach(stamp.shape->highest_weight);
            wanted_low = low + std::min<std::int64_t>({0, a - 1, b - 1}) - rounding - s.residue;
            wanted_high = high + std::max<std::int64_t>({0, a + 1, b + 1}) + rounding + s.residue;
            break;
        }
        case StampRule::Min:
        case StampRule::Max:
        case StampRule::Set: {
            const std::int64_t reached = negative ? s.level - amplitude : s.level + amplitude;
            wanted_low = std::min({low, reached, std::int64_t{s.level}}) - rounding;
            wanted_high = std::max({high, reached, std::int64_t{s.level}}) + rounding;
            const bool leaves = reached < 0 || reached > kTop;  // the target itself; the ground never does
            low = std::clamp<std::int64_t>(wanted_low, 0, kTop);
            high = std::clamp<std::int64_t>(wanted_high, 0, kTop);
            return {static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(high), leaves};
        }
        case StampRule::Smooth:
            break;  // between the codes that it reads, whose bounds the caller gives
    }
    const bool leaves = wanted_low < 0 || wanted_high > kTop - rounding;
    return {static_cast<std::uint32_t>(std::clamp<std::int64_t>(wanted_low, 0, kTop)),
            static_cast<std::uint32_t>(std::clamp<std::int64_t>(wanted_high, 0, kTop)),
            stamp.rule() == StampRule::Add && leaves};
}

}  // namespace tilth
