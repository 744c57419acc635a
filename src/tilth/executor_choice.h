// `ExecutorKind::Automatic`: which executor is faster here, by a short measurement.
#pragma once

#include <string>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/shader_library.h"
#include "tilth/pool/slope_map.h"
#include "tilth/world/height_codec.h"

namespace tilth {

/// Time of one stamp of 64 x 64 texels with its slopes, microseconds of wall time, best of several, to the end of the
/// GPU's work.
struct ExecutorTimes {
    double gpu_us = 0;
    double cpu_us = 0;  ///< with the upload of what changed
    [[nodiscard]] bool gpu_is_faster() const { return gpu_us < cpu_us; }
    /// One sentence for a report.
    [[nodiscard]] std::string reason() const;
};

/// Stamps a map of its own, so that no world is touched. Takes some ten milliseconds, most of it the driver's compiler.
/// Waits for the GPU: for start-up only.
Result<ExecutorTimes> measure_executors(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                        SlopeFormat slopes);

}  // namespace tilth
