// Time of work that no GPU does: wall time, and CPU time of all threads.
#pragma once

#include <chrono>
#include <ctime>
#include <numeric>
#include <string>
#include <vector>

#include "support/bench_device.h"

namespace tilth::bench {

inline double process_cpu_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

/// Samples of both clocks, milliseconds.
class Timed {
public:
    template <class Work>
    void run(const Work& work) {
        const auto began = std::chrono::steady_clock::now();
        const double cpu_began = process_cpu_ms();
        work();
        cpu_ms_.push_back(process_cpu_ms() - cpu_began);
        wall_ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count());
    }
    [[nodiscard]] Percentiles wall() const { return percentiles_of(wall_ms_); }
    [[nodiscard]] Percentiles cpu() const { return percentiles_of(cpu_ms_); }
    [[nodiscard]] double mean_wall_ms() const { return mean(wall_ms_); }
    [[nodiscard]] double mean_cpu_ms() const { return mean(cpu_ms_); }
    [[nodiscard]] double last_wall_ms() const { return wall_ms_.back(); }

    /// Counters `<name>wall_p50_ms` and so on.
    void report(benchmark::State& state, const std::string& name = "") const {
        state.counters[name + "wall_p50_ms"] = wall().p50;
        state.counters[name + "wall_p95_ms"] = wall().p95;
        state.counters[name + "cpu_p50_ms"] = cpu().p50;
        state.counters[name + "cpu_p95_ms"] = cpu().p95;
    }

private:
    static double mean(const std::vector<double>& samples) {
        return std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
    }
    std::vector<double> wall_ms_, cpu_ms_;
};

}  // namespace tilth::bench
