// How long the GPU worked, in milliseconds.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/objects.h"

namespace tilth::gl {

enum class TimerPolicy {
    NeverWait,  ///< for frames: where timer queries lie or are missing there are no samples
    MayFinish,  ///< for benchmarks: there, glFinish bounds the work and all threads' CPU time is the sample
};

/// Times stretches of GL commands. On a GPU: GL_TIME_ELAPSED queries, read when they are ready, frames later. On a
/// software renderer, with `MayFinish`: CPU time of all threads of the process between two glFinish, which a busy
/// neighbour does not inflate. Stretches of GPU timers do not nest, as GL's do not.
class GpuTimer {
public:
    static Result<GpuTimer> create(Device& device, std::string_view label, TimerPolicy policy);

    void begin();
    void end();
    /// Samples that became ready since the last call, in order. Never waits.
    std::vector<double> take_samples_ms();
    /// Waits for all outstanding samples. For the end of a benchmark.
    std::vector<double> finish_samples_ms();
    /// Stretches without a sample because all queries were still in flight.
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
    [[nodiscard]] bool measures() const { return mode_ != Mode::None; }

private:
    enum class Mode { None, Queries, CpuTime };
    explicit GpuTimer(Device& device) : device_(&device) {}

    Device* device_;
    Mode mode_ = Mode::None;
    std::vector<Query> queries_;  ///< a ring: [first_, first_ + in_flight_) have been ended and not read
    std::size_t first_ = 0, in_flight_ = 0;
    bool open_ = false;
    double start_ms_ = 0;
    std::vector<double> ready_ms_;
    std::uint64_t dropped_ = 0;
};

/// CPU time of all threads of this process so far.
double process_cpu_ms();

}  // namespace tilth::gl
