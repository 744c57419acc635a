// The drawn surface on the CPU: the layout and the formulas of shared/clipmap_morph.glsl, in the shader's order.
#pragma once

#include <cmath>

#include "tilth/core/shared_glsl.h"
#include "tilth/ground/height_field.h"
#include "tilth/render/camera.h"
#include "tilth/render/clipmap_layout.h"
#include "tilth/render/clipmap_refinement.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
#include "shared/slope_math.glsl"
}  // namespace tilth::shared

namespace tilth::test {

class ClipmapTwin {
public:
    ClipmapTwin(const ClipmapSettings& settings, const Camera& camera, const GridSpec& grid, const HeightCodec& codec,
                const HeightField& field, const HeightBounds& bounds)
        : settings_(settings),
          camera_(camera),
          spacing_m_(static_cast<float>(grid.spacing_m)),
          quantum_m_(static_cast<float>(codec.code_quantum_m())),
          field_(&field),
          last_{field.width() - 1, field.depth() - 1},
          layout_(clipmap_layout(settings, camera.eye_posts, last_.x, last_.z)),
          refinement_(clipmap_refinement(settings, layout_, camera, {grid, codec, false, bounds})) {}

    /// Height of a vertex of `level`, metres from the eye.
    [[nodiscard]] float vertex_m(int level, int x, int z) const {
        const float height = post_m(x, z);
        if (level >= settings_.levels - 1) return height;
        const float alpha =
            shared::morph_alpha(distance_units(level, x, z), settings_.n,
                                shared::morph_zone_units(settings_.n, static_cast<float>(settings_.blend)));
        const int x0 = shared::coarse_low(x, level, last_.x), x1 = shared::coarse_high(x, level, last_.x);
        const int z0 = shared::coarse_low(z, level, last_.z), z1 = shared::coarse_high(z, level, last_.z);
        if (alpha <= 0 || (x0 == x1 && z0 == z1)) return height;
        const float coarse = shared::cell_height(post_m(x0, z0), post_m(x1, z0), post_m(x0, z1), post_m(x1, z1),
                                                 shared::coarse_weight(x, x0, x1), shared::coarse_weight(z, z0, z1));
        return alpha < 1 ? height + alpha * (coarse - height) : coarse;
    }

    /// Height of a vertex of level - 1 on the refined surface of `level`.
    [[nodiscard]] float refined_m(int level, int x, int z) const {
        const int x0 = shared::coarse_low(x, level - 1, last_.x), x1 = shared::coarse_high(x, level - 1, last_.x);
        const int z0 = shared::coarse_low(z, level - 1, last_.z), z1 = shared::coarse_high(z, level - 1, last_.z);
        float base = vertex_m(level, x0, z0);
        if (x0 != x1 || z0 != z1)
            base = shared::cell_height(base, vertex_m(level, x1, z0), vertex_m(level, x0, z1), vertex_m(level, x1, z1),
                                       shared::coarse_weight(x, x0, x1), shared::coarse_weight(z, z0, z1));
        const float weight =
            refinement_.weight_at(level, x, z) *
            shared::refinement_fade(distance_units(level, x, z), settings_.n, level == settings_.levels - 1);
        return weight > 0 ? base + weight * (post_m(x, z) - base) : base;
    }

    /// Finest level that covers (x, z) [posts]; -1 if none does.
    [[nodiscard]] int level_at(double x, double z) const {
        for (const ClipmapBlock& w : layout_.windows) {
            const double unit = std::ldexp(1.0, w.level);
            if (x >= w.x * unit && z >= w.z * unit && x < (w.x + w.width) * unit && z < (w.z + w.depth) * unit)
                return w.level;
        }
        return -1;
    }

    /// Height of the drawn surface, metres from the eye; (x, z) in posts, covered and inside the map. A ring that is
    /// not refined has weight 0, so its surface is the same on the finer level's cells.
    [[nodiscard]] double surface_m(double x, double z) const {
        const int level = level_at(x, z), cells = std::max(level - 1, 0);
        const auto low = [&](double p, int last) {
            const int cell = static_cast<int>(p) >> cells << cells;
            return cell >= last ? (last - 1) >> cells << cells : cell;
        };
        const int x0 = low(x, last_.x), z0 = low(z, last_.z);
        const int x1 = std::min(x0 + (1 << cells), last_.x), z1 = std::min(z0 + (1 << cells), last_.z);
        const double u = (x - x0) / (x1 - x0), v = (z - z0) / (z1 - z0);
        const auto h = [&](int px, int pz) {
            return static_cast<double>(level == 0 ? vertex_m(0, px, pz) : refined_m(level, px, pz));
        };
        const double h00 = h(x0, z0), h11 = h(x1, z1);
        if (u >= v) {
            const double h10 = h(x1, z0);
            return h00 + u * (h10 - h00) + v * (h11 - h10);
        }
        const double h01 = h(x0, z1);
        return h00 + v * (h01 - h00) + u * (h11 - h01);
    }

private:
    [[nodiscard]] float distance_units(int level, int x, int z) const {
        const float ground_x = static_cast<float>(x - camera_.base_x) * spacing_m_ - camera_.fraction_x_m;
        const float ground_z = static_cast<float>(z - camera_.base_z) * spacing_m_ - camera_.fraction_z_m;
        return std::max(std::abs(ground_x), std::abs(ground_z)) / (spacing_m_ * static_cast<float>(1 << level));
    }
    [[nodiscard]] float post_m(int x, int z) const {
        return shared::code_difference(field_->code({x, z}), camera_.eye_code) * quantum_m_ - camera_.eye_above_code_m;
    }

    ClipmapSettings settings_;
    Camera camera_;
    float spacing_m_, quantum_m_;
    const HeightField* field_;
    Texel last_;
    ClipmapLayout layout_;
    ClipmapRefinement refinement_;
};

}  // namespace tilth::test
