// How early tiles came while somebody walked. Pure; no GL.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>

#include "tilth/terrain.h"

namespace tilth::demo {

/// Of all walks of a run.
struct WalkStats {
    std::uint64_t missing_frames = 0;        ///< frames in which a tile was missing that they should have sampled
    std::optional<double> smallest_lead_m;   ///< that the walker still had to go before he needed a tile that came
    std::optional<double> smallest_lead_ms;  ///< the same at his speed
};

/// Watches one walk. Only tiles that walking asked for have a lead: those that were wanted already where the walk began
/// and those that a print was the first to dent do not count.
class LeadWatch {
public:
    /// `at_texels`: where the viewers stand as the walk begins, in texels of the detail map.
    LeadWatch(const TileGrid& grid, double band, std::span<const PostPos> at_texels, double speed_m_per_s);

    /// After a frame of the walk.
    void frame(const gl::CacheStats& cache, std::span<const TileArrival> arrivals, WalkStats& stats) const;

private:
    std::set<TileIndex> wanted_before_;
    double speed_m_per_s_;
};

}  // namespace tilth::demo
