// Fine detail in the picture: the slopes that closed forms predict, the same across tile borders and far from the
// origin, fading without a step, and nothing at all where there is none.
#include <cmath>
#include <numbers>

#include "render/support/detail_tiles.h"
#include "render/support/picture_difference.h"
#include "support/gl_state.h"

namespace tilth::test {
namespace {

class DetailGlTest : public GlTest {};

/// Light without tint, gloss and fog: a colour has a closed form, ambient (1 + n.y) / 2 + diffuse n.l.
Shading plain_light() {
    Shading shading;
    shading.to_light = {0.48f, 0.64f, 0.6f};
    shading.ambient = 0.3f, shading.diffuse = 0.6f, shading.specular = 0;
    shading.low_colour = shading.high_colour = shading.steep_colour = {1, 1, 1};
    return shading;
}
/// In steps of 1/255.
double light_on(double slope_x, double slope_z) {
    const double length = std::sqrt(1 + slope_x * slope_x + slope_z * slope_z);
    const double facing = (-0.48 * slope_x + 0.64 - 0.6 * slope_z) / length;
    return 255 * (0.3 * (0.5 + 0.5 / length) + 0.6 * std::max(facing, 0.0));
}
/// The most that light_on changes per unit of slope: a unit normal turns by at most the change of slope.
constexpr double kLightPerSlope = 255 * (0.3 * 0.5 + 0.6);

/// Straight down, x to the right, z downwards.
View view_down(double x_m, double y_m, double z_m, double fov_y_rad = std::numbers::pi / 3) {
    View view;
    view.eye = {x_m, y_m, z_m};
    view.forward = {0, -1, 0};
    view.fov_y_rad = fov_y_rad;
    return view;
}

/// Ground of one height, 5 m; 0.1 m between posts.
struct FlatScene {
    explicit FlatScene(const SceneOptions& options = {.clipmap = {.n = 63, .levels = 3}, .spacing_m = 0.1},
                       std::int32_t posts = 257)
        : field(posts, posts), scene(field, HeightCodec::for_range(0, 10), options) {}
    HeightField field;
    Scene scene;
};

int red(const std::vector<std::uint8_t>& rgba, int width, int x, int y) {
    return rgba[static_cast<std::size_t>(y * width + x) * 4];
}

/// A field without a period that any tile could share: waves of 9 to 40 texels.
std::array<double, 2> waves(Texel t) {
    return {0.3 * std::sin(t.x * 0.31 + 0.7 * std::sin(t.z * 0.17)) + 0.1 * std::sin(t.z * 0.7),
            0.25 * std::cos(t.z * 0.27 + t.x * 0.05) + 0.1 * std::sin(t.x * 0.65 + 1)};
}

// Slopes of the map and of detail add up. Eye 2 m above a tilted plane, a pixel is a third of a texel.
TEST_F(DetailGlTest, ShadingIsThatOfTheSumOfSlopes) {
    const double plane_x = 0.2, plane_z = -0.1, steep = 0.3, wave = 2 * std::numbers::pi / 20;
    const HeightCodec codec = HeightCodec::for_range(0, 20);
    HeightField field(257, 257);
    for (std::int32_t z = 0; z < 257; ++z)
        for (std::int32_t x = 0; x < 257; ++x)
            field.set_code({x, z}, codec.code(8 + plane_x * x * 0.1 + plane_z * z * 0.1, HeightPrecision::bits32));
    const Target target(200, 120);
    for (const auto format : {SlopeFormat::rg8, SlopeFormat::rg16f}) {
        Scene scene(field, codec, {.clipmap = {.n = 63, .levels = 3}, .spacing_m = 0.1, .slopes = format});
        DetailTiles tiles(scene.map(), {.tile_size = 768, .reach_m = 1000}, [&](Texel t) {
            return std::array<double, 2>{steep * std::sin(wave * t.x), steep * std::cos(wave * t.z)};
        });
        const double x = 12.83, z = 11.77, above = 2;
        const View view = view_down(x, 8 + plane_x * x + plane_z * z + above, z);
        const auto picture = scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &tiles.view());
        // Linear interpolation: (wave steep) wave / 8 on each axis; weights of a filter have 8 bits.
        double slope_error = steep * wave * wave / 8 * std::sqrt(2) + steep * wave / 256 * 2;
        if (format == SlopeFormat::rg8) {  // half a step of 1/127, expanded by (1 + p)^2, on two axes, of either map;
            slope_error += std::sqrt(2) * 0.5 / 127 * (std::pow(1.43, 2) + std::pow(1.23, 2));
            slope_error += std::pow(steep * wave, 2) / 4;  // and interpolated as it is stored
        } else {
            slope_error += 0.43 / 1024 + 0.23 / 1024;
        }
        const double tolerance = 1 + kLightPerSlope * slope_error;
        EXPECT_LT(tolerance, 8) << "a fraction of the +-60 steps that detail makes";
        const double tangent = std::tan(std::numbers::pi / 6);
        double worst = 0, brightest = 0, darkest = 255;
        for (int py = 0; py < 120; ++py) {
            for (int px = 0; px < 200; ++px) {
                const double tx = ((px + 0.5) / 60 - 200 / 120.0) * tangent, tz = -((py + 0.5) / 60 - 1) * tangent;
                const double t = above / (1 + plane_x * tx + plane_z * tz);
                const double expected = light_on(plane_x + steep * std::sin(wave * (x + t * tx) * 30),
                                                 plane_z + steep * std::cos(wave * (z + t * tz) * 30));
                worst = std::max(worst, std::abs(red(picture, 200, px, py) - expected));
                brightest = std::max(brightest, expected), darkest = std::min(darkest, expected);
            }
        }
        EXPECT_LE(worst, tolerance);
        EXPECT_GT(brightest - darkest, 80);
    }
}

// One tile, four tiles that meet under the eye, small and large ones, windows here and there: the same picture. The
// programs differ (one sampler, four), the field does not. Outside the map tiles hold what must not be seen. Half
// floats: software GL filters bytes to bytes, and a step of those is three of the picture's.
TEST_F(DetailGlTest, BordersOfTilesDoNotShow) {
    FlatScene flat({.clipmap = {.n = 63, .levels = 3}, .spacing_m = 0.1, .slopes = SlopeFormat::rg16f},
                   129);  // 385 texels a side
    const auto continued = [](Texel t) { return waves({std::clamp(t.x, 0, 384), std::clamp(t.z, 0, 384)}); };
    const auto field = [](Texel t) {
        const bool inside = t.x >= 0 && t.z >= 0 && t.x <= 384 && t.z <= 384;
        return inside ? waves(t) : std::array<double, 2>{-1, 0.7};
    };
    const Target target(240, 160);
    const struct {
        double x, z, above_m;
        Vec3d forward;
        std::vector<DetailOptions> options;
    } cases[] = {{6.4,
                  6.4,
                  1.5,
                  {0.9, -0.7, 0.4},
                  {{.tile_size = 384},
                   {.tile_size = 64, .window = {{2, 2}, {3, 3}}},
                   {.tile_size = 128, .window = {{1, 1}, {1, 1}}},
                   {.tile_size = 128, .window = {{0, 0}, {1, 1}}},
                   {.tile_size = 128, .window = {{1, 1}, {2, 2}}},
                   {.tile_size = 192, .apron = 1, .window = {{0, 0}, {1, 1}}}}},
                 {6.4,
                  6.4,
                  0.6,
                  {-0.9, -0.45, 0.2},
                  {{.tile_size = 384},
                   {.tile_size = 64, .window = {{2, 2}, {3, 3}}},
                   {.tile_size = 128, .apron = 5, .window = {{1, 0}, {1, 1}}},
                   {.tile_size = 192, .window = {{0, 0}, {1, 1}}}}},
                 {11.3,  // the last post is at 12.8 m, in sight at a grazing angle, where taps reach beyond it
                  12.0,
                  0.25,
                  {1, -0.2, 0.3},
                  {{.tile_size = 448},
                   {.tile_size = 320, .window = {{0, 0}, {1, 1}}},
                   {.tile_size = 192, .window = {{1, 1}, {2, 2}}},
                   {.tile_size = 384, .window = {{0, 0}, {1, 1}}}}}};
    for (const auto& c : cases) {
        View view = flat.scene.view_from(c.x * 10, c.z * 10, c.above_m, c.forward);
        std::vector<std::uint8_t> first;
        const auto without = flat.scene.picture(target, view, plain_light());
        for (DetailOptions options : c.options) {
            options.reach_m = c.x > 10 ? 3 : 2;
            DetailTiles tiles(flat.scene.map(), options, first.empty() ? DetailSlopes(continued) : DetailSlopes(field));
            const auto picture = flat.scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &tiles.view());
            EXPECT_GT(difference_of(picture, without).max, 60) << "it shows something";
            if (first.empty()) first = picture;
            EXPECT_LE(difference_of(first, picture).max, 1)
                << "tiles of " << options.tile_size << " from " << options.window.min.x << " at " << c.x;
        }
    }
}

// From the eye outwards detail only loses weight, by no step, and is gone from the reach on to the last bit.
TEST_F(DetailGlTest, FadesOutWithDistance) {
    FlatScene flat;
    const double x = 12.8, z = 12.83, reach = 4, steep = 0.5, above = 3, tangent = std::tan(std::numbers::pi / 3);
    const View view = view_down(x, 5 + above, z, 2 * std::numbers::pi / 3);
    const Target target(400, 400);
    const double pixel_m = 2 * above * tangent / 400;
    const auto without = flat.scene.picture(target, view, plain_light());
    // Towards the light and away from it.
    for (const double slope : {steep, -steep}) {
        DetailTiles tiles(flat.scene.map(), {.tile_size = 832, .reach_m = reach}, [&](Texel) {
            return std::array<double, 2>{slope, 0};
        });
        const auto with = flat.scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &tiles.view());
        // smoothstep is at most 1.5 steep, over half the reach; one more for each of two roundings.
        const double most_per_pixel = 1.5 / (reach / 2) * pixel_m * kLightPerSlope * steep + 1;
        EXPECT_LT(most_per_pixel, 4);
        for (const int y : {200, 230, 300}) {
            int before = 1000;
            for (int px = 200; px < 400; ++px) {
                const double away = std::hypot((px + 0.5 - 200) * pixel_m, (y + 0.5 - 200) * pixel_m);
                const int step = std::abs(red(with, 400, px, y) - red(without, 400, px, y));
                const double t = std::clamp((reach - away) / (reach / 2), 0.0, 1.0), weight = t * t * (3 - 2 * t);
                EXPECT_NEAR(red(with, 400, px, y), light_on(slope * weight, 0),
                            1.5 + kLightPerSlope * 0.5 / 127 * std::pow(1.5, 2))
                    << px;
                if (before < 1000) {
                    EXPECT_LE(step, before) << px;
                    EXPECT_LE(before - step, most_per_pixel) << px;
                }
                before = step;
                if (away >= reach) {
                    ASSERT_EQ(red(with, 400, px, y), red(without, 400, px, y)) << px;
                }
            }
        }
        EXPECT_GT(std::abs(red(with, 400, 200, 200) - red(without, 400, 200, 200)), 15);
    }
}

// From above, a pixel covers more and more texels: detail is whole up to 2 texels a pixel and gone from 8 on.
TEST_F(DetailGlTest, FadesOutWithResolution) {
    FlatScene flat;
    const Target target(40, 40);
    DetailTiles tiles(flat.scene.map(), {.tile_size = 832, .reach_m = 1000}, [](Texel) {
        return std::array<double, 2>{0.5, 0};
    });
    double before = 1000;
    for (const double texels : {0.3, 0.9, 1.2, 1.9, 3.0, 4.0, 5.0, 6.0, 7.0, 7.9, 8.1, 12.0}) {
        const double above = texels / 30 * 20 / std::tan(0.2);
        const View view = view_down(12.8, 5 + above, 12.8, 0.4);
        const auto without = flat.scene.picture(target, view, plain_light());
        const auto with = flat.scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &tiles.view());
        const double t = std::clamp((4 - texels / 2) / 3, 0.0, 1.0), weight = t * t * (3 - 2 * t);
        EXPECT_NEAR(red(with, 40, 20, 20), light_on(0.5 * weight, 0), 1.5 + kLightPerSlope * 0.5 / 127 * 2.25)
            << texels;
        const int step = std::abs(red(with, 40, 20, 20) - red(without, 40, 20, 20));
        EXPECT_LE(step, before);
        before = step;
        if (texels > 8) {
            EXPECT_EQ(step, 0);
        }
    }
}

// Where a pixel covers more than a texel, taps average: waves shorter than a pixel turn grey, not into other waves.
TEST_F(DetailGlTest, PixelsOfManyTexelsAverage) {
    FlatScene flat;
    const Target target(64, 64);
    const double texels = 3;  // a pixel: waves of 3.3 texels, sampled once a pixel, would be waves of 33 texels
    const View view = view_down(12.8, 5 + texels / 30 * 32 / std::tan(0.2), 12.8, 0.4);
    DetailTiles tiles(flat.scene.map(), {.tile_size = 832, .reach_m = 1000}, [](Texel t) {
        return std::array<double, 2>{0.4 * std::sin(2 * std::numbers::pi / 3.3 * t.x), 0};
    });
    const auto with = flat.scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &tiles.view());
    int lowest = 255, highest = 0;
    for (int x = 0; x < 64; ++x) {
        lowest = std::min(lowest, red(with, 64, x, 32));
        highest = std::max(highest, red(with, 64, x, 32));
    }
    // Taps 0.35 and 1.06 texels to either side leave (cos(2 pi 0.35 / 3.3) + cos(2 pi 1.06 / 3.3)) / 2 = 0.17 of the
    // wave's +-0.4: a swing of 26 steps at most. One tap would leave 50 or more.
    EXPECT_LT(highest - lowest, 27);
}

TEST_F(DetailGlTest, IsTheSameFarFromTheOrigin) {
    const Mountains ground = mountains(257, 10);
    const Target target(240, 160);
    std::vector<std::uint8_t> here, bare;
    for (const double far : {0.0, 1e5, 1e7, -1e7}) {
        Scene scene(ground.field, ground.codec,
                    {.clipmap = {.n = 63, .levels = 3}, .origin = {far, -far}, .spacing_m = 0.1, .lift_m = far});
        DetailTiles tiles(scene.map(), {.tile_size = 256, .window = {{1, 1}, {2, 2}}, .reach_m = 8}, waves);
        View view;
        view.eye = {far + 15.7, far + std::round(scene.height_m(157, 161) - far + 2), -far + 16.1};
        view.forward = {0.7, -0.4, 0.5};
        const auto picture = scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &tiles.view());
        if (here.empty()) here = picture, bare = scene.picture(target, view, plain_light());
        EXPECT_LE(difference_of(here, picture).max, 1) << "origin " << far;
    }
    EXPECT_GT(difference_of(here, bare).mean, 3) << "detail shows";
}

// A world of 2^20 posts by reflection, 64 texels a post: at texel 2^26 detail looks as it does near the origin, and as
// it does on ground that is not reflected (the eye stands where the coarse map runs backwards).
TEST_F(DetailGlTest, IsTheSameAtTexelTwoToThe26AndNotReflected) {
    const Target target(240, 160);
    std::vector<std::uint8_t> first;
    const auto draw = [&](bool mirrored, std::int32_t posts, std::int32_t away_posts) {
        FlatScene flat({.clipmap = {.n = 63, .levels = 3}, .mirrored = mirrored}, posts);
        const std::int32_t tile = 256, first_tile = (396 + away_posts) * 64 / tile;
        const auto field = [&](Texel t) { return waves({t.x - away_posts * 64, t.z - away_posts * 64}); };
        DetailTiles tiles(flat.scene.map(),
                          {.texels_per_post = 64,
                           .tile_size = tile,
                           .window = {{first_tile, first_tile}, {first_tile + 1, first_tile + 1}},
                           .reach_m = 3.4},
                          field);
        View view;
        view.eye = {400.3 + away_posts, 6.5, 399.6 + away_posts};
        view.forward = {0.6, -0.7, 0.5};
        const auto picture = flat.scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &tiles.view());
        if (first.empty()) first = picture;
        EXPECT_LE(difference_of(first, picture).max, 1) << mirrored << ", " << away_posts;
        EXPECT_GT(flat.scene.renderer().last_counts().detail_blocks, 0u);
    };
    draw(false, 1025, 0);
    EXPECT_GT(levels_of_grey(first), 60);
    draw(true, 257, 0);
    draw(true, 257, 1023 * 1024);
}

// Tiles that are not there add nothing, to the last bit; the others do not care.
TEST_F(DetailGlTest, MissingTilesAddNothing) {
    FlatScene flat;
    const Target target(200, 200);
    const View view = view_down(12.8, 5 + 2, 12.8);
    const DetailOptions options{.tile_size = 384, .window = {{0, 0}, {1, 1}}, .reach_m = 1000};
    DetailTiles all(flat.scene.map(), options, waves), some(flat.scene.map(), options, waves, {1, 2});
    const auto without = flat.scene.picture(target, view, plain_light());
    const auto with_all = flat.scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &all.view());
    const auto with_some = flat.scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, &some.view());
    int missing = 0, changed = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 200; ++x) {
            const bool right = x >= 100, below = y < 100;  // z grows downwards
            const int got = red(with_some, 200, x, y);
            if (right != below) {
                EXPECT_EQ(got, red(without, 200, x, y)) << x << ", " << y;
                ++missing;
            } else {
                EXPECT_EQ(got, red(with_all, 200, x, y)) << x << ", " << y;
                changed += got != red(without, 200, x, y);
            }
        }
    }
    EXPECT_EQ(missing, 20000);
    EXPECT_GT(changed, 15000);
}

// Without detail, with none in reach, and with tiles that are all missing: the work, the objects and the pixels of a
// renderer that never heard of it. With detail: four programs, once, and only blocks in reach.
TEST_F(DetailGlTest, CostsNothingWhereThereIsNone) {
    const Mountains ground = mountains(257, 10);
    Scene scene(ground.field, ground.codec, {.clipmap = {.n = 63, .levels = 3}, .spacing_m = 0.1});
    const Target target(240, 160);
    const View view = scene.view_from(128, 128, 2, {1, -0.4, 0.3});
    const auto frame = [&](const DetailView* detail, std::vector<std::uint8_t>* picture = nullptr) {
        gl::StageStats before = scene.stats();
        auto pixels = scene.picture(target, view, plain_light(), nullptr, {1, 0, 1}, detail);
        if (picture != nullptr) *picture = std::move(pixels);
        gl::StageStats after = scene.stats();
        return std::array<std::uint64_t, 5>{after.passes - before.passes, after.draws - before.draws,
                                            after.primitives - before.primitives, after.bytes - before.bytes,
                                            after.programs - before.programs};
    };
    DetailTiles tiles(scene.map(), {.tile_size = 256, .window = {{1, 1}, {2, 2}}, .reach_m = 3}, waves);
    DetailTiles missing(scene.map(), {.tile_size = 256, .window = {{1, 1}, {2, 2}}, .reach_m = 3}, waves, {0, 1, 2, 3});
    DetailTiles elsewhere(scene.map(), {.tile_size = 64, .window = {{0, 0}, {1, 1}}, .reach_m = 3}, waves);
    DetailView no_reach = tiles.view();
    no_reach.reach_m = 0;
    const DetailView nowhere;
    std::vector<std::uint8_t> bare, none_there, picture, again;
    const auto cost = frame(nullptr, &bare);
    EXPECT_EQ(cost[4], 0u);
    const std::size_t objects = device().live_objects().size();
    const std::uint64_t bytes = device().resident_bytes();
    const auto same_as_bare = [&] {
        for (const DetailView* none : {static_cast<const DetailView*>(nullptr), &nowhere, &std::as_const(no_reach),
                                       &std::as_const(missing.view()), &std::as_const(elsewhere.view())}) {
            EXPECT_EQ(frame(none, &none_there), cost);
            EXPECT_EQ(difference_of(bare, none_there).max, 0);
            EXPECT_EQ(scene.renderer().last_counts().detail_blocks, 0u);
        }
    };
    same_as_bare();
    EXPECT_EQ(device().live_objects().size(), objects);
    EXPECT_EQ(device().resident_bytes(), bytes);

    const auto first = frame(&tiles.view(), &picture);
    EXPECT_EQ(first[4], 4u);
    EXPECT_GT(difference_of(bare, picture).max, 30);
    const RenderCounts counts = scene.renderer().last_counts();
    EXPECT_GT(counts.detail_blocks, 0u);
    EXPECT_LT(counts.detail_blocks, counts.blocks);
    const auto second = frame(&tiles.view(), &again);
    EXPECT_EQ(second[4], 0u);
    EXPECT_EQ(second[1] + 4, first[1]) << "programs are drawn with once when they are made";
    EXPECT_EQ(second[2], cost[2]);
    EXPECT_EQ(second[3], cost[3]);
    EXPECT_EQ(difference_of(picture, again).max, 0) << "the first frame with detail is as good as any";
    same_as_bare();

    gl::ShaderLibrary library = shaders();
    ASSERT_TRUE(scene.renderer().reload(library));
    frame(&tiles.view(), &again);
    EXPECT_EQ(difference_of(picture, again).max, 0) << "reloaded";
}

// What the guard puts back includes the units of the tiles; units 8 and up are the host's and are not touched at all.
TEST_F(DetailGlTest, HostStateComesBack) {
    FlatScene flat;
    DetailTiles tiles(flat.scene.map(), {.tile_size = 384, .window = {{0, 0}, {1, 1}}, .reach_m = 8}, waves, {3});
    const Target target(64, 64);
    target.bind();
    const gl::Api& gl = device().gl();
    const gl::Texture2D hosts = value(gl::Texture2D::create(device(), "host", {.width = 4, .height = 4}));
    for (int unit = 0; unit < 16; ++unit) hosts.bind(unit);
    View view = flat.scene.view_from(128, 128, 2, {0.2, -1, 0});
    view.width = view.height = 64;
    const GlState before = capture_state(device());
    {
        const gl::StateGuard guard(device());
        ASSERT_TRUE(flat.scene.draw(view, {}, nullptr, &tiles.view()));
    }
    EXPECT_EQ(difference(before, capture_state(device())), "");
    ASSERT_TRUE(flat.scene.draw(view, {}, nullptr, &tiles.view()));
    for (unsigned unit = 0; unit < 16; ++unit) {
        int bound = 0;
        gl.ActiveTexture(GL_TEXTURE0 + unit);
        gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
        if (unit >= 8) {
            EXPECT_EQ(static_cast<unsigned>(bound), hosts.id()) << "unit " << unit;
        }
    }
}

}  // namespace
}  // namespace tilth::test
