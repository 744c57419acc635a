// Wall time for budgets and statistics.
#pragma once

#include <chrono>

namespace tilth {

/// Milliseconds of a clock that never goes back.
inline double clock_ms() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace tilth
