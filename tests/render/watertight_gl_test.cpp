// No cracks (V2): a fly-over with a magenta sky finds no sky inside the ground; without one level's stitches it does.
#include <cmath>
#include <cstdio>

#include "render/support/holes.h"
#include "render/support/scene.h"

namespace tilth::test {
namespace {

class WatertightGlTest : public GlTest {};

struct Found {
    long holes = 0;
    int frames = 0, frames_with_sky = 0, frames_without_ground = 0;
    std::uint32_t refined = 0;
};

/// Round the middle of the map at five heights, looking along, askew, obliquely down and straight down.
Found fly_over(Scene& scene, const Target& target, int frames, int first_frame = 0) {
    Found found;
    const double middle = (scene.field().width() - 1) / 2.0;
    const double heights_m[] = {1.5, 6, 20, 40, 75};
    for (int i = first_frame; i < first_frame + frames; ++i) {
        const double turn = i * 0.1234567, radius = middle * (0.15 + 0.4 * std::fmod(i * 0.618034, 1.0));
        const double x = middle + radius * std::cos(turn), z = middle + radius * std::sin(turn);
        const double pitches[] = {-0.12, -0.45, -0.9, -1.3};
        const double pitch = pitches[i % 4], heading = turn * 1.7;
        View view = scene.view_from(
            x, z, heights_m[i % 5],
            {std::cos(pitch) * std::cos(heading), std::sin(pitch), std::cos(pitch) * std::sin(heading)});
        const bool down = i % 7 == 0;
        if (down) view.forward = {0, -1, 0};
        scene.renderer().debug().cull_back_faces = i % 2 == 0;
        const std::vector<std::uint8_t> picture = scene.picture(target, view);
        const long in_frame = sky_within_ground(picture, target.width(), target.height());
        if (in_frame > 0) keep_picture(text("holes_", i), picture, target.width(), target.height());
        found.holes += in_frame;
        int sky = 0;
        for (std::size_t p = 0; p < picture.size(); p += 4) sky += is_magenta(&picture[p]);
        if (down && scene.renderer().debug().omit_stitches_of_level < 0) {
            EXPECT_EQ(sky, 0) << "looking straight down, frame " << i;
        }
        found.frames_with_sky += sky > 0;
        found.frames_without_ground += sky * 4 == static_cast<int>(picture.size());
        found.refined += scene.renderer().last_counts().refined_blocks;
        ++found.frames;
    }
    return found;
}

TEST_F(WatertightGlTest, AThousandFramesHaveNoHole) {
    const Mountains ground = mountains(513, 120);
    const Target target(240, 135);
    // Blends at which every level's zone is well filled; refined as by default, everywhere, and never.
    long frames = 0;
    for (const auto& [refine_above_px, count] : {std::pair{1.0, 500}, {0.0, 250}, {1e6, 250}}) {
        Scene scene(ground.field, ground.codec,
                    {.clipmap = {.n = 63, .levels = 4, .blend = 0.1, .refine_above_px = refine_above_px}});
        const Found found = fly_over(scene, target, count, static_cast<int>(frames));
        EXPECT_EQ(found.holes, 0) << "refined above " << refine_above_px << " px";
        EXPECT_EQ(found.frames_without_ground, 0);
        EXPECT_GT(found.frames_with_sky, count / 10) << "otherwise a hole could not be told from the ground";
        EXPECT_LT(found.frames_with_sky, count * 9 / 10);
        if (refine_above_px < 2) {
            EXPECT_GT(found.refined, 0u);
        }
        frames += found.frames;
    }
    EXPECT_EQ(frames, 1000);
}

// The proof that the test above can fail: the same flight without the stitches of level 0, 1 or 2 has holes.
TEST_F(WatertightGlTest, WithoutOneLevelsStitchesThereAreHoles) {
    const Mountains ground = mountains(513, 120);
    const Target target(240, 135);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 4, .blend = 0.1, .refine_above_px = 1e6}});
    for (int level = 0; level < 3; ++level) {
        scene.renderer().debug().omit_stitches_of_level = level;
        const Found found = fly_over(scene, target, 250, 750);
        std::printf("without the stitches of level %d: %ld pixels of holes in %d frames\n", level, found.holes,
                    found.frames);
        EXPECT_GT(found.holes, 0) << "level " << level;
    }
}

// A map whose sides are no multiples of anything, looked at from its corners and over its edges.
TEST_F(WatertightGlTest, OddMapsHaveNoHole) {
    const Mountains square = mountains(404, 90, 3);
    HeightField field(344, 403);
    for (std::int32_t z = 0; z < 403; ++z)
        for (std::int32_t x = 0; x < 344; ++x) field.set_code({x, z}, square.field.code({x, z}));
    const Target target(240, 135);
    for (const double refine_above_px : {0.0, 1e6}) {
        Scene scene(field, square.codec,
                    {.clipmap = {.n = 31, .levels = 5, .blend = 0.1, .refine_above_px = refine_above_px}});
        for (int i = 0; i < 100; ++i) {
            const double x = 5 + std::fmod(i * 97.31, 333), z = 5 + std::fmod(i * 61.77, 392);
            const double down = -0.15 - 0.012 * i;
            const View view = scene.view_from(x, z, 3 + i % 30, {std::cos(i * 0.7), down, std::sin(i * 0.7)});
            EXPECT_EQ(sky_within_ground(scene.picture(target, view), 240, 135), 0) << "frame " << i;
        }
    }
}

}  // namespace
}  // namespace tilth::test
