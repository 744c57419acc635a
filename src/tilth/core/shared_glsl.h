// What C++ needs before it includes a file of shaders/shared/. Use it like this, in a .cpp or a header of one layer:
//
//     #include "tilth/core/shared_glsl.h"
//     namespace tilth::shared {
//     #include "shared/slope_math.glsl"
//     }
//
// shaders/ is on the include path; the shared files include each other in the same way.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace tilth::shared {
using uint = std::uint32_t;
using std::abs;
using std::floor;
using std::max;
using std::min;
}  // namespace tilth::shared
