// The CPU executor: stamps applied by vectorised integer loops, bit for bit what the GPU passes do.
#pragma once

#include "tilth/ground/apply_result.h"
#include "tilth/ground/cpu_kernels.h"
#include "tilth/ground/detail_field.h"
#include "tilth/ground/height_field.h"
#include "tilth/ground/prepared_stamp.h"

namespace tilth {

/// Applies a stamp to a dense map. Texels outside the map are clipped; neighbours beyond its border, which smooth
/// reads, repeat the border. Cost: proportional to the stamp's rectangle, 1-3 ns a texel with AVX2. Not thread-safe on
/// one field; several fields may be stamped at the same time.
ApplyResult apply_stamp(const PreparedStamp& stamp, HeightField& field, const CpuKernels& kernels = cpu_kernels());

/// The same on the sparse detail map whose texels are those of `map`: pages that the stamp's rectangle touches are
/// made.
ApplyResult apply_stamp(const PreparedStamp& stamp, DetailField& field, const TexelRect& map,
                        const CpuKernels& kernels = cpu_kernels());

}  // namespace tilth
