// How much may be transferred in a frame. Pure.
#pragma once

#include <cstdint>

namespace tilth {

struct BudgetSettings {
    /// T: the frame time to hold, ms, > 0. Transfers get what the rest of the frame leaves of it: Tu <= T - Tr.
    double frame_target_ms = 1000.0 / 60;
    /// Where nothing is left (a frame slower than the target), transfers still get the larger of these two: else a slow
    /// machine would never see its detail.
    double least_ms = 0.25;
    double least_share = 0.05;               ///< of Tr
    double most_ms = 4;                      ///< and never more than this, ms
    std::uint64_t most_bytes = 8u << 20;     ///< a frame, whatever the time
    std::uint64_t slice_bytes = 256u << 10;  ///< transfers are cut into pieces of about this; one is always allowed
};

/// One frame's allowance. `begin_frame`, then `allows` before each slice and `spend` after it.
class FrameBudget {
public:
    explicit FrameBudget(const BudgetSettings& settings = {}) : settings_(settings) {}

    /// `rest_ms`: how long the last frame took without its transfers. Slow frames count at once, fast ones by and by
    /// (an eighth of the difference a frame), so that one quick frame does not buy a burst. NaN and negative: as
    /// before.
    void begin_frame(double rest_ms);
    /// True for the frame's first slice; then while time and bytes last, the slice's own time estimated from the rate
    /// measured so far.
    [[nodiscard]] bool allows(std::uint64_t bytes) const;
    /// A slice of `bytes` took `ms`.
    void spend(std::uint64_t bytes, double ms);

    [[nodiscard]] double allowed_ms() const { return allowed_ms_; }  ///< Tu of this frame
    [[nodiscard]] double spent_ms() const { return spent_ms_; }
    [[nodiscard]] std::uint64_t spent_bytes() const { return spent_bytes_; }
    [[nodiscard]] const BudgetSettings& settings() const { return settings_; }

private:
    BudgetSettings settings_;
    double rest_ms_ = -1;  ///< Tr, smoothed; negative: not known yet
    double allowed_ms_ = 0, spent_ms_ = 0;
    double ms_per_byte_ = 0;  ///< smoothed; 0: not known yet
    std::uint64_t spent_bytes_ = 0;
    std::uint32_t slices_ = 0;
};

}  // namespace tilth
