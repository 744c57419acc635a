// How far about the eye relief can be shown, and what window of texels that takes. Pure.
#pragma once

#include <cstdint>

#include "tilth/render/view.h"

namespace tilth {

struct ReliefReach {
    double reach_m = 0;              ///< relief is gone from here on: no vertex nearer than this morphs
    std::int32_t window_texels = 0;  ///< a side, a power of two: `ReliefWindow::create`
};

/// `share`: `DetailSettings::reach`; `most_m`: how far detail is to be had. The reach ends where the finest level
/// begins to morph, and where the window would not hold every block that begins within it, or rays that leave it by
/// kRayTexels. The window is the smallest that does; where 2 048 texels a side leave less than 16 posts, 4 096 (150
/// MB). A reach of 0: there is no room at all (a level that morphs from its middle on, or more than about 60 texels a
/// post).
ReliefReach relief_reach(const ClipmapSettings& clipmap, double spacing_m, std::int32_t texels_per_post, double share,
                         double most_m);

/// The pyramid's level whose nodes are two posts wide at least: where the mesh backends look for detail about a post.
std::int32_t mark_level(std::int32_t texels_per_post);

/// How far rays may leave the reach, texels.
inline constexpr std::int32_t kRayTexels = 128;
/// The window's corner moves in steps of this many texels.
inline constexpr std::int32_t kReliefStep = 64;

}  // namespace tilth
