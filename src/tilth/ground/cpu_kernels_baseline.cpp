// The kernels for any processor of the architecture.
#define TILTH_KERNELS kernels_baseline
#include "tilth/ground/cpu_kernels.inc"

namespace tilth {
extern const CpuKernels kBaselineKernels;
const CpuKernels kBaselineKernels = {"baseline", kernels_baseline::apply_row, kernels_baseline::sum_row};
}  // namespace tilth
