// The prepared stamp that both executors share: the struct of shaders/shared/stamp_params.glsl.
#pragma once

#include <type_traits>

#include "tilth/core/shared_glsl.h"

namespace tilth::shared {
#include "shared/stamp_params.glsl"
static_assert(sizeof(StampParams) == 7 * 16 && std::is_trivially_copyable_v<StampParams>);
}  // namespace tilth::shared

namespace tilth {
using shared::StampParams;
}
