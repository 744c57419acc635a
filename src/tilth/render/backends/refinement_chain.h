// How finely the geometry shader may split an edge between two posts. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tilth {

/// Most parts of an edge: a triangle split n times takes n (n + 2) vertices of nine components, and a geometry shader
/// need not emit more than 1024 components.
inline constexpr std::int32_t kMostGeometryFactor = 8;

/// The factors that edges are split by, from 1 on, at most four. Each divides the next, so that a triangle with edges
/// of two factors is the coarser lattice with one side split further, and `texels_per_post` (1 or more), so that every
/// new point is a texel. The last is the largest divisor up to `most_factor` and kMostGeometryFactor; from one to the
/// next are the smallest steps that lead there: 3 texels give 1, 3; 12 give 1, 2, 6; 16 give 1, 2, 4, 8. Where that is
/// not more than half of what might be, powers of two, and points lie between texels: 11 give 1, 2, 4, 8.
std::vector<std::int32_t> refinement_chain(std::int32_t texels_per_post, std::int32_t most_factor);

/// The chain as `u_refine_chain` of render/geometry/refine.geom takes it: four, the last repeated.
std::array<std::int32_t, 4> refinement_uniform(std::span<const std::int32_t> chain);

}  // namespace tilth
