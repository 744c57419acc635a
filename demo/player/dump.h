// The step `dump`: a region of one map into a file.
#pragma once

#include <array>
#include <string>

#include "demo/scenario/scenario.h"

namespace tilth::demo {

/// dh/dx and dh/dz of one map at texel `t`, by central differences of its codes (one-sided at the map's border), with
/// the formula of the slope maps.
std::array<double, 2> slope_at(const Ground& ground, MapKind map, Texel t);

/// Writes what `step` asks for to `path`. The CPU's copy must be current. Fails when the region holds no texel or more
/// than 2^28, and with the writer's errors.
Result<void> write_dump(const Ground& ground, const DumpStep& step, const std::string& path);

}  // namespace tilth::demo
