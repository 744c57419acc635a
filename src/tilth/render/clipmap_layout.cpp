#include "tilth/render/clipmap_layout.h"

#include <algorithm>
#include <cmath>

namespace tilth {
namespace {

/// Half-open rectangle of quads in one level's units.
struct Quads {
    std::int32_t min_x = 0, min_z = 0, max_x = 0, max_z = 0;
    [[nodiscard]] bool empty() const { return max_x <= min_x || max_z <= min_z; }
};

Quads intersection(const Quads& a, const Quads& b) {
    return {std::max(a.min_x, b.min_x), std::max(a.min_z, b.min_z), std::min(a.max_x, b.max_x),
            std::min(a.max_z, b.max_z)};
}

/// Quads of a level over a map: the last one may be narrower.
std::int32_t quads_of_map(std::int32_t last, std::int32_t level) {
    return static_cast<std::int32_t>((std::int64_t{last} + (std::int64_t{1} << level) - 1) >> level);
}

/// The even vertex that puts a window of `quads` quads nearest to being centred on `viewer` (level units).
std::int32_t window_min(double viewer, std::int32_t quads) {
    return 2 * static_cast<std::int32_t>(std::floor((viewer - quads * 0.5) * 0.5 + 0.5));
}

/// Cuts a rectangle into parts of nearly equal size, none above kBlockQuads: equal, because a block costs its whole
/// mesh however few of its quads are used.
void cut(const Quads& area, std::int32_t level, std::vector<ClipmapBlock>& blocks) {
    if (area.empty()) return;
    const auto parts = [](std::int32_t length) { return (length + kBlockQuads - 1) / kBlockQuads; };
    const std::int32_t width = area.max_x - area.min_x, depth = area.max_z - area.min_z;
    const std::int32_t columns = parts(width), rows = parts(depth);
    const auto at = [](std::int32_t min, std::int32_t length, std::int32_t part, std::int32_t count) {
        return min + static_cast<std::int32_t>(std::int64_t{length} * part / count);
    };
    for (std::int32_t r = 0; r < rows; ++r) {
        const std::int32_t z0 = at(area.min_z, depth, r, rows), z1 = at(area.min_z, depth, r + 1, rows);
        for (std::int32_t c = 0; c < columns; ++c) {
            const std::int32_t x0 = at(area.min_x, width, c, columns), x1 = at(area.min_x, width, c + 1, columns);
            blocks.push_back({x0, z0, x1 - x0, z1 - z0, level});
        }
    }
}

/// Segments along one side of a clipped window, at vertex `across` of the other axis.
void add_stitches(bool along_x, std::int32_t min, std::int32_t max, std::int32_t across, std::int32_t level,
                  std::vector<ClipmapBlock>& stitches) {
    for (std::int32_t from = min; from < max; from += kBlockQuads) {
        const std::int32_t length = std::min(kBlockQuads, max - from);
        stitches.push_back(along_x ? ClipmapBlock{from, across, length, 0, level}
                                   : ClipmapBlock{across, from, 0, length, level});
    }
}

}  // namespace

Result<void> check_clipmap(const ClipmapSettings& settings) {
    const std::int32_t n = settings.n;
    if (n < 15 || n > 1023 || ((n + 1) & n) != 0)
        return Error{ErrorCode::InvalidArgument,
                     text("clipmap.n is ", n, "; allowed are 15, 31, 63, 127, 255, 511 and 1023 (2^k - 1)")};
    if (settings.levels < 1 || settings.levels > 16)
        return Error{ErrorCode::InvalidArgument, text("clipmap.levels is ", settings.levels, "; allowed are 1 to 16")};
    if (!(settings.blend >= 0.02 && settings.blend <= 0.25))
        return Error{ErrorCode::InvalidArgument,
                     text("clipmap.blend is ", settings.blend, "; allowed are 0.02 to 0.25")};
    if (!(settings.refine_above_px >= 0 && settings.refine_above_px <= 1e6))
        return Error{ErrorCode::InvalidArgument,
                     text("clipmap.refine_above_px is ", settings.refine_above_px, "; allowed are 0 to 1e6 pixels")};
    return {};
}

ClipmapLayout clipmap_layout(const ClipmapSettings& settings, PostPos viewer, std::int32_t last_x,
                             std::int32_t last_z) {
    TILTH_EXPECTS(check_clipmap(settings).ok(), "clipmap settings out of range; call check_clipmap first");
    TILTH_EXPECTS(std::abs(viewer.x) <= 1073741824.0 && std::abs(viewer.z) <= 1073741824.0,
                  "viewer beyond 2^30 posts, or not finite");
    ClipmapLayout layout;
    const std::int32_t quads = settings.n - 1;
    Quads hole;  // the window of the level before, in units of this level
    for (std::int32_t level = 0; level < settings.levels; ++level) {
        const double scale = std::ldexp(1.0, -level);
        const std::int32_t x = window_min(viewer.x * scale, quads), z = window_min(viewer.z * scale, quads);
        layout.windows.push_back({x, z, quads, quads, level});
        const Quads map{0, 0, quads_of_map(last_x, level), quads_of_map(last_z, level)};
        const Quads window = intersection({x, z, x + quads, z + quads}, map);
        const Quads inner = intersection(hole, window);
        if (level == 0 || inner.empty()) {
            cut(window, level, layout.blocks);
        } else {
            cut({window.min_x, window.min_z, window.max_x, inner.min_z}, level, layout.blocks);
            cut({window.min_x, inner.min_z, inner.min_x, inner.max_z}, level, layout.blocks);
            cut({inner.max_x, inner.min_z, window.max_x, inner.max_z}, level, layout.blocks);
            cut({window.min_x, inner.max_z, window.max_x, window.max_z}, level, layout.blocks);
        }
        if (level + 1 < settings.levels && !window.empty()) {  // sides that the map does not cut off
            if (z > 0) add_stitches(true, window.min_x, window.max_x, z, level, layout.stitches);
            if (z + quads < map.max_z)
                add_stitches(true, window.min_x, window.max_x, z + quads, level, layout.stitches);
            if (x > 0) add_stitches(false, window.min_z, window.max_z, x, level, layout.stitches);
            if (x + quads < map.max_x)
                add_stitches(false, window.min_z, window.max_z, x + quads, level, layout.stitches);
        }
        hole = {x / 2, z / 2, (x + quads) / 2, (z + quads) / 2};  // both even: exact, negative too
    }
    return layout;
}

}  // namespace tilth
