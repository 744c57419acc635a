// Pictures of prints for the eye: TILTH_RENDER_PICTURES=folder keeps them as PPM.
#include <numbers>

#include "render/support/detail_tiles.h"
#include "render/support/picture_difference.h"
#include "render/support/trail.h"

namespace tilth::test {
namespace {

class DetailPicturesGlTest : public GlTest {};

// Posts 0.1 m, texels 1/30 m, eye at 2 m over the corner of four tiles: three trails cross the borders.
TEST_F(DetailPicturesGlTest, Prints) {
    const Mountains ground = mountains(1025, 9);
    Scene scene(ground.field, ground.codec, {.spacing_m = 0.1});
    const bool keep = std::getenv("TILTH_RENDER_PICTURES") != nullptr;
    const Target target(keep ? 1600 : 320, keep ? 900 : 180);
    const double corner = 1024 / 30.0;
    const Trail trails[] = {
        {corner - 6, corner + 1, 0.02}, {corner + 0.5, corner - 4, 1.2}, {corner + 1, corner + 5, -0.5}};
    const auto height = [&](double x, double z) {
        double sum = 0;
        for (const Trail& trail : trails) sum += trail.height_m(x, z);
        return sum;
    };
    DetailTiles tiles(scene.map(), {.tile_size = 1024, .window = {{0, 0}, {1, 1}}, .reach_m = 30},
                      slopes_of(0.1 / 3, height));
    const struct {
        const char* name;
        double x, z, above_m;
        Vec3d forward;
    } views[] = {{"prints_along", corner - 3, corner, 2, {1, -0.25, 0.12}},
                 {"prints_down", corner + 1, corner + 1.2, 2, {0.3, -1, 0.1}},
                 {"prints_far", corner - 8, corner - 2, 2, {1, -0.12, 0.3}},
                 {"prints_above", corner + 4, corner - 6, 12, {0.0, -1, 0.7}},
                 {"prints_high", corner + 4, corner - 6, 28, {0.0, -1, 0.3}}};
    Shading shading;
    shading.to_light = {0.5f, 0.45f, 0.3f};
    for (const auto& v : views) {
        View view = scene.view_from(v.x * 10, v.z * 10, v.above_m, v.forward);
        view.fov_y_rad = std::numbers::pi / 3;
        const auto without = scene.picture(target, view, shading, nullptr, {0.6f, 0.7f, 0.8f});
        const auto with = scene.picture(target, view, shading, nullptr, {0.6f, 0.7f, 0.8f}, &tiles.view());
        keep_picture(v.name, with, target.width(), target.height());
        EXPECT_GT(difference_of(without, with).max, v.above_m <= 2 ? 25 : 5) << v.name << ": prints can be seen";
    }
}

}  // namespace
}  // namespace tilth::test
