#include "demo/window/path_brush.h"

#include <cmath>

namespace tilth::demo {

namespace {
/// A jump of the cursor (over a ridge, say) does not lay a road across the valley.
constexpr int kMostStampsAFrame = 256;
}  // namespace

std::vector<WorldPos> PathBrush::drag(WorldPos at, double spacing_m) {
    std::vector<WorldPos> due;
    if (!last_) return press(at);
    const double dx = at.x - last_->x, dz = at.z - last_->z, length_m = std::hypot(dx, dz);
    const double count = std::floor(length_m / spacing_m + 1e-9);
    if (count > kMostStampsAFrame) return press(at);
    const WorldPos start = *last_;
    for (int i = 1; i <= int(count); ++i) {
        const double share = i * spacing_m / length_m;
        last_ = WorldPos{start.x + dx * share, start.z + dz * share};
        due.push_back(*last_);
    }
    return due;
}

}  // namespace tilth::demo
