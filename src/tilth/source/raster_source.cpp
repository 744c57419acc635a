#include "tilth/source/raster_source.h"

#include <cmath>

namespace tilth {

Result<std::unique_ptr<RasterSource>> RasterSource::create(std::int32_t width, std::int32_t depth,
                                                           std::vector<float> heights_m, const std::string& name) {
    if (width < 2 || depth < 2)
        return Error{ErrorCode::InvalidArgument,
                     text(name, ": ", width, " x ", depth, " heights; ground needs at least 2 posts along each side")};
    const std::size_t posts = static_cast<std::size_t>(width) * static_cast<std::size_t>(depth);
    if (heights_m.size() != posts)
        return Error{ErrorCode::InvalidArgument, text(name, ": ", heights_m.size(), " heights given, ", width, " x ",
                                                      depth, " = ", posts, " needed")};

    float min_m = heights_m[0], max_m = heights_m[0];
    for (std::size_t i = 0; i < posts; ++i) {
        const float h = heights_m[i];
        if (!std::isfinite(h)) {
            const std::size_t row = static_cast<std::size_t>(width);
            return Error{ErrorCode::InvalidArgument,
                         text(name, ": the height at texel (", i % row, ", ", i / row, ") is ",
                              std::isnan(h) ? "not a number" : "infinite",
                              "; every height must be finite (for holes in the data, name their no-data value and a "
                              "replacement)")};
        }
        min_m = std::min(min_m, h);
        max_m = std::max(max_m, h);
    }
    return std::unique_ptr<RasterSource>(new RasterSource(width, depth, std::move(heights_m), min_m, max_m));
}

RasterSource::RasterSource(std::int32_t width, std::int32_t depth, std::vector<float> heights_m, float min_m,
                           float max_m)
    : width_(width), depth_(depth), heights_m_(std::move(heights_m)), min_m_(min_m), max_m_(max_m) {}

double RasterSource::height_m(Texel t) const {
    TILTH_EXPECTS((TexelRect{{0, 0}, {width_, depth_}}.contains(t)),
                  text("texel (", t.x, ", ", t.z, ") lies outside ", width_, " x ", depth_, " posts"));
    return heights_m_[static_cast<std::size_t>(t.z) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(t.x)];
}

}  // namespace tilth
