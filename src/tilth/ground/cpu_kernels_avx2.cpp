// The kernels for x86-64 with AVX2; the build compiles this file alone with -mavx2.
#if defined(__AVX2__)
#define TILTH_KERNELS kernels_avx2
#include "tilth/ground/cpu_kernels.inc"

namespace tilth {
extern const CpuKernels kAvx2Kernels;
const CpuKernels kAvx2Kernels = {"avx2", kernels_avx2::apply_row, kernels_avx2::sum_row};
}  // namespace tilth
#endif
