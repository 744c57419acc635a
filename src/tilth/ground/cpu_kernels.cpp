#include "tilth/ground/cpu_kernels.h"

#include <array>

namespace tilth {

extern const CpuKernels kBaselineKernels;
#if defined(__x86_64__)
extern const CpuKernels kAvx2Kernels;
#endif

namespace {

struct Available {
    std::array<const CpuKernels*, 2> sets{&kBaselineKernels, nullptr};
    std::size_t count = 1;
    Available() {
#if defined(__x86_64__)
        __builtin_cpu_init();
        if (__builtin_cpu_supports("avx2")) sets[count++] = &kAvx2Kernels;
#endif
    }
};

const Available& available() {
    static const Available found;
    return found;
}

}  // namespace

const CpuKernels& cpu_kernels() { return *available().sets[available().count - 1]; }

std::span<const CpuKernels* const> available_cpu_kernels() {
    return std::span(available().sets).first(available().count);
}

}  // namespace tilth
