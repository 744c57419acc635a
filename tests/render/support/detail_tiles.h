// Detail tiles from a field of slopes, made without the stages before the renderer.
#pragma once

#include <functional>
#include <optional>

#include "render/support/scene.h"
#include "tilth/render/detail_view.h"

namespace tilth::test {

struct DetailOptions {
    std::int32_t texels_per_post = 3;
    std::int32_t tile_size = 128, apron = 2;
    TileWindow window{{0, 0}, {0, 0}};
    double reach_m = 10;
};

/// Slope of the detail height at a texel of the whole detail map.
using DetailSlopes = std::function<std::array<double, 2>(Texel)>;

/// The tiles of a window; those in `missing` (slots of DetailView) have no texture.
class DetailTiles {
public:
    DetailTiles(const MapInfo& map, const DetailOptions& options, const DetailSlopes& slope_at,
                std::vector<std::size_t> missing = {}) {
        const GridSpec& posts = map.grid;
        const std::int32_t last_x = (map.mirrored ? 1 << 20 : posts.width) - 1;
        const std::int32_t last_z = (map.mirrored ? 1 << 20 : posts.depth) - 1;
        view_.grid = {options.tile_size,
                      options.apron,
                      {{0, 0}, {last_x * options.texels_per_post + 1, last_z * options.texels_per_post + 1}}};
        view_.spacing_m = posts.spacing_m / options.texels_per_post;
        view_.window = options.window;
        view_.reach_m = options.reach_m;
        for (std::int32_t z = 0; z < options.window.rows(); ++z) {
            for (std::int32_t x = 0; x < options.window.columns(); ++x) {
                const auto slot = static_cast<std::size_t>(z * 2 + x);
                if (std::find(missing.begin(), missing.end(), slot) != missing.end()) continue;
                const TexelRect stored = view_.grid.stored({options.window.min.x + x, options.window.min.z + z});
                SlopeTexels texels(map.slopes);
                for (std::int32_t tz = stored.min.z; tz < stored.max.z; ++tz) {
                    for (std::int32_t tx = stored.min.x; tx < stored.max.x; ++tx) {
                        const std::array<double, 2> s = slope_at({tx, tz});
                        texels.add(static_cast<float>(s[0]), static_cast<float>(s[1]));
                    }
                }
                const int size = view_.grid.stored_size();
                textures_[slot] = value(gl::Texture2D::create(
                    test::device(), "test detail",
                    {.format = map.slopes == SlopeFormat::rg8 ? gl::Format::Rg8 : gl::Format::Rg16F,
                     .width = size,
                     .height = size,
                     .filter = gl::Filter::Linear}));
                textures_[slot]->upload(0, textures_[slot]->bounds(), texels.data());
                view_.slopes[slot] = &*textures_[slot];
            }
        }
    }
    DetailTiles(const DetailTiles&) = delete;
    DetailTiles& operator=(const DetailTiles&) = delete;

    [[nodiscard]] DetailView& view() { return view_; }

private:
    DetailView view_;
    std::array<std::optional<gl::Texture2D>, 4> textures_;
};

/// Slopes of a height field given in metres over (x, z) in metres, by central differences.
template <class Height>
DetailSlopes slopes_of(double spacing_m, Height height_m) {
    return [=](Texel t) {
        const double x = t.x * spacing_m, z = t.z * spacing_m;
        return std::array<double, 2>{(height_m(x + spacing_m, z) - height_m(x - spacing_m, z)) / (2 * spacing_m),
                                     (height_m(x, z + spacing_m) - height_m(x, z - spacing_m)) / (2 * spacing_m)};
    };
}

}  // namespace tilth::test
