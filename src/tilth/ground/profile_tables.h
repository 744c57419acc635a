// The built-in profiles' committed integer tables.
#pragma once

#include <cstdint>
#include <span>

#include "tilth/ground/shape_library.h"

namespace tilth {

/// Weights of a built-in profile at t = i / 1024, 1/65 536 each: round(65536 w(t)) of the formula beside
/// `BuiltinProfile`.
std::span<const std::int32_t> profile_table(BuiltinProfile profile);

}  // namespace tilth
