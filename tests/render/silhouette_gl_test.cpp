// The outline of the ground against the sky: the clipmap against a mesh of all posts, pixel by pixel.
#include <chrono>
#include <cmath>
#include <cstdio>

#include "render/support/brute_force_mesh.h"

namespace tilth::test {
namespace {

class SilhouetteGlTest : public GlTest {};

// A walk at 2 m above ridged mountains, 1 m posts. TILTH_SILHOUETTE_POSITIONS=10 looks at fewer of the 60 positions.
TEST_F(SilhouetteGlTest, DiffersFromAllPostsInFewPixels) {
    const Mountains ground = mountains(1025, 200);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 255, .levels = 5, .blend = 0.1}});
    Scene plain(ground.field, ground.codec, {.clipmap = {.n = 255, .levels = 5, .blend = 0.1, .refine_above_px = 1e6}});
    BruteForceMesh reference(scene);
    double refined_ms = 0, plain_ms = 0;
    const auto timed = [](double& sum_ms, const auto& draw) {
        const auto start = std::chrono::steady_clock::now();
        const std::vector<std::uint8_t> picture = draw();
        sum_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        return picture;
    };
    const Target target(1600, 900);
    const char* wanted = std::getenv("TILTH_SILHOUETTE_POSITIONS");
    constexpr int kPositions = 60;
    const int step = std::max(1, kPositions / std::max(1, wanted != nullptr ? std::atoi(wanted) : kPositions));
    int worst = 0, worst_unrefined = 0, positions = 0, with_sky = 0;
    long sum = 0;
    for (int i = 0; i < kPositions; i += step) {
        const double x = 150 + 11.3 * i, z = 870 - 12.1 * i;
        const double turn = 0.35 * std::sin(0.4 * i) - 0.82;  // about the way, looking round
        View view = scene.view_from(x, z, 2, {std::cos(turn), 0, std::sin(turn)});
        const std::vector<std::uint8_t> drawn = timed(refined_ms, [&] { return scene.picture(target, view); });
        const std::vector<std::uint8_t> truth = reference.picture(target, view);
        const std::vector<std::uint8_t> coarse = timed(plain_ms, [&] { return plain.picture(target, view); });
        int differing = 0, unrefined = 0, sky = 0;
        for (std::size_t p = 0; p < drawn.size(); p += 4) {
            differing += is_magenta(&drawn[p]) != is_magenta(&truth[p]);
            unrefined += is_magenta(&coarse[p]) != is_magenta(&truth[p]);
            sky += is_magenta(&truth[p]);
        }
        if (i == 6)
            keep_picture(text("silhouette", i), drawn, 1600, 900),
                keep_picture(text("silhouette_truth", i), truth, 1600, 900);
        std::printf("position %2d (%.0f, %.0f): %4d pixels differ, %d of sky, %u blocks (%u refined), %u culled\n", i,
                    x, z, differing, sky, scene.renderer().last_counts().blocks,
                    scene.renderer().last_counts().refined_blocks, scene.renderer().last_counts().culled_blocks);
        with_sky += sky > 1000;
        EXPECT_LT(differing, 1000) << "position " << i;
        worst_unrefined = std::max(worst_unrefined, unrefined);
        worst = std::max(worst, differing);
        sum += differing;
        ++positions;
    }
    std::printf("silhouettes: worst %d, mean %.0f of 1 440 000 pixels at %d positions\n", worst,
                static_cast<double>(sum) / positions, positions);
    std::printf("without refinement: worst %d; clear, draw and read back take %.1f ms, refined %.1f ms\n",
                worst_unrefined, plain_ms / positions, refined_ms / positions);
    EXPECT_GT(with_sky, positions / 2) << "in a valley without sky there is nothing to compare";
    RecordProperty("worst", worst);
}

}  // namespace
}  // namespace tilth::test
