// How high the ground can be in a part of the map: for culling blocks that the camera cannot see. Pure, CPU.
#pragma once

#include <cstdint>
#include <vector>

#include "tilth/ground/code_range.h"
#include "tilth/ground/height_field.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Smallest and largest code of every 64 x 64 posts of a map, and of 2 x 2 of those, and so on; and how far a clipmap
/// level is from the next finer one.
///
/// The range that it answers is never narrower than the truth, and may be wider: whole blocks are read, and `widen_by`
/// never narrows. Memory: 8 bytes per 64 x 64 posts and 4 bytes per 64 x 64, a third more for the pyramids. One thread.
class HeightBounds {
public:
    static constexpr std::int32_t kBlockPosts = 64;

    static constexpr std::int32_t kErrorLevels = 8;      ///< coarser levels answer as the coarsest of these
    static constexpr std::int32_t kErrorCellUnits = 32;  ///< level units a side of one stored error

    /// Reads the whole field twice (a few ns a post).
    explicit HeightBounds(const HeightField& field);

    /// Posts in `changed` have new codes in `field`, which is current: recomputes the ranges of the blocks that it
    /// touches, exactly. Level errors only grow, but where a whole cell changed: so the cost is that of the rectangle.
    void widen(const TexelRect& changed, const HeightField& field);

    /// Posts in `changed` have new codes between `min_code` and `max_code`, which only the GPU knows. Level errors grow
    /// by what the range grows, which is a guess: they steer quality only.
    void widen_by(const TexelRect& changed, std::uint32_t min_code, std::uint32_t max_code);

    /// A range that holds every code in `rect`, which is clipped to the map and must not be empty then. Reads at most
    /// 6 x 6 entries: for a large rectangle, of a coarser level of the pyramid.
    [[nodiscard]] CodeRange query(const TexelRect& rect) const;

    /// The largest distance, in codes, from the surface of `level` >= 1 to a vertex of level - 1, in the cells of 32 x
    /// 32 level units that `rect` [posts, clipped to the map] touches.
    [[nodiscard]] std::uint32_t level_error(std::int32_t level, const TexelRect& rect) const;

    [[nodiscard]] TexelRect rect() const { return {{0, 0}, {width_, depth_}}; }

private:
    struct Level {
        std::int32_t width = 0, depth = 0;
        std::vector<CodeRange> ranges;
        CodeRange& at(std::int32_t x, std::int32_t z) {
            return ranges[static_cast<std::size_t>(z) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
        }
        [[nodiscard]] const CodeRange& at(std::int32_t x, std::int32_t z) const {
            return ranges[static_cast<std::size_t>(z) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
        }
    };
    struct ErrorLevel {
        std::int32_t width = 0, depth = 0;
        std::vector<std::uint32_t> errors;
    };
    /// Cells of an error level that `rect` touches; `rect` not empty and inside the map.
    [[nodiscard]] TexelRect error_cells(std::int32_t level, const TexelRect& rect) const;
    void refresh_errors(const TexelRect& changed, const HeightField& field);
    /// Recomputes all levels above the first for the blocks `min`..`max` (included) of the first.
    void refresh_pyramid(Texel min, Texel max);

    std::int32_t width_ = 0, depth_ = 0;
    std::vector<Level> levels_;
    std::vector<ErrorLevel> errors_;  ///< [0] is level 1
};

/// The posts of a map of n posts that posts `min`..`max` (both included, max >= min) of the map repeated by reflection
/// show: {first, last}, both included. Reflection is continuous, so it is one range.
struct PostRange {
    std::int32_t min = 0, max = 0;
    friend bool operator==(const PostRange&, const PostRange&) = default;
};
PostRange folded_range(std::int32_t min, std::int32_t max, std::int32_t n);

}  // namespace tilth
