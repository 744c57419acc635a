#include "tilth/render/clipmap_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tilth {
namespace {

std::int32_t floor_div(std::int32_t a, std::int32_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

/// Largest error of `level`, in codes, within one node distance of a node.
std::uint32_t error_near(std::int32_t level, std::int32_t node_x, std::int32_t node_z, const RefinementInput& input) {
    const std::int64_t posts = std::int64_t{kNodeUnits} << level;
    const auto range = [&](std::int32_t node, std::int32_t stored_posts) -> PostRange {
        const std::int64_t low = (node - 1) * posts, high = (node + 1) * posts - 1;
        if (input.mirrored)
            return folded_range(static_cast<std::int32_t>(low), static_cast<std::int32_t>(high), stored_posts);
        const auto clamped = [&](std::int64_t p) {
            return static_cast<std::int32_t>(std::clamp<std::int64_t>(p, -1, stored_posts));
        };
        return {clamped(low), clamped(high)};
    };
    const PostRange x = range(node_x, input.grid.width), z = range(node_z, input.grid.depth);
    return input.bounds.level_error(level, {{x.min, z.min}, {x.max + 1, z.max + 1}});
}

/// Where one side of a block lies on the other axis. Sides: 0 low z, 1 high z, 2 low x, 3 high x.
std::int32_t across_of(const ClipmapBlock& block, int side) {
    return side == 0 ? block.z : side == 1 ? block.z + block.depth : side == 2 ? block.x : block.x + block.width;
}

/// Whether nothing is drawn beyond one side of a block: the map ends there, or the coarsest window does.
bool ground_ends(const ClipmapBlock& block, int side, const ClipmapLayout& layout, std::int32_t last) {
    const std::int32_t across = across_of(block, side);
    const ClipmapBlock& outermost = layout.windows.back();
    return across <= 0 || std::int64_t{across} << block.level >= last ||
           (block.level == outermost.level && across == across_of(outermost, side));
}

/// Marks the parts of one side of `block` (quads along it) that another refined block shares.
void mark_shared(const ClipmapBlock& block, int side, const ClipmapBlock& other,
                 std::array<bool, kBlockQuads>& shared) {
    const bool along_x = side < 2;
    if (across_of(block, side) != across_of(other, side ^ 1)) return;
    const std::int32_t start = along_x ? block.x : block.z, length = along_x ? block.width : block.depth;
    const std::int32_t other_start = along_x ? other.x : other.z, other_length = along_x ? other.width : other.depth;
    const std::int32_t from = std::max(start, other_start), to = std::min(start + length, other_start + other_length);
    for (std::int32_t i = from; i < to; ++i) shared[static_cast<std::size_t>(i - start)] = true;
}

/// Stitches along one side of a refined block, in the finer level's units, where no refined block lies beyond.
void add_side(const ClipmapBlock& block, int side, const std::array<bool, kBlockQuads>& shared,
              std::vector<DrawnBlock>& stitches) {
    const bool along_x = side < 2;
    const std::int32_t start = along_x ? block.x : block.z, length = along_x ? block.width : block.depth;
    const std::int32_t across = across_of(block, side);
    constexpr std::int32_t longest = kBlockQuads / 2;  // coarse quads; twice as many fine ones
    for (std::int32_t i = 0; i < length;) {
        if (shared[static_cast<std::size_t>(i)]) {
            ++i;
            continue;
        }
        std::int32_t end = i;
        while (end < length && end - i < longest && !shared[static_cast<std::size_t>(end)]) ++end;
        const std::int32_t from = 2 * (start + i), fine_length = 2 * (end - i);
        const ClipmapBlock fine = along_x ? ClipmapBlock{from, 2 * across, fine_length, 0, block.level - 1}
                                          : ClipmapBlock{2 * across, from, 0, fine_length, block.level - 1};
        stitches.push_back({fine, block.level});
        i = end;
    }
}

}  // namespace

bool ClipmapRefinement::touches(const ClipmapBlock& block) const {
    const NodeGrid& grid = grids[static_cast<std::size_t>(block.level)];
    if (grid.width == 0) return false;
    const auto weight = [&](std::int32_t x, std::int32_t z) {
        return weights[static_cast<std::size_t>(grid.first + (z - grid.min_z) * grid.width + x - grid.min_x)];
    };
    for (std::int32_t z = floor_div(block.z, kNodeUnits); z <= floor_div(block.z + block.depth - 1, kNodeUnits) + 1;
         ++z)
        for (std::int32_t x = floor_div(block.x, kNodeUnits); x <= floor_div(block.x + block.width - 1, kNodeUnits) + 1;
             ++x)
            if (weight(x, z) > 0) return true;
    return false;
}

float ClipmapRefinement::weight_at(std::int32_t level, std::int32_t x, std::int32_t z) const {
    const NodeGrid& grid = grids[static_cast<std::size_t>(level)];
    if (grid.width == 0) return 0;
    const std::int32_t shift = level + 5, node_x = x >> shift, node_z = z >> shift;
    const float scale = 1.0f / static_cast<float>(1 << shift);
    const float tx = static_cast<float>(x - (node_x << shift)) * scale,
                tz = static_cast<float>(z - (node_z << shift)) * scale;
    const auto weight = [&](std::int32_t i, std::int32_t j) {
        const std::int32_t cx = std::clamp(node_x + i - grid.min_x, 0, grid.width - 1);
        const std::int32_t cz = std::clamp(node_z + j - grid.min_z, 0, grid.depth - 1);
        return weights[static_cast<std::size_t>(grid.first + cz * grid.width + cx)];
    };
    const float near = weight(0, 0) + tx * (weight(1, 0) - weight(0, 0));
    const float far = weight(0, 1) + tx * (weight(1, 1) - weight(0, 1));
    return near + tz * (far - near);
}

ClipmapRefinement clipmap_refinement(const ClipmapSettings& settings, const ClipmapLayout& layout, const Camera& camera,
                                     const RefinementInput& input) {
    ClipmapRefinement refinement;
    refinement.grids.resize(layout.windows.size());
    const double threshold = settings.refine_above_px;
    if (threshold >= 1e6) return refinement;
    for (std::size_t l = 1; l < layout.windows.size(); ++l) {
        const ClipmapBlock& window = layout.windows[l];
        NodeGrid& grid = refinement.grids[l];
        grid.min_x = floor_div(window.x, kNodeUnits), grid.min_z = floor_div(window.z, kNodeUnits);
        grid.width = floor_div(window.x + window.width, kNodeUnits) + 2 - grid.min_x;
        grid.depth = floor_div(window.z + window.depth, kNodeUnits) + 2 - grid.min_z;
        grid.first = static_cast<std::int32_t>(refinement.weights.size());
        const double node_m = input.grid.spacing_m * std::ldexp(kNodeUnits, window.level);
        for (std::int32_t z = grid.min_z; z < grid.min_z + grid.depth; ++z) {
            for (std::int32_t x = grid.min_x; x < grid.min_x + grid.width; ++x) {
                const double dx = x * node_m - camera.eye_x_m, dz = z * node_m - camera.eye_z_m;
                const double distance_m = std::max(std::sqrt(dx * dx + dz * dz), node_m);
                const double error_m = error_near(window.level, x, z, input) * input.codec.code_quantum_m();
                const double error_px = error_m * camera.pixels_per_radian / distance_m;
                const double over = threshold > 0 ? error_px / threshold - 1 : (error_px > 0 ? 1 : 0);
                refinement.weights.push_back(static_cast<float>(std::clamp(over, 0.0, 1.0)));
            }
        }
    }
    return refinement;
}

DrawnBlocks drawn_blocks(const ClipmapLayout& layout, const ClipmapRefinement& refinement, std::int32_t last_x,
                         std::int32_t last_z) {
    DrawnBlocks drawn;
    std::vector<ClipmapBlock> refined;
    for (const ClipmapBlock& b : layout.blocks) {
        if (!refinement.touches(b)) {
            drawn.blocks.push_back({b, b.level});
            continue;
        }
        refined.push_back(b);
        for (std::int32_t quarter = 0; quarter < 4; ++quarter) {
            const ClipmapBlock part{2 * b.x + (quarter % 2) * b.width, 2 * b.z + (quarter / 2) * b.depth, b.width,
                                    b.depth, b.level - 1};
            drawn.blocks.push_back({part, b.level});
        }
    }
    for (const ClipmapBlock& s : layout.stitches) drawn.stitches.push_back({s, s.level});
    for (const ClipmapBlock& b : refined) {
        for (int side = 0; side < 4; ++side) {
            if (ground_ends(b, side, layout, side < 2 ? last_z : last_x)) continue;
            std::array<bool, kBlockQuads> shared{};
            for (const ClipmapBlock& other : refined)
                if (other.level == b.level) mark_shared(b, side, other, shared);
            add_side(b, side, shared, drawn.stitches);
        }
    }
    return drawn;
}

}  // namespace tilth
