// How far about the eye relief can be shown, and what window of texels that takes. Pure.
#pragma once

#include <cstdint>

#include "tilth/render/view.h"

namespace tilth {

struct ReliefReach {
    double reach_m = 0;              ///< relief is gone from here on: no vertex nearer than this morphs
    std::int32_t window_texels = 0;  ///< a side, a power of two: `ReliefWindow::create`
};

/// `share`: `DetailSettings::reach`. The reach ends where the finest level begins to morph, and where the largest
/// window (kMostReliefTexels) would end; rays may leave the reach by a quarter of the window.
ReliefReach relief_reach(const ClipmapSettings& clipmap, double spacing_m, std::int32_t texels_per_post, double share);

/// The pyramid's level whose nodes are two posts wide at least: where the mesh backends look for detail about a post.
std::int32_t mark_level(std::int32_t texels_per_post);

inline constexpr std::int32_t kMostReliefTexels = 2048;  ///< a side: 45 MB at most
/// The window's corner moves in steps of this many texels.
inline constexpr std::int32_t kReliefStep = 64;

}  // namespace tilth
