#include "demo/stats/frame_times.h"

#include <time.h>

#include <algorithm>
#include <cmath>

namespace tilth::demo {

namespace {

double now_ms(clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

}  // namespace

double percentile(std::vector<double> samples, double share) {
    if (samples.empty()) return 0;
    const double rank = std::ceil(share * double(samples.size()));
    const auto index = static_cast<std::ptrdiff_t>(std::clamp(rank, 1.0, double(samples.size()))) - 1;
    std::nth_element(samples.begin(), samples.begin() + index, samples.end());
    return samples[static_cast<std::size_t>(index)];
}

Stopwatch::Stopwatch() : cpu_ms_(now_ms(CLOCK_PROCESS_CPUTIME_ID)), wall_ms_(now_ms(CLOCK_MONOTONIC)) {}

void Stopwatch::stop(FrameTimes& times) const {
    times.cpu_ms.push_back(now_ms(CLOCK_PROCESS_CPUTIME_ID) - cpu_ms_);
    times.wall_ms.push_back(now_ms(CLOCK_MONOTONIC) - wall_ms_);
}

}  // namespace tilth::demo
