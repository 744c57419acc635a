#include "tilth/cache/frame_budget.h"

#include <algorithm>
#include <cmath>

namespace tilth {
namespace {

// The older value's weight is 7/8: taste, steady within a dozen frames.
double smoothed(double old_value, double new_value) { return old_value + (new_value - old_value) / 8; }

bool is_time(double ms) { return std::isfinite(ms) && ms >= 0; }

}  // namespace

void FrameBudget::begin_frame(double rest_ms) {
    if (is_time(rest_ms)) rest_ms_ = rest_ms > rest_ms_ ? rest_ms : smoothed(rest_ms_, rest_ms);
    spent_ms_ = 0;
    spent_bytes_ = 0;
    slices_ = 0;
    const double left_ms = rest_ms_ < 0 ? 0 : settings_.frame_target_ms - rest_ms_;
    const double floor_ms = std::max(settings_.least_ms, settings_.least_share * std::max(rest_ms_, 0.0));
    allowed_ms_ = std::min(left_ms > 0 ? left_ms : floor_ms, settings_.most_ms);
}

bool FrameBudget::allows(std::uint64_t bytes) const {
    if (slices_ == 0) return true;
    if (spent_bytes_ > settings_.most_bytes || bytes > settings_.most_bytes - spent_bytes_) return false;
    return spent_ms_ + static_cast<double>(bytes) * ms_per_byte_ <= allowed_ms_;
}

void FrameBudget::spend(std::uint64_t bytes, double ms) {
    ++slices_;
    spent_bytes_ += bytes;
    if (!is_time(ms)) return;
    spent_ms_ += ms;
    if (bytes == 0) return;
    const double measured = ms / static_cast<double>(bytes);
    ms_per_byte_ = ms_per_byte_ > 0 ? smoothed(ms_per_byte_, measured) : measured;
}

}  // namespace tilth
