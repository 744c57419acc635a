// The inner loops of the CPU executor, one row of texels at a time, compiled once per instruction set.
#pragma once

#include <cstdint>
#include <span>

#include "tilth/ground/stamp_params.h"

namespace tilth {

/// Texels that a kernel takes at once: its weights stay in the first-level cache.
inline constexpr std::int32_t kKernelTexels = 512;

/// One row of a stamp: texels (x .. x + count, z) of the map, count <= kKernelTexels, inside the stamp's rectangle.
struct RowTask {
    const StampParams* stamp = nullptr;
    const std::int32_t* weights = nullptr;  ///< the shape's table or image
    std::int32_t x = 0, z = 0, count = 0;
    std::uint32_t* codes = nullptr;  ///< of the row, read and written
    /// For smooth: the rows above, at and below z before the stamp, `x - 1` first, count + 2 codes each.
    const std::uint32_t* before[3] = {nullptr, nullptr, nullptr};
};

/// The loops of one instruction set. All sets give the same bits.
struct CpuKernels {
    const char* name;
    /// Applies the stamp's rule to the row; returns how many texels saturated.
    std::uint64_t (*apply_row)(const RowTask& task);
    /// Sum over the row of what `add` would change, in codes, were nothing to saturate (`codes` is not read).
    std::int64_t (*sum_row)(const RowTask& task);
};

/// The best set this processor has; settled at the first call. Thread-safe.
const CpuKernels& cpu_kernels();

/// Every set this build and processor have, the best last; for tests and benchmarks.
std::span<const CpuKernels* const> available_cpu_kernels();

}  // namespace tilth
