// Heights that lie in memory: what image files, raw files and procedural noise become.
#pragma once

#include <span>
#include <vector>

#include "tilth/source/height_source.h"

namespace tilth {

/// Heights in an array of floats, row by row: post (i, j) is element j * width + i, so a row runs along +x and the next
/// row lies one post further along +z.
///
/// Minimum and maximum are found once, at creation, and are those of the stored floats.
/// Memory: 4 bytes a post. Threads: const calls from any.
class RasterSource final : public HeightSource {
public:
    /// Takes over `heights_m`. Fails with `InvalidArgument` if a side is below 2, if the number of heights is not
    /// width * depth, or if a height is NaN or infinite; the message names the texel. `name` (a file, a specification)
    /// opens the message. Cost: one pass over the heights.
    static Result<std::unique_ptr<RasterSource>> create(std::int32_t width, std::int32_t depth,
                                                        std::vector<float> heights_m, const std::string& name);

    [[nodiscard]] std::int32_t width() const override { return width_; }
    [[nodiscard]] std::int32_t depth() const override { return depth_; }
    [[nodiscard]] double min_m() const override { return min_m_; }
    [[nodiscard]] double max_m() const override { return max_m_; }
    [[nodiscard]] double height_m(Texel t) const override;

    /// All heights, row by row, for those who want to copy rather than ask post by post.
    [[nodiscard]] std::span<const float> heights_m() const { return heights_m_; }

private:
    RasterSource(std::int32_t width, std::int32_t depth, std::vector<float> heights_m, float min_m, float max_m);

    std::int32_t width_, depth_;
    std::vector<float> heights_m_;
    float min_m_, max_m_;
};

}  // namespace tilth
