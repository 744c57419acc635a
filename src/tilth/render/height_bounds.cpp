#include "tilth/render/height_bounds.h"

#include <algorithm>

#include "tilth/core/checks.h"
#include "tilth/core/shared_glsl.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {
namespace {

CodeRange joined(const CodeRange& a, const CodeRange& b) { return {std::min(a.min, b.min), std::max(a.max, b.max)}; }

}  // namespace

HeightBounds::HeightBounds(const HeightField& field) : width_(field.width()), depth_(field.depth()) {
    TILTH_EXPECTS(!field.rect().empty(), "height bounds of an empty field");
    std::int32_t width = (width_ + kBlockPosts - 1) / kBlockPosts, depth = (depth_ + kBlockPosts - 1) / kBlockPosts;
    for (;;) {
        levels_.push_back({width, depth, {}});
        levels_.back().ranges.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(depth));
        if (width == 1 && depth == 1) break;
        width = (width + 1) / 2, depth = (depth + 1) / 2;
    }
    for (std::int32_t level = 1; level <= kErrorLevels; ++level) {
        const std::int32_t posts = kErrorCellUnits << level;
        ErrorLevel made{(width_ + posts - 1) / posts, (depth_ + posts - 1) / posts, {}};
        made.errors.resize(static_cast<std::size_t>(made.width) * static_cast<std::size_t>(made.depth));
        errors_.push_back(std::move(made));
    }
    widen(field.rect(), field);
}

void HeightBounds::widen(const TexelRect& changed, const HeightField& field) {
    const TexelRect inside = intersection(changed, rect());
    if (inside.empty()) return;
    const Texel min{inside.min.x / kBlockPosts, inside.min.z / kBlockPosts};
    const Texel max{(inside.max.x - 1) / kBlockPosts, (inside.max.z - 1) / kBlockPosts};
    for (std::int32_t bz = min.z; bz <= max.z; ++bz) {
        for (std::int32_t bx = min.x; bx <= max.x; ++bx) {
            const std::int32_t end_x = std::min((bx + 1) * kBlockPosts, width_);
            const std::int32_t end_z = std::min((bz + 1) * kBlockPosts, depth_);
            CodeRange range;
            for (std::int32_t z = bz * kBlockPosts; z < end_z; ++z) {
                const std::uint32_t* row = field.row(z);
                for (std::int32_t x = bx * kBlockPosts; x < end_x; ++x) {
                    range.min = std::min(range.min, row[x]);
                    range.max = std::max(range.max, row[x]);
                }
            }
            levels_[0].at(bx, bz) = range;
        }
    }
    refresh_pyramid(min, max);
    refresh_errors(inside, field);
}

void HeightBounds::widen_by(const TexelRect& changed, std::uint32_t min_code, std::uint32_t max_code) {
    const TexelRect inside = intersection(changed, rect());
    if (inside.empty()) return;
    const Texel min{inside.min.x / kBlockPosts, inside.min.z / kBlockPosts};
    const Texel max{(inside.max.x - 1) / kBlockPosts, (inside.max.z - 1) / kBlockPosts};
    const CodeRange old = query(inside);
    const std::uint32_t growth =
        std::max(old.min > min_code ? old.min - min_code : 0, max_code > old.max ? max_code - old.max : 0);
    for (std::int32_t level = 1; growth > 0 && level <= kErrorLevels; ++level) {
        ErrorLevel& stored = errors_[static_cast<std::size_t>(level - 1)];
        const TexelRect cells = error_cells(level, inside);
        for (std::int32_t z = cells.min.z; z < cells.max.z; ++z)
            for (std::int32_t x = cells.min.x; x < cells.max.x; ++x) {
                std::uint32_t& error = stored.errors[static_cast<std::size_t>(z * stored.width + x)];
                error += std::min(growth, 0xffff'ffffu - error);
            }
    }
    for (std::int32_t bz = min.z; bz <= max.z; ++bz)
        for (std::int32_t bx = min.x; bx <= max.x; ++bx)
            levels_[0].at(bx, bz) = joined(levels_[0].at(bx, bz), {min_code, max_code});
    refresh_pyramid(min, max);
}

void HeightBounds::refresh_pyramid(Texel min, Texel max) {
    for (std::size_t l = 1; l < levels_.size(); ++l) {
        const Level& fine = levels_[l - 1];
        min = {min.x / 2, min.z / 2}, max = {max.x / 2, max.z / 2};
        for (std::int32_t z = min.z; z <= max.z; ++z) {
            for (std::int32_t x = min.x; x <= max.x; ++x) {
                CodeRange range = fine.at(2 * x, 2 * z);
                const bool right = 2 * x + 1 < fine.width, below = 2 * z + 1 < fine.depth;
                if (right) range = joined(range, fine.at(2 * x + 1, 2 * z));
                if (below) range = joined(range, fine.at(2 * x, 2 * z + 1));
                if (right && below) range = joined(range, fine.at(2 * x + 1, 2 * z + 1));
                levels_[l].at(x, z) = range;
            }
        }
    }
}

CodeRange HeightBounds::query(const TexelRect& asked) const {
    const TexelRect inside = intersection(asked, rect());
    TILTH_EXPECTS(!inside.empty(), "height bounds asked for a rectangle outside the map");
    std::size_t level = 0;
    const std::int32_t extent = std::max(inside.width(), inside.depth());
    while (level + 1 < levels_.size() && extent > (4 * kBlockPosts << level)) ++level;
    const std::int32_t posts = kBlockPosts << level;
    CodeRange range;
    for (std::int32_t z = inside.min.z / posts; z <= (inside.max.z - 1) / posts; ++z)
        for (std::int32_t x = inside.min.x / posts; x <= (inside.max.x - 1) / posts; ++x)
            range = joined(range, levels_[level].at(x, z));
    return range;
}

TexelRect HeightBounds::error_cells(std::int32_t level, const TexelRect& rect) const {
    const std::int32_t posts = kErrorCellUnits << level;
    return {{rect.min.x / posts, rect.min.z / posts}, {(rect.max.x - 1) / posts + 1, (rect.max.z - 1) / posts + 1}};
}

std::uint32_t HeightBounds::level_error(std::int32_t level, const TexelRect& asked) const {
    const std::int32_t stored_level = std::min(level, kErrorLevels);
    const ErrorLevel& stored = errors_[static_cast<std::size_t>(stored_level - 1)];
    const TexelRect inside = intersection(asked, rect());
    if (inside.empty()) return 0;
    const TexelRect cells = error_cells(stored_level, inside);
    std::uint32_t error = 0;
    for (std::int32_t z = cells.min.z; z < cells.max.z; ++z)
        for (std::int32_t x = cells.min.x; x < cells.max.x; ++x)
            error = std::max(error, stored.errors[static_cast<std::size_t>(z * stored.width + x)]);
    return error;
}

void HeightBounds::refresh_errors(const TexelRect& changed, const HeightField& field) {
    const std::int32_t last_x = width_ - 1, last_z = depth_ - 1;
    const auto height = [&](std::int32_t x, std::int32_t z) { return std::int64_t{field.row(z)[x]}; };
    for (std::int32_t level = 1; level <= kErrorLevels; ++level) {
        ErrorLevel& stored = errors_[static_cast<std::size_t>(level - 1)];
        // A changed post moves the surface of a level within one unit about it.
        const TexelRect moved = intersection(expanded(changed, 1 << level), rect());
        const TexelRect cells = error_cells(level, moved);
        const std::int32_t posts = kErrorCellUnits << level, step = 1 << (level - 1);
        const auto next_vertex = [&](std::int32_t p) { return (p + step - 1) / step * step; };
        for (std::int32_t cz = cells.min.z; cz < cells.max.z; ++cz) {
            for (std::int32_t cx = cells.min.x; cx < cells.max.x; ++cx) {
                const TexelRect cell =
                    intersection({{cx * posts, cz * posts}, {(cx + 1) * posts, (cz + 1) * posts}}, rect());
                const TexelRect visited = intersection(cell, moved);
                std::uint32_t& stored_error =
                    stored.errors[static_cast<std::size_t>(cz) * static_cast<std::size_t>(stored.width) +
                                  static_cast<std::size_t>(cx)];
                std::int64_t error = visited == cell ? 0 : stored_error;
                for (std::int32_t z = next_vertex(visited.min.z); z < visited.max.z; z += step) {
                    const std::int32_t z0 = shared::coarse_low(z, level - 1, last_z);
                    const std::int32_t z1 = shared::coarse_high(z, level - 1, last_z);
                    for (std::int32_t x = next_vertex(visited.min.x); x < visited.max.x; x += step) {
                        const std::int32_t x0 = shared::coarse_low(x, level - 1, last_x);
                        const std::int32_t x1 = shared::coarse_high(x, level - 1, last_x);
                        // Halfway on an edge or on the diagonal: the mean of its ends (nearly so in a last, narrow
                        // cell).
                        const std::int64_t base = (height(x0, z0) + height(x1, z1)) / 2;
                        error = std::max(error, std::abs(height(x, z) - base));
                    }
                }
                stored_error = static_cast<std::uint32_t>(error);
            }
        }
    }
}

PostRange folded_range(std::int32_t min, std::int32_t max, std::int32_t n) {
    const std::int32_t reach = n - 1;  // turning points lie at the multiples of it
    const auto floor_div = [](std::int32_t a, std::int32_t b) { return a / b - (a % b != 0 && (a < 0) != (b < 0)); };
    const std::int32_t first = floor_div(min, reach), last = floor_div(max, reach);
    if (last - first >= 2) return {0, reach};
    const auto show = [&](std::int32_t p) {
        const std::int32_t period = floor_div(p, 2 * reach) * 2 * reach;
        return shared::folded_post(p - period, n);
    };
    PostRange range{std::min(show(min), show(max)), std::max(show(min), show(max))};
    if (last != first) {  // one turning point inside, at last * reach
        const std::int32_t turn = last % 2 == 0 ? 0 : reach;
        range = {std::min(range.min, turn), std::max(range.max, turn)};
    }
    return range;
}

}  // namespace tilth
