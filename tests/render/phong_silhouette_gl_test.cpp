// Curved triangles round the piecewise linear outlines of smooth hills: the area between the drawn outline and that of
// a mesh of all posts.
#include <cstdio>
#include <numbers>

#include "render/support/outline.h"

namespace tilth::test {
namespace {

class PhongSilhouetteGlTest : public GlTest {};

// A chord of length d over a curve of curvature k is off by k d^2 / 8, curved with shape s by (1 - 2 s) of that
// (render/phong/curved_edge.glsl): nothing with the usual half. What is left over are levels' borders, where nothing is
// curved, edges that rise by less than a twentieth of a pixel, and pixels that rounding decides: less than half in all,
// and with shape 1, which is off by as much on the other side, no gain.
TEST_F(PhongSilhouetteGlTest, RoundsASmoothHill) {
    if (!device().capabilities().tessellation) GTEST_SKIP() << "no tessellation";
    const Mountains hill = smooth_hill(385, 40, 35);
    // Wide posts where the crest stands: 8 m from 124 to 248 m.
    Scene scene(hill.field, hill.codec, {.clipmap = {.n = 63, .levels = 5, .blend = 0.1, .refine_above_px = 1e6}});
    BruteForceMesh reference(scene);
    const Target target(960, 540);
    long flat = 0, half = 0, whole = 0;
    for (int i = 0; i < 4; ++i) {
        const double turn = i * std::numbers::pi / 2 + 0.2, far = 177 + 4 * i;
        const double x = 192 + far * std::cos(turn), z = 192 + far * std::sin(turn);
        const View view = scene.view_from(x, z, 2, {-std::cos(turn), 0.1, -std::sin(turn)});
        const std::vector<std::uint8_t> truth = reference.picture(target, view);
        const auto off = [&](const DetailView* detail) {
            return outline_difference(scene.picture(target, view, {}, nullptr, {1, 0, 1}, detail), truth);
        };
        const DetailView at_half = curved(0.5), at_whole = curved(1);
        const int a = off(nullptr), b = off(&at_half), c = off(&at_whole);
        std::printf("from %.0f m: %d pixels between the outlines; curved by 0.5: %d, by 1: %d\n", far, a, b, c);
        flat += a, half += b, whole += c;
    }
    ASSERT_GT(flat, 400) << "a hill whose outline has corners";
    EXPECT_LT(half, flat / 2);
    EXPECT_GT(whole, half);
}

}  // namespace
}  // namespace tilth::test
