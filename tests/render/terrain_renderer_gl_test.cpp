// The renderer's pictures and promises: heights as the CPU computes them, the same far from the origin, in both depth
// conventions, at both precisions; degenerate views; counts.
#include "tilth/render/terrain_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/support/clipmap_twin.h"
#include "render/support/picture_difference.h"
#include "render/support/scene.h"
#include "support/gl_state.h"

namespace tilth::test {
namespace {

class TerrainRendererGlTest : public GlTest {};

Vec3d towards(double heading, double pitch) {
    return {std::cos(pitch) * std::cos(heading), std::sin(pitch), std::cos(pitch) * std::sin(heading)};
}

// The shader's surface is the twin's: every pixel's depth, seen from above over all levels, is put back into the world.
TEST_F(TerrainRendererGlTest, SurfaceIsTheTwins) {
    if (!device().capabilities().clip_control) GTEST_SKIP() << "no clip control: depths are too coarse to compare";
    const Mountains ground = mountains(513, 100);
    const HeightBounds bounds(ground.field);
    const Target target(256, 256);
    for (const double refine_above_px : {1e6, 0.05, 0.0}) {
        const ClipmapSettings settings{.n = 31, .levels = 5, .blend = 0.1, .refine_above_px = refine_above_px};
        Scene scene(ground.field, ground.codec, {.clipmap = settings});
        for (const double x : {256.37, 40.91, 500.03}) {
            View view = scene.view_from(x, 201.77, 400, {0, -1, 0});
            view.depth = DepthConvention::Reversed;
            view.near_m = 50, view.far_m = 1000;
            view.width = view.height = 256;
            scene.picture(target, view);
            const std::vector<float> depths = target.depths();
            const Camera camera = *make_camera(view, scene.map().grid, scene.map().codec);
            const ClipmapTwin twin(settings, camera, scene.map().grid, scene.map().codec, ground.field, bounds);
            double worst = 0, worst_against_truth = 0;
            int compared = 0;
            for (int py = 0; py < 256; ++py) {
                for (int px = 0; px < 256; ++px) {
                    const double d = depths[static_cast<std::size_t>(py * 256 + px)];
                    if (d <= 0) continue;                                      // off the map
                    const double away = 50.0 * 1000 / (d * (1000 - 50) + 50);  // depth = n (f - z) / (z (f - n))
                    const double tangent = std::tan(view.fov_y_rad / 2);
                    const double gx = x + (px + 0.5 - 128) / 128 * tangent * away;
                    const double gz = 201.77 - (py + 0.5 - 128) / 128 * tangent * away;  // north is up
                    if (gx < 1 || gz < 1 || gx > 511 || gz > 511 || twin.level_at(gx, gz) < 0) continue;
                    worst = std::max(worst, std::abs(twin.surface_m(gx, gz) + away));
                    worst_against_truth =
                        std::max(worst_against_truth, std::abs(scene.height_m(gx, gz) - view.eye.y + away));
                    ++compared;
                }
            }
            EXPECT_GT(compared, 20000);
            // Depth is float, 1 at 50 m: an ulp of 6e-8 at 400 m is 0.2 mm of distance, and as much again of position
            // on slopes below 45 degrees or so; interpolation on the rasteriser's 1/256 pixel grid moves a slope by 2
            // mm.
            EXPECT_LT(worst, 0.02) << "refined above " << refine_above_px << " px, eye at x " << x;
            EXPECT_GT(worst_against_truth, 0.3) << "the levels differ from the full map, or nothing was tested";
        }
    }
}

TEST_F(TerrainRendererGlTest, PictureIsTheSameFarFromTheOrigin) {
    const Mountains ground = mountains(257, 60);
    const Target target(320, 180);
    std::vector<std::uint8_t> here;
    for (const double far : {0.0, 1e3, 1e5, 1e7, -1e7}) {
        Scene scene(ground.field, ground.codec,
                    {.clipmap = {.n = 63, .levels = 3}, .origin = {far, -far}, .spacing_m = 0.1, .lift_m = far});
        View view;
        view.eye = {far + 10.7, far + 100, -far + 13.1};
        view.forward = {0.6, -0.5, -0.4};
        view.eye.y = far + std::round(scene.height_m(107, 131) - far + 4);
        Shading shading;
        shading.tint_low_m += far, shading.tint_high_m += far;
        const BrushCursor cursor{{far + 12.0, -far + 12.0}, 0.7, {1, 1, 0}};
        const std::vector<std::uint8_t> picture = scene.picture(target, view, shading, &cursor);
        if (here.empty()) here = picture;
        const Difference d = difference_of(here, picture);
        EXPECT_LE(d.max, 1) << "origin " << far;
        EXPECT_LT(d.mean, 0.01) << "origin " << far;
    }
    EXPECT_GT(levels_of_grey(here), 20) << "the picture shows something";
}

TEST_F(TerrainRendererGlTest, ReversedDepthGivesTheSamePicture) {
    const Mountains ground = mountains(257, 60);
    const Target target(320, 180);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 3}});
    View view = scene.view_from(100, 120, 3, towards(0.7, -0.1));
    view.near_m = 0.5;
    const std::vector<std::uint8_t> standard = scene.picture(target, view);
    view.depth = DepthConvention::Reversed;
    View infinite = view;
    infinite.far_m = std::numeric_limits<double>::infinity();
    if (!device().capabilities().clip_control) {
        view.width = view.height = 8;
        const Result<void> refused = scene.draw(view);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::Unsupported);
        return;
    }
    for (const View& reversed : {view, infinite}) {
        const std::vector<std::uint8_t> picture = scene.picture(target, reversed);
        int differing = 0;  // two depths that the standard convention cannot tell apart may swap a pixel
        for (std::size_t i = 0; i < picture.size(); i += 4) differing += std::abs(picture[i] - standard[i]) > 1;
        EXPECT_LE(differing, 3);
        int near_one = 0;
        for (const float depth : target.depths()) near_one += depth > 0.05f;
        EXPECT_GT(near_one, 0) << "1 is near";
    }
}

TEST_F(TerrainRendererGlTest, StraightDownAndUp) {
    const Mountains ground = mountains(257, 60);
    const Target target(96, 64);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 3}});
    const auto sky = [&](Vec3d forward) {
        const std::vector<std::uint8_t> picture = scene.picture(target, scene.view_from(128, 128, 20, forward));
        int count = 0;
        for (std::size_t i = 0; i < picture.size(); i += 4) count += is_magenta(&picture[i]);
        return count;
    };
    EXPECT_EQ(sky({0, -1, 0}), 0);
    EXPECT_EQ(sky({1e-12, -1, 0}), 0);
    EXPECT_EQ(sky({0, 1, 0}), 96 * 64);
}

TEST_F(TerrainRendererGlTest, DegenerateViews) {
    const Mountains ground = mountains(257, 60);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 3}});
    View view = scene.view_from(128, 128, 20, {1, -0.5, 0});
    const Target target(64, 64);
    target.clear(0, 0, 0);
    for (const auto& [width, height] : {std::pair{0, 0}, {0, 9}, {9, 0}}) {
        view.width = width, view.height = height;
        const std::uint64_t draws = scene.stats().draws;
        EXPECT_TRUE(scene.draw(view));
        EXPECT_EQ(scene.stats().draws, draws) << "nothing to draw on";
    }
    for (const auto& [width, height] : {std::pair{1, 1}, {16384, 1}, {1, 16384}}) {
        view.width = width, view.height = height;
        EXPECT_TRUE(scene.draw(view)) << width;
    }
    for (const double fov : {0.0, 3.14159265358979, -4.0, 100.0}) {
        view.width = view.height = 32, view.fov_y_rad = fov;
        EXPECT_TRUE(scene.draw(view)) << fov;
    }
    view.fov_y_rad = std::nan("");
    EXPECT_FALSE(scene.draw(view));
    view.fov_y_rad = 1, view.near_m = -1;
    EXPECT_FALSE(scene.draw(view));
    view.near_m = 0.1, view.eye = {1e30, 0, 0};
    EXPECT_TRUE(scene.draw(view)) << "out of reach of all ground";
}

// Everything that draw changes is on the guard's list; what the host had comes back.
TEST_F(TerrainRendererGlTest, HostStateComesBack) {
    const Mountains ground = mountains(257, 60);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 3}});
    const Target target(64, 64);
    target.bind();
    const gl::Api& gl = device().gl();
    gl.Viewport(3, 4, 5, 6);
    gl.Enable(GL_BLEND);
    gl.Enable(GL_SCISSOR_TEST);
    gl.DepthMask(GL_FALSE);
    gl.FrontFace(GL_CW);
    gl.DepthRange(0.25, 0.5);
    View view = scene.view_from(128, 128, 20, {1, -0.5, 0});
    view.width = view.height = 64;
    if (device().capabilities().clip_control) view.depth = DepthConvention::Reversed;
    const GlState before = capture_state(device());
    {
        const gl::StateGuard guard(device());
        ASSERT_TRUE(scene.draw(view));
    }
    EXPECT_EQ(difference(before, capture_state(device())), "");
    gl.Disable(GL_BLEND), gl.Disable(GL_SCISSOR_TEST), gl.DepthMask(GL_TRUE), gl.FrontFace(GL_CCW), gl.DepthRange(0, 1);
}

TEST_F(TerrainRendererGlTest, CullingChangesNoPixel) {
    const Mountains ground = mountains(513, 120);
    const Target target(320, 180);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 4}});
    std::uint32_t culled = 0;
    for (int i = 0; i < 40; ++i) {
        const View view = scene.view_from(60 + 9 * i, 450 - 10 * i, 1.7 + i, towards(i, -0.02 * i));
        scene.renderer().debug() = {};
        const std::vector<std::uint8_t> with = scene.picture(target, view);
        culled += scene.renderer().last_counts().culled_blocks;
        scene.renderer().debug() = {.cull_blocks = false};
        EXPECT_EQ(difference_of(with, scene.picture(target, view)).max, 0) << "view " << i;
        // On an outline, front and back may have the same depth; elsewhere a back lies behind a front.
        scene.renderer().debug() = {.cull_back_faces = false};
        const std::vector<std::uint8_t> backs = scene.picture(target, view);
        int differing = 0;
        for (std::size_t p = 0; p < with.size(); p += 4) differing += std::abs(with[p] - backs[p]) > 1;
        EXPECT_LE(differing, 5) << "view " << i;
    }
    EXPECT_GT(culled, 100u);
}

// 16 bits draw the same ground but for half a quantum of the high plane; RG16F and RG8 slopes look alike.
TEST_F(TerrainRendererGlTest, PrecisionsAndFormatsLookAlike) {
    const Mountains fine = mountains(257, 60), rough = mountains(257, 60, 7, HeightPrecision::bits16);
    const Target target(320, 180);
    std::vector<std::uint8_t> first;
    for (const auto precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
        for (const auto format : {SlopeFormat::rg8, SlopeFormat::rg16f}) {
            const Mountains& ground = precision == HeightPrecision::bits32 ? fine : rough;
            Scene scene(ground.field, ground.codec,
                        {.clipmap = {.n = 63, .levels = 3}, .precision = precision, .slopes = format});
            const std::vector<std::uint8_t> picture =
                scene.picture(target, scene.view_from(100, 120, 9, towards(0.7, -0.3)));
            if (first.empty()) first = picture;
            EXPECT_LT(difference_of(first, picture).mean, 0.8);
        }
    }
    EXPECT_GT(levels_of_grey(first), 20);
}

// A mirrored world shows the same ground from the mirrored place: the picture of a reflected camera is the reflection.
TEST_F(TerrainRendererGlTest, MirroredWorldReflects) {
    const Mountains ground = mountains(257, 60);
    const Target target(320, 180);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 4}, .mirrored = true});
    EXPECT_EQ(scene.renderer().last_post().x, (1 << 20) - 1);
    const double period = 512;
    Shading shading;
    shading.to_light = {0.9f, 0.6f, 0.4f};
    const View view = scene.view_from(100.25, 120.5, 9, {0.8, -0.3, 0.5});
    const std::vector<std::uint8_t> original = scene.picture(target, view, shading);
    // Whole periods away: the same picture, but for where windows snap (every 2^l posts: a multiple of 512 for all).
    View away = view;
    away.eye.x += 900 * period, away.eye.z += 1000 * period;
    EXPECT_LE(difference_of(original, scene.picture(target, away, shading)).max, 1);
    // Reflected in x: cells' diagonals run the other way there, so ground differs a little; as a whole it is the same.
    View reflected = view;
    reflected.eye.x = 300 * period - view.eye.x;
    reflected.eye.z += 300 * period;
    reflected.forward.x = -view.forward.x;
    shading.to_light.x = -shading.to_light.x;
    std::vector<std::uint8_t> picture = scene.picture(target, reflected, shading), flipped = picture;
    for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 320; ++x)
            std::copy_n(&picture[static_cast<std::size_t>(y * 320 + x) * 4], 4,
                        &flipped[static_cast<std::size_t>(y * 320 + 319 - x) * 4]);
    EXPECT_LT(difference_of(original, flipped).mean, 1.5);
    EXPECT_GT(difference_of(original, picture).mean, 5) << "the picture is not its own mirror image";
}

TEST_F(TerrainRendererGlTest, BrushCursorIsARingOnTheGround) {
    HeightField flat(257, 257);
    Scene scene(flat, HeightCodec::for_range(0, 10), {.clipmap = {.n = 63, .levels = 3}});
    const Target target(200, 200);
    View view;
    view.eye = {128, 5 + 20, 128};
    view.forward = {0, -1, 0};
    const BrushCursor cursor{{131, 126}, 4, {1, 0, 0}};
    Shading shading;
    const std::vector<std::uint8_t> without = scene.picture(target, view, shading);
    const std::vector<std::uint8_t> with = scene.picture(target, view, shading, &cursor);
    const double metres = 2 * 20 * std::tan(view.fov_y_rad / 2) / 200;  // a pixel
    int on = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 200; ++x) {
            const double away = std::hypot(128 + (x + 0.5 - 100) * metres - 131, 128 - (y + 0.5 - 100) * metres - 126);
            const std::size_t at = static_cast<std::size_t>(y * 200 + x) * 4;
            const bool changed = std::abs(with[at] - without[at]) > 20;
            on += changed;
            if (std::abs(away - 4) < 0.5 * metres) {
                EXPECT_TRUE(changed) << x << ", " << y;
            }
            if (std::abs(away - 4) > 2.5 * metres) {
                EXPECT_EQ(with[at], without[at]) << x << ", " << y;
            }
        }
    }
    EXPECT_GT(on, 100);
}

// Flat ground has a closed-form colour: low_colour (ambient + diffuse n.l), no specular towards the eye, no fog.
TEST_F(TerrainRendererGlTest, FlatGroundHasTheColourOfTheFormula) {
    HeightField flat(257, 257);
    const Target target(40, 40);
    for (const auto format : {SlopeFormat::rg8, SlopeFormat::rg16f}) {
        Scene scene(flat, HeightCodec::for_range(0, 10), {.clipmap = {.n = 63, .levels = 3}, .slopes = format});
        View view;
        view.eye = {128, 25, 128};
        view.forward = {0, -1, 0};
        Shading shading;
        shading.to_light = {0, 3, 4};
        shading.ambient = 0.3f, shading.diffuse = 0.5f, shading.specular = 0;
        shading.low_colour = {0.5f, 0.25f, 1.0f};
        shading.tint_low_m = 50, shading.tint_high_m = 60;
        const std::vector<std::uint8_t> clear = scene.picture(target, view, shading);
        const float light = 0.3f + 0.5f * 0.6f;
        for (std::size_t i = 0; i < clear.size(); i += 4) {
            ASSERT_NEAR(clear[i], 255 * 0.5 * light, 1);
            ASSERT_NEAR(clear[i + 1], 255 * 0.25 * light, 1);
            ASSERT_NEAR(clear[i + 2], 255 * 1.0 * light, 1);
        }
        shading.fog_density = 0.04, shading.fog_colour = {0, 1, 0};
        const std::vector<std::uint8_t> foggy = scene.picture(target, view, shading);
        const double seen = std::exp(-0.8 * 0.8);  // 20 m away in the middle
        EXPECT_NEAR(foggy[(20 * 40 + 20) * 4 + 1], 255 * (seen * 0.25 * light + (1 - seen)), 2);
    }
}

TEST_F(TerrainRendererGlTest, CountsItsWork) {
    const Mountains ground = mountains(257, 60);
    const Target target(64, 64);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 3}});
    scene.picture(target, scene.view_from(128, 128, 5, {1, -0.2, 0}));
    const RenderCounts& counts = scene.renderer().last_counts();
    EXPECT_GE(scene.stats().draws, 2u);
    EXPECT_LE(scene.stats().draws, 3u * 3u + 1u) << "three kinds of block a level, and the stitches";
    EXPECT_EQ(scene.stats().passes, 1u);
    EXPECT_EQ(scene.stats().primitives, counts.blocks * 2048ull + counts.stitches * 32ull);
    EXPECT_GT(counts.blocks, 0u);
    EXPECT_GT(counts.culled_blocks, 0u);
}

TEST_F(TerrainRendererGlTest, RefusesBadSettings) {
    gl::ShaderLibrary library = shaders();
    MapInfo map;
    map.grid = {{0, 0}, 1, 257, 257};
    map.codec = HeightCodec::for_range(0, 10);
    EXPECT_FALSE(TerrainRenderer::create(device(), library, {.n = 64}, map));
    map.grid.spacing_m = 0;
    EXPECT_FALSE(TerrainRenderer::create(device(), library, {}, map));
}

}  // namespace
}  // namespace tilth::test
