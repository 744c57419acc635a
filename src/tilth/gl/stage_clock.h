// The time of a stage.
#pragma once

#include "tilth/core/clock.h"
#include "tilth/gl/frame_stats.h"

namespace tilth::gl {

/// Adds the wall time of its scope to a stage. Scopes of one stage do not nest.
class StageClock {
public:
    explicit StageClock(StageStats& stats) : stats_(stats) {}
    ~StageClock() { stats_.cpu_ms += clock_ms() - start_ms_; }
    StageClock(const StageClock&) = delete;
    StageClock& operator=(const StageClock&) = delete;

private:
    StageStats& stats_;
    double start_ms_ = clock_ms();
};

}  // namespace tilth::gl
