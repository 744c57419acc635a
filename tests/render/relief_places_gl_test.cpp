// Detail backends in awkward places: far from the origin, at the map's edges and corners, on lattices of any density,
// with the eye inside the ground.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "render/support/holes.h"
#include "render/support/picture_difference.h"
#include "support/gl_context.h"
#include "tilth/source/analytic_sources.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth::test {
namespace {

struct WorldOptions {
    WorldPos origin;
    std::int32_t texels_per_post = 3, tile_size = 256, posts = 257;
    ClipmapSettings clipmap{.n = 63, .levels = 4, .blend = 0.1};
    bool flat = false;
};

class ReliefPlacesGlTest : public GlTest {
protected:
    static constexpr double kSpacingM = 0.125;  // exact in binary: far away places are the same places

    static std::unique_ptr<Terrain> terrain(const WorldOptions& options) {
        TerrainSettings settings{
            .executor = ExecutorKind::Cpu, .clipmap = options.clipmap, .shader_folder = TILTH_SOURCE_DIR "/shaders"};
        settings.ground = {.origin = options.origin,
                           .spacing_m = kSpacingM,
                           .texels_per_post = options.texels_per_post,
                           .tile_size = options.tile_size};
        std::shared_ptr<const HeightSource> source;
        if (options.flat)
            source = std::make_shared<FlatSource>(options.posts, 0.0);
        else
            source = make_ridged_source({.seed = 11, .size = options.posts, .relief_m = 4});
        return value(Terrain::create(source, settings, test_context(default_route()).context->get_proc()));
    }
    static DetailSettings exact(DetailBackend backend) { return detail_preset(backend, DetailPreset::Exact); }
    static bool show(Terrain& ground, const DetailSettings& settings) { return ground.set_detail(settings).ok(); }

    struct Frame {
        std::vector<std::uint8_t> rgba;
        std::vector<float> depth;
    };
    /// Clear black shows what is not a number as what is not ground.
    static Frame draw(Terrain& ground, const Target& target, View view) {
        const WorldPos viewer{view.eye.x, view.eye.z};
        ground.set_viewers({&viewer, 1});
        EXPECT_TRUE(ground.update(0));
        EXPECT_TRUE(ground.drain());
        view.width = target.width(), view.height = target.height();
        target.clear(1, 0, 1);
        const Result<void> drawn = ground.draw(view, {.to_light = {0.5f, 0.45f, 0.3f}});
        EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
        return {target.pixels(), target.depths()};
    }
    static void stamp(Terrain& ground, StampRequest request) {
        request.map = MapChoice::Detail;
        const Result<StampRecord> done = ground.stamp(request);
        EXPECT_TRUE(done) << (done ? "" : done.error().message);
        EXPECT_TRUE(ground.update(0));
    }
    static ShapeId noise(Terrain& ground, int side) {
        return value(ground.shapes().bake("noise", side, [](double x, double z) {
            const auto at = static_cast<std::uint32_t>((x + 1) * 700) * 0x9e3779b1u ^
                            static_cast<std::uint32_t>((z + 1) * 700) * 0x85ebca77u;
            const std::uint32_t mixed = (at ^ (at >> 15)) * 0x2c1b3c6du;
            return static_cast<double>((mixed ^ (mixed >> 13)) & 0xffffu) / 32767.5 - 1;
        }));
    }
    static constexpr DetailBackend kBackends[] = {DetailBackend::Parallax, DetailBackend::Geometry,
                                                  DetailBackend::Tessellation, DetailBackend::Hybrid};
    static constexpr DetailBackend kAll[] = {DetailBackend::None, DetailBackend::Parallax, DetailBackend::Geometry,
                                             DetailBackend::Tessellation, DetailBackend::Hybrid};
};

// The same ground, the same eye in it. Origins are whole multiples of a post, so that places are the same to the bit.
TEST_F(ReliefPlacesGlTest, PictureIsTheSameFarFromTheOrigin) {
    const Target target(240, 135);
    std::array<Frame, std::size(kAll)> here;
    for (const double far : {0.0, 1e5, 1e7, -1e7}) {
        const std::unique_ptr<Terrain> ground = terrain({.origin = {far, -far}});
        for (int i = 0; i < 60; ++i)
            stamp(*ground, {.shape = {static_cast<std::uint32_t>(i % kBuiltinProfiles)},
                            .centre = {far + 14.5 + 0.0625 * std::floor(64 * std::fmod(i * 0.618034, 1.0)),
                                       -far + 14.0 + 0.0625 * i},
                            .radius_m = 0.25 + 0.0625 * (i % 5),
                            .amplitude_m = i % 3 == 0 ? 0.08 : -0.08});
        const Vec3d eye{far + 14.25, std::round(ground->height_m({far + 14.25, -far + 16.5}) * 8) / 8 + 1.25,
                        -far + 16.5};
        for (std::size_t b = 0; b < std::size(kAll); ++b) {
            if (!show(*ground, exact(kAll[b]))) continue;
            const Frame frame =
                draw(*ground, target, {.eye = eye, .forward = {1, -0.6, -0.1}, .near_m = 0.1, .far_m = 500});
            if (far == 0.0) {
                here[b] = frame;
                if (b > 0) {
                    EXPECT_GT(difference_of(here[0].rgba, frame.rgba).max, 30) << "relief is in sight";
                }
                continue;
            }
            const Difference d = difference_of(here[b].rgba, frame.rgba);
            EXPECT_LE(d.max, 1) << name_of(kAll[b]) << " at " << far;
            double depth = 0;
            for (std::size_t p = 0; p < frame.depth.size(); ++p)
                depth = std::max(depth, std::abs(double(frame.depth[p]) - double(here[b].depth[p])));
            EXPECT_LE(depth, 1e-6) << name_of(kAll[b]) << " at " << far;
        }
    }
}

// Prints across the map's edge and its corner, the eye there and beyond. Relief is below the coarse ground here, so
// that it may show where sky was and never cover it; and no pixel within the map's outline turns to sky.
TEST_F(ReliefPlacesGlTest, NoHoleAtTheMapsEdgesAndCorners) {
    const Target target(160, 90);
    const WorldOptions options{.flat = true};
    const double end = (options.posts - 1) * kSpacingM;
    const std::unique_ptr<Terrain> ground = terrain(options);
    const WorldPos places[] = {{0, 0},     {end, end}, {0, end}, {end, 0}, {end / 2, 0}, {end, end / 2 + 0.06},
                               {0.02, 7.1}};
    for (const WorldPos& at : places)
        for (int i = 0; i < 12; ++i)
            stamp(*ground, {.shape = {static_cast<std::uint32_t>(i % kBuiltinProfiles)},
                            .centre = {at.x + 0.3 * (i % 4) - 0.45, at.z + 0.3 * (i / 4) - 0.3},
                            .radius_m = 0.25,
                            .amplitude_m = i % 2 == 0 ? -0.06 : 0.06});
    const Vec3d looks[] = {{0.02, -1, 0.01}, {1, -0.5, 0.3}, {-1, -0.5, -0.2}, {0.1, -0.6, -1}};
    long relief = 0;
    for (const WorldPos& at : places) {
        for (const double beyond : {0.0, 0.8}) {
            // Away from the map's middle.
            const WorldPos from{at.x + (at.x < end / 2 ? -beyond : beyond), at.z + (at.z < end / 2 ? -beyond : beyond)};
            for (const Vec3d& forward : looks) {
                const View view{.eye = {from.x, 1.2, from.z}, .forward = forward, .near_m = 0.05, .far_m = 300};
                ASSERT_TRUE(show(*ground, {}));
                const Frame none = draw(*ground, target, view);
                for (const DetailBackend backend : kBackends) {
                    if (!show(*ground, exact(backend))) continue;
                    const Frame frame = draw(*ground, target, view);
                    long missing = 0;
                    for (int y = 1; y + 1 < 90; ++y)
                        for (int x = 1; x + 1 < 160; ++x) {
                            bool inside = true;
                            // A dent at the very edge opens the sky behind it; as far as its depth looks: 6 cm at 1.2 m
                            // and the picture's 90 pixels for 60 degrees, 4 pixels at most, are not judged.
                            for (int dy = -4; dy <= 4 && inside; ++dy)
                                for (int dx = -4; dx <= 4 && inside; ++dx) {
                                    const int px = std::clamp(x + dx, 0, 159), py = std::clamp(y + dy, 0, 89);
                                    inside = !is_magenta(&none.rgba[static_cast<std::size_t>(py * 160 + px) * 4]);
                                }
                            missing += inside && is_magenta(&frame.rgba[static_cast<std::size_t>(y * 160 + x) * 4]);
                        }
                    EXPECT_EQ(missing, 0) << name_of(backend) << " at " << from.x << ", " << from.z << " looking "
                                          << forward.x << ", " << forward.z;
                    if (missing > 0)
                        keep_picture(text("edge_", name_of(backend), from.x, "_", from.z, "_", forward.x), frame.rgba,
                                     160, 90);
                    for (const float d : frame.depth) ASSERT_TRUE(d >= 0 && d <= 1) << name_of(backend);
                    relief += frame.rgba != none.rgba;
                }
            }
        }
    }
    EXPECT_GT(relief, 60) << "pictures with relief in them";
}

// Noise in every texel about the eye, however many there are to a post.
TEST_F(ReliefPlacesGlTest, NoHoleWithAnyNumberOfTexelsAPost) {
    const Target target(160, 90);
    for (const std::int32_t per_post : {1, 2, 5, 16, 64}) {
        const std::unique_ptr<Terrain> ground =
            terrain({.texels_per_post = per_post,
                     .tile_size = std::max(256, 64 * per_post),
                     .posts = 129,
                     .clipmap = {.n = per_post <= 5 ? 63 : 31, .levels = 3, .blend = 0.1}});
        const double reach_m = per_post <= 5 ? 3.5 : 1.2;
        const double scale = per_post <= 5 ? 1 : 0.4;  // relief ends with the largest window
        const WorldPos middle{8.1, 8.05};
        stamp(*ground, {.shape = noise(*ground, 512), .centre = middle, .radius_m = reach_m, .amplitude_m = 0.05});
        const double eye_m = ground->height_m(middle, MapSelect::Coarse);
        const struct {
            Vec3d forward;
            double above_m;
        } looks[] = {{{0.02, -1, 0.01}, 0.9}, {{1, -0.7, 0.2}, 0.5}, {{-0.3, -0.35, 1}, 1.5}};
        for (const auto& look : looks) {
            const View view{.eye = {middle.x, eye_m + look.above_m * scale, middle.z},
                            .forward = look.forward,
                            .near_m = 0.02,
                            .far_m = 300};
            Frame none;
            for (const DetailBackend backend : kAll) {
                if (!show(*ground, exact(backend))) continue;
                const Frame frame = draw(*ground, target, view);
                const long holes = look.forward.y < -0.9
                                       ? magenta_pixels(frame.rgba)
                                       : sky_within_ground(frame.rgba, target.width(), target.height());
                EXPECT_EQ(holes, 0) << name_of(backend) << ", " << per_post << " texels a post, " << look.above_m;
                if (holes > 0)
                    keep_picture(text("lattice_", name_of(backend), "_", per_post, "_", look.above_m), frame.rgba, 160,
                                 90);
                if (backend == DetailBackend::None)
                    none = frame;
                else
                    EXPECT_GT(difference_of(frame.rgba, none.rgba).max, 4)
                        << name_of(backend) << ", " << per_post << " texels a post";
            }
        }
    }
}

// A patch of noise that ends at a border between blocks, or a few texels before it: the block behind must split the
// edges that they share, or leave them be, as the other does. The eye walks, and the borders with it.
TEST_F(ReliefPlacesGlTest, NoHoleWhereBlocksOfReliefMeetBlocksWithout) {
    const Target target(200, 112);
    for (const std::int32_t per_post : {3}) {
        const std::unique_ptr<Terrain> ground = terrain({.texels_per_post = per_post,
                                                         .tile_size = 1024,
                                                         .posts = 257,
                                                         .clipmap = {.n = 127, .levels = 3, .blend = 0.1}});
        const WorldPos patch{16, 16};
        const double half_m = 0.875;
        stamp(*ground, {.shape = noise(*ground, 128), .centre = patch, .radius_m = half_m, .amplitude_m = 0.12});
        for (int i = 0; i < 18; ++i) {
            // Blocks are 32 posts of 0.125 m wide and move by two posts.
            const WorldPos at{patch.x - 2.1 + 0.25 * i, patch.z + 1.9 - 0.25 * (i * 7 % 18)};
            const double eye_m = ground->height_m(at) + (i % 2 == 0 ? 0.7 : 1.8);
            const Vec3d forward{patch.x - at.x + 0.01, i % 2 == 0 ? -1.2 : -1.8, patch.z - at.z};
            for (const DetailBackend backend : {DetailBackend::Geometry, DetailBackend::Tessellation}) {
                if (!show(*ground, exact(backend))) continue;
                const Frame frame = draw(
                    *ground, target, {.eye = {at.x, eye_m, at.z}, .forward = forward, .near_m = 0.02, .far_m = 300});
                const long holes = sky_within_ground(frame.rgba, target.width(), target.height());
                EXPECT_EQ(holes, 0) << name_of(backend) << ", " << per_post << " texels a post, step " << i;
                if (holes > 0) keep_picture(text("patch_", name_of(backend), per_post, "_", i), frame.rgba, 200, 112);
            }
        }
    }
}

// The eye below the ground, in a needle of 8 m, at a crater's wall: something finite is drawn. Colours are read as
// floats, where nothing hides what is not a number.
TEST_F(ReliefPlacesGlTest, TheEyeInsideTheGroundDrawsFiniteFrames) {
    constexpr int kWidth = 96, kHeight = 54;
    gl::Texture2D colour =
        value(gl::Texture2D::create(device(), "float colour", {gl::Format::Rgba32F, kWidth, kHeight}));
    gl::Texture2D depth =
        value(gl::Texture2D::create(device(), "float depth", {gl::Format::Depth32F, kWidth, kHeight}));
    gl::Framebuffer framebuffer = value(gl::Framebuffer::create(device(), "float target"));
    const gl::Texture2D* colours[] = {&colour};
    framebuffer.attach(colours, 0, &depth);
    const std::unique_ptr<Terrain> ground = terrain({});
    const WorldPos needle{14, 14}, crater{16, 15};
    const ShapeId spike =
        value(ground->shapes().bake("spike", 9, [](double x, double z) { return std::hypot(x, z) < 0.3 ? 1.0 : 0.0; }));
    stamp(*ground, {.shape = spike, .centre = needle, .radius_m = 0.15, .amplitude_m = 8});
    stamp(*ground, {.shape = {static_cast<std::uint32_t>(BuiltinProfile::Crater)},
                    .centre = crater,
                    .radius_m = 1.2,
                    .amplitude_m = -1.5});
    const double needle_m = ground->height_m(needle, MapSelect::Coarse),
                 crater_m = ground->height_m(crater, MapSelect::Coarse);
    EXPECT_GT(ground->height_m(needle), needle_m + 6);
    const Vec3d eyes[] = {{needle.x, needle_m - 0.5, needle.z},
                          {needle.x, needle_m + 4, needle.z},
                          {needle.x + 0.01, needle_m + 0.01, needle.z},
                          {crater.x + 0.7, crater_m - 0.3, crater.z},
                          {crater.x, crater_m - 1.2, crater.z},
                          {crater.x, crater_m, crater.z},
                          {15, needle_m - 30, 15},
                          {15, -1e5, 15}};
    const Vec3d looks[] = {{1, 0, 0.01}, {0.01, -1, 0}, {-0.5, 0.5, 0.7}};
    long drawn_pixels = 0;
    for (const DetailBackend backend : kAll) {
        for (const DetailPreset preset : {DetailPreset::High, DetailPreset::Exact}) {
            if (!show(*ground, detail_preset(backend, preset))) continue;
            for (const Vec3d& eye : eyes) {
                const WorldPos viewer{eye.x, eye.z};
                ground->set_viewers({&viewer, 1});
                ASSERT_TRUE(ground->update(0));
                ASSERT_TRUE(ground->drain());
                for (const Vec3d& forward : looks) {
                    const gl::Api& gl = device().gl();
                    framebuffer.bind();
                    gl.ClearColor(-1, -1, -1, 1);
                    gl.ClearDepth(1);
                    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
                    const Result<void> done = ground->draw({.eye = eye,
                                                            .forward = forward,
                                                            .width = kWidth,
                                                            .height = kHeight,
                                                            .near_m = 0.05,
                                                            .far_m = 300},
                                                           {.to_light = {0.5f, 0.45f, 0.3f}});
                    ASSERT_TRUE(done) << done.error().message;
                    std::vector<float> rgba(std::size_t{kWidth} * kHeight * 4), depths(std::size_t{kWidth} * kHeight);
                    framebuffer.read(colour.bounds(), gl::Format::Rgba32F, rgba.data());
                    framebuffer.read(depth.bounds(), gl::Format::Depth32F, depths.data());
                    for (std::size_t p = 0; p < depths.size(); ++p) {
                        ASSERT_TRUE(depths[p] >= 0 && depths[p] <= 1) << depths[p];
                        const float* c = &rgba[p * 4];
                        const bool sky = c[0] == -1 && c[1] == -1 && c[2] == -1;
                        drawn_pixels += !sky;
                        for (int i = 0; i < 3 && !sky; ++i)
                            ASSERT_TRUE(c[i] >= 0 && c[i] <= 16)
                                << name_of(backend) << " " << name_of(preset) << ": " << c[i];
                    }
                }
            }
        }
    }
    EXPECT_GT(drawn_pixels, 100000);
}

}  // namespace
}  // namespace tilth::test
