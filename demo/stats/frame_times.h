// What frames took, and the percentiles of it.
#pragma once

#include <vector>

namespace tilth::demo {

/// One entry per frame. CPU time is that of all threads of the process, which a busy neighbour does not inflate.
struct FrameTimes {
    std::vector<double> cpu_ms, wall_ms;
};

/// The smallest sample that at least `share` of all samples do not exceed (nearest rank); 0 without samples.
double percentile(std::vector<double> samples, double share);

/// A stretch of time, from construction on.
class Stopwatch {
public:
    Stopwatch();
    /// Appends what has passed since construction.
    void stop(FrameTimes& times) const;

private:
    double cpu_ms_, wall_ms_;
};

}  // namespace tilth::demo
