#include "demo/stats/walk_leads.h"

#include <algorithm>

namespace tilth::demo {

LeadWatch::LeadWatch(const TileGrid& grid, double band, std::span<const PostPos> at_texels, double speed_m_per_s)
    : speed_m_per_s_(speed_m_per_s) {
    for (const PostPos& at : at_texels) {
        const TileWindow loaded = tiles_of_viewer(grid, at, band).loaded;
        for (std::int32_t z = loaded.min.z; z <= loaded.max.z; ++z)
            for (std::int32_t x = loaded.min.x; x <= loaded.max.x; ++x) wanted_before_.insert({x, z});
    }
}

void LeadWatch::frame(const gl::CacheStats& cache, std::span<const TileArrival> arrivals, WalkStats& stats) const {
    if (cache.missing_active > 0) ++stats.missing_frames;
    for (const TileArrival& arrival : arrivals) {
        if (arrival.loading_ms == 0 || wanted_before_.contains(arrival.tile)) continue;
        const double lead_ms = arrival.lead_m / speed_m_per_s_ * 1e3;
        stats.smallest_lead_m = std::min(stats.smallest_lead_m.value_or(arrival.lead_m), arrival.lead_m);
        stats.smallest_lead_ms = std::min(stats.smallest_lead_ms.value_or(lead_ms), lead_ms);
    }
}

}  // namespace tilth::demo
