// Pictures for the eye: TILTH_RENDER_PICTURES=folder keeps them as PPM. Without it only that something was drawn is
// asked.
#include <cmath>

#include "render/support/scene.h"

namespace tilth::test {
namespace {

class PicturesGlTest : public GlTest {};

TEST_F(PicturesGlTest, Mountains) {
    const struct Mountains ground = mountains(1025, 200);
    Scene scene(ground.field, ground.codec, {});
    const Target target(std::getenv("TILTH_RENDER_PICTURES") != nullptr ? 1600 : 320,
                        std::getenv("TILTH_RENDER_PICTURES") != nullptr ? 900 : 180);
    Shading shading;
    shading.tint_low_m = 10, shading.tint_high_m = 170;
    shading.fog_density = 0.0006;
    shading.fog_colour = {0.66f, 0.74f, 0.82f};
    const struct {
        const char* name;
        double x, z, above_m;
        Vec3d forward;
    } views[] = {{"valley", 218, 797, 2, {0.75, 0.02, -0.66}},
                 {"high", 120, 900, 90, {0.7, -0.35, -0.7}},
                 {"crest", 489, 507, 12, {0.9, -0.12, 0.3}},
                 {"above", 512, 512, 320, {0.02, -1, -0.3}}};
    for (const auto& v : views) {
        const BrushCursor cursor{{v.x + 12 * v.forward.x, v.z + 12 * v.forward.z}, 2.0, {1, 0.8f, 0.1f}};
        const std::vector<std::uint8_t> picture = scene.picture(target, scene.view_from(v.x, v.z, v.above_m, v.forward),
                                                                shading, &cursor, shading.fog_colour);
        keep_picture(v.name, picture, target.width(), target.height());
        EXPECT_NE(picture[4], 255);
    }
}

}  // namespace
}  // namespace tilth::test
