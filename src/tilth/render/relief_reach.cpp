#include "tilth/render/relief_reach.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tilth/core/shared_glsl.h"
#include "tilth/pool/relief_window.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {

ReliefReach relief_reach(const ClipmapSettings& clipmap, double spacing_m, std::int32_t texels_per_post, double share) {
    // Where morph_alpha begins, and the rounding of distances.
    const double zone = shared::morph_zone_units(clipmap.n, static_cast<float>(clipmap.blend));
    const double unmorphed =
        clipmap.levels > 1 ? (clipmap.n - 1) * 0.5 - 1 - shared::kMorphSlack - zone - 0.01 : (clipmap.n - 1) * 0.5 - 1;
    constexpr double margin = ReliefWindow::kTopCells + kReliefStep;  // rays, and the step of the corner
    const double most = kMostReliefTexels / 2 - margin;
    const double texels = std::min(unmorphed * texels_per_post, most) * share;
    const auto side = std::bit_ceil(static_cast<std::uint32_t>(std::ceil(2 * (texels + margin))));
    return {texels / texels_per_post * spacing_m,
            std::clamp(static_cast<std::int32_t>(side), ReliefWindow::kLeastSize, kMostReliefTexels)};
}

std::int32_t mark_level(std::int32_t texels_per_post) {
    const auto wide = static_cast<std::uint32_t>(2 * texels_per_post);
    return std::clamp(static_cast<std::int32_t>(std::bit_width(wide - 1)) - 1, 0, ReliefWindow::kLevels - 1);
}

}  // namespace tilth
