#include "tilth/render/relief_reach.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tilth/core/shared_glsl.h"
#include "tilth/pool/relief_window.h"
#include "tilth/render/clipmap_layout.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {

namespace {

constexpr std::int32_t kUsualMost = 2048;  // texels a side: 36 to 45 MB
constexpr std::int32_t kFewestPosts = 16;  // of reach, before the window may grow beyond that
constexpr std::int32_t kSlackTexels = 48;  // half a step of the corner, and the taps of slopes

/// Texels about the eye in which everything that is drawn as relief lies in a window of `size`.
double room(const ClipmapSettings& clipmap, std::int32_t texels_per_post, std::int32_t size) {
    const double half = size / 2;
    const double level = ((clipmap.n - 1) * 0.5 + 2) * texels_per_post + kSlackTexels;  // the finest, with its odd post
    const double blocks = level <= half ? half : half - kSlackTexels - double{kBlockQuads} * texels_per_post;
    return std::max(std::min(half - kRayTexels, blocks), 0.0);
}

}  // namespace

ReliefReach relief_reach(const ClipmapSettings& clipmap, double spacing_m, std::int32_t texels_per_post, double share,
                         double most_m) {
    // Where morph_alpha begins, and the rounding of distances.
    const double zone = shared::morph_zone_units(clipmap.n, static_cast<float>(clipmap.blend));
    const double unmorphed =
        clipmap.levels > 1 ? (clipmap.n - 1) * 0.5 - 1 - shared::kMorphSlack - zone - 0.01 : (clipmap.n - 1) * 0.5 - 1;
    const double texels_per_m = texels_per_post / spacing_m;
    const double wanted = std::max(std::min(unmorphed * texels_per_post * share, most_m * texels_per_m), 0.0);
    std::int32_t size = ReliefWindow::kLeastSize;
    while (size < kUsualMost && room(clipmap, texels_per_post, size) < wanted) size *= 2;
    const double few = double{kFewestPosts} * texels_per_post;
    if (size == kUsualMost && room(clipmap, texels_per_post, size) < std::min(wanted, few))
        size = ReliefWindow::kMostSize;
    return {std::min(wanted, room(clipmap, texels_per_post, size)) / texels_per_m, size};
}

std::int32_t mark_level(std::int32_t texels_per_post) {
    const auto wide = static_cast<std::uint32_t>(2 * texels_per_post);
    return std::clamp(static_cast<std::int32_t>(std::bit_width(wide - 1)) - 1, 0, ReliefWindow::kLevels - 1);
}

}  // namespace tilth
