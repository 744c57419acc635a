#include "demo/player/region.h"

#include <algorithm>
#include <cmath>

namespace tilth::demo {

namespace {

constexpr double kSlack = 1e-6;

std::int32_t clamped(double index, std::int32_t size) {
    return static_cast<std::int32_t>(std::clamp(index, 0.0, double(size)));
}

}  // namespace

TexelRect texels_in(const GridSpec& grid, const std::array<WorldPos, 2>& corners) {
    const PostPos a = grid.posts(corners[0]), b = grid.posts(corners[1]);
    return {{clamped(std::ceil(std::min(a.x, b.x) - kSlack), grid.width),
             clamped(std::ceil(std::min(a.z, b.z) - kSlack), grid.depth)},
            {clamped(std::floor(std::max(a.x, b.x) + kSlack) + 1, grid.width),
             clamped(std::floor(std::max(a.z, b.z) + kSlack) + 1, grid.depth)}};
}

}  // namespace tilth::demo
