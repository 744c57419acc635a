// Debug views tell the truth: levels, tiles and zones where they are, fetches and errors where there are any; and who
// never looks at them does not pay.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "render/support/relief_world.h"
#include "tilth/gl/api.h"

namespace tilth::test {
namespace {

constexpr int kWidth = 240, kHeight = 135;

using Rgb = std::array<int, 3>;
constexpr Rgb kBackground{255, 0, 255};

/// A pixel of a view over flat ground at height 0.
struct Seen {
    Rgb colour;
    WorldPos at;            ///< of the ground
    double distance_m = 0;  ///< from the eye
};

/// Where the ray through a pixel's centre meets the plane y = 0; far away where it does not.
Seen seen_by(const View& view, int x, int y_up, const Rgb& colour) {
    const Vec3d& f = view.forward;
    const double length = std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z), flat = std::hypot(f.x, f.z);
    const Vec3d ahead{f.x / length, f.y / length, f.z / length}, right{-f.z / flat, 0, f.x / flat};
    const Vec3d up{right.y * ahead.z - right.z * ahead.y, right.z * ahead.x - right.x * ahead.z,
                   right.x * ahead.y - right.y * ahead.x};
    const double t = std::tan(view.fov_y_rad / 2);
    const double sx = ((x + 0.5) / view.width * 2 - 1) * t * view.width / view.height,
                 sy = ((y_up + 0.5) / view.height * 2 - 1) * t;
    const Vec3d ray{ahead.x + sx * right.x + sy * up.x, ahead.y + sx * right.y + sy * up.y,
                    ahead.z + sx * right.z + sy * up.z};
    if (ray.y >= -1e-9) return {colour, {1e9, 1e9}, 1e9};
    const double way = view.eye.y / -ray.y;
    return {colour,
            {view.eye.x + way * ray.x, view.eye.z + way * ray.z},
            way * std::sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z)};
}

double distance_m(WorldPos a, WorldPos b) { return std::hypot(a.x - b.x, a.z - b.z); }

/// Colours up to their brightness.
bool same_hue(const Rgb& a, const std::array<double, 3>& b) {
    const double most_a = std::max({a[0], a[1], a[2], 1}), most_b = std::max({b[0], b[1], b[2]});
    for (std::size_t i = 0; i < 3; ++i)
        if (std::abs(a[i] / most_a - b[i] / most_b) > 1.5 / most_a + 0.01) return false;
    return true;
}

class DebugViewGlTest : public GlTest {
protected:
    static DetailSettings settings(DetailBackend backend, DebugView debug, DetailPreset preset = DetailPreset::Medium) {
        DetailSettings made = detail_preset(backend, preset);
        made.debug_view = debug;
        return made;
    }
    /// Skips what the context cannot do.
    static bool show(ReliefWorld& world, const DetailSettings& wanted) {
        std::string why;
        const bool shown = world.show(wanted, &why);
        if (!shown) std::printf("%s\n", why.c_str());
        return shown;
    }
    /// The pixels that ground covers.
    static std::vector<Seen> look(ReliefWorld& world, const View& view) {
        const Target target(view.width, view.height);
        const Frame frame = world.draw(target, view);
        std::vector<Seen> all;
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const auto at =
                    (static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(x)) *
                    4;
                const Rgb colour{frame.rgba.at(at), frame.rgba.at(at + 1), frame.rgba.at(at + 2)};
                if (colour != kBackground) all.push_back(seen_by(view, x, y, colour));
            }
        return all;
    }
    static int brightest(const std::vector<Seen>& all, const std::function<bool(const Seen&)>& of) {
        int most = -1;
        for (const Seen& s : all)
            if (of(s)) most = std::max({most, s.colour[0], s.colour[1], s.colour[2]});
        return most;
    }
};

TEST_F(DebugViewGlTest, LevelShowsAsManyColoursAsThereAreLevels) {
    constexpr int kLevels = 4;
    ReliefWorld world(std::make_shared<FlatSource>(1025, 0.0),
                      {.clipmap = {.n = 63, .levels = kLevels, .blend = 0.1}, .tile_size = 1024});
    ASSERT_TRUE(world.show(settings(DetailBackend::None, DebugView::Level)));
    const std::vector<Seen> all = look(world, world.view({51.2, 51.2}, 1.7, {1, -0.3, 0.02}, kWidth, kHeight));
    std::map<int, double> nearest_m;
    std::set<int> levels;
    for (const Seen& s : all) {
        int found = -1;
        for (int level = 0; level < kLevels + 2; ++level) {
            // Golden sections of the hue circle, as the shader says.
            std::array<double, 3> hue{};
            constexpr double kThirds[] = {0, 2.0 / 3, 1.0 / 3};
            for (std::size_t i = 0; i < 3; ++i) {
                const double turn = 0.618034 * level + kThirds[i];
                hue[i] = 1 + 0.85 * (std::clamp(std::abs((turn - std::floor(turn)) * 6 - 3) - 1, 0.0, 1.0) - 1);
            }
            if (!same_hue(s.colour, hue)) continue;
            ASSERT_EQ(found, -1) << "two levels look alike";
            found = level;
        }
        ASSERT_GE(found, 0) << s.colour[0] << " " << s.colour[1] << " " << s.colour[2];
        levels.insert(found);
        const double metres = std::max(std::abs(s.at.x - 51.2), std::abs(s.at.z - 51.2));
        const auto [at, first] = nearest_m.try_emplace(found, metres);
        if (!first) at->second = std::min(at->second, metres);
    }
    EXPECT_EQ(levels, (std::set<int>{0, 1, 2, 3}));
    // A window of n posts reaches n / 2 of its units from the eye, give or take the two units in which it moves.
    for (int level = 1; level < kLevels; ++level)
        EXPECT_NEAR(nearest_m[level], 31.5 * 0.1 * (1 << (level - 1)), 0.1 * 2.5 * (1 << (level - 1))) << level;
}

TEST_F(DebugViewGlTest, TileShowsEachTileInOneColourAndItsNeighboursInOthers) {
    ReliefWorld world(std::make_shared<FlatSource>(513, 0.0), {.tile_size = 512});
    ASSERT_TRUE(world.show(settings(DetailBackend::None, DebugView::Tile)));
    const double tile_m = 512 / 30.0;
    const std::vector<Seen> all =
        look(world, world.view({1.1 * tile_m, 0.9 * tile_m}, 9, {0.02, -1, 0.01}, kWidth, kHeight));
    std::map<std::pair<int, int>, Rgb> colours;
    for (const Seen& s : all) {
        const double x = s.at.x / tile_m, z = s.at.z / tile_m;
        // Not the pixel on the border itself.
        if (std::abs(x - std::round(x)) * tile_m < 0.1 || std::abs(z - std::round(z)) * tile_m < 0.1) continue;
        const auto [at, first] =
            colours.try_emplace({static_cast<int>(std::floor(x)), static_cast<int>(std::floor(z))}, s.colour);
        if (!first) {
            EXPECT_TRUE(same_hue(s.colour, {double(at->second[0]), double(at->second[1]), double(at->second[2])}))
                << s.at.x << " " << s.at.z;
        }
    }
    ASSERT_EQ(colours.size(), 4u);
    for (const auto& [tile, colour] : colours)
        for (const auto& [other, other_colour] : colours)
            if (tile != other) {
                EXPECT_FALSE(
                    same_hue(colour, {double(other_colour[0]), double(other_colour[1]), double(other_colour[2])}));
            }
}

TEST_F(DebugViewGlTest, FetchesAreBlackWhereNothingIsDentedAndBrightInAPrint) {
    ReliefWorld world(std::make_shared<FlatSource>(513, 0.0), {.tile_size = 2048});
    const WorldPos print{27.6, 25.6};
    world.print(print);
    const View view = world.view({25.6, 25.6}, 1.7, {1, -0.45, 0.02}, kWidth, kHeight);
    // What is searched comes from nodes of 64 texels about the pixel's, and theirs: 2.5 nodes on each axis, 5.34 m.
    const auto untouched = [&](const Seen& s) {
        return std::max(std::abs(s.at.x - print.x), std::abs(s.at.z - print.z)) > 5.6;
    };
    const auto dented = [&](const Seen& s) { return distance_m(s.at, print) < 0.08; };
    for (const DetailPreset preset : {DetailPreset::Low, DetailPreset::Medium, DetailPreset::Exact}) {
        ASSERT_TRUE(world.show(settings(DetailBackend::Parallax, DebugView::Fetches, preset)));
        const std::vector<Seen> all = look(world, view);
        EXPECT_EQ(brightest(all, untouched), 0) << name_of(preset);
        EXPECT_GE(brightest(all, dented), 8) << name_of(preset) << ": one of 32";
        if (preset == DetailPreset::Low) {
            EXPECT_EQ(brightest(all, dented), 32) << "four steps, 4 / 32 of 255";
        }
    }
    ASSERT_TRUE(world.show(settings(DetailBackend::None, DebugView::Fetches)));
    EXPECT_EQ(brightest(look(world, view), [](const Seen&) { return true; }), 0);
}

TEST_F(DebugViewGlTest, TheErrorOfExactMethodsIsBlackAndOfOthersIsNot) {
    ReliefWorld world(std::make_shared<FlatSource>(513, 0.0), {.tile_size = 2048});
    for (int i = 0; i < 8; ++i) world.print({26.4 + 0.7 * i, 25.6 + (i % 2 == 0 ? 0.13 : -0.13)});
    const View view = world.view({25.6, 25.6}, 1.2, {1, -0.35, 0.02}, kWidth, kHeight);
    const auto error = [&](const DetailSettings& shown) {  // blue alone: not known, where slopes alone are shown
        if (!show(world, shown)) return -1;
        int most = 0;
        for (const Seen& s : look(world, view)) most = std::max(most, s.colour[0]);
        return most;
    };
    using enum DetailBackend;
    EXPECT_EQ(error(settings(Parallax, DebugView::Error, DetailPreset::Exact)), 0);
    EXPECT_GE(error(settings(Parallax, DebugView::Error, DetailPreset::Low)), 16) << "a quarter of a texel";
    // Three texels a post: every texel is a vertex. 1 of 255 is 1/64 texel, half a millimetre.
    EXPECT_LE(error(settings(Geometry, DebugView::Error, DetailPreset::Exact)), 1);
    DetailSettings coarse = settings(Geometry, DebugView::Error);
    coarse.refinement.most_factor = 1;
    EXPECT_GE(error(coarse), 16) << "posts alone";
    coarse.backend = Tessellation;
    if (const int most = error(coarse); most >= 0) {
        EXPECT_GE(most, 16);
    }
}

TEST_F(DebugViewGlTest, BackendShowsTheZonesOfTheHybridInOrderOfDistance) {
    ReliefWorld world(std::make_shared<FlatSource>(513, 0.0), {.tile_size = 2048});
    for (int i = 0; i < 34; ++i) world.print({24.8 + 0.75 * i, 25.6});
    const DetailSettings hybrid = settings(DetailBackend::Hybrid, DebugView::Backend);
    std::string why;
    if (!world.show(hybrid, &why)) GTEST_SKIP() << why;
    const double reach_m = (world.whole_reach_m() + 1) / 0.75;
    const double inner_m = hybrid.tessellated * reach_m, outer_m = (hybrid.tessellated + hybrid.blend) * reach_m;
    constexpr std::array<double, 3> kDisplaced{1, 0.25, 0.15}, kTraced{0.2, 1, 0.25}, kSlopes{0.25, 0.35, 1};
    int displaced = 0, traced = 0, slopes = 0;
    double last_red = 0;
    for (const Seen& s : look(world, world.view({25.6, 25.6}, 1.7, {1, -0.25, 0.001}, 480, 270))) {
        // Where the trail is, all blocks have detail.
        if (std::abs(s.at.z - 25.6) > 0.3 || s.at.x > 48) continue;
        const double d = s.distance_m, margin_m = 0.02 * d + 0.1;  // what dents move
        const auto expect = [&](const std::array<double, 3>& hue, int& count) {
            EXPECT_TRUE(same_hue(s.colour, hue))
                << d << " m: " << s.colour[0] << " " << s.colour[1] << " " << s.colour[2];
            ++count;
        };
        if (d < inner_m - margin_m)
            expect(kDisplaced, displaced);
        else if (d > outer_m + margin_m && d < 0.75 * reach_m - margin_m)
            expect(kTraced, traced);
        else if (d > reach_m + margin_m)
            expect(kSlopes, slopes);
        if (s.colour[0] > s.colour[1] && s.colour[0] > s.colour[2]) last_red = std::max(last_red, d);
    }
    EXPECT_GT(displaced, 200);
    EXPECT_GT(traced, 50);
    EXPECT_GT(slopes, 10);
    EXPECT_GT(last_red, inner_m) << "the blend begins with what the mesh shows";
    EXPECT_LT(last_red, outer_m);
}

TEST_F(DebugViewGlTest, WireframeIsLinesAndFillsAgainAfterwards) {
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0));
    world.print({14, 12.8});
    const View down = world.view({12.8, 12.8}, 1.7, {0.4, -1, 0.01}, kWidth, kHeight);
    for (const DetailBackend backend : {DetailBackend::None, DetailBackend::Geometry, DetailBackend::Hybrid}) {
        if (!show(world, settings(backend, DebugView::Wireframe))) continue;
        const std::size_t lines = look(world, down).size();
        EXPECT_GT(lines, 1000u) << name_of(backend);
        EXPECT_LT(lines, std::size_t{kWidth * kHeight} * 3 / 4) << name_of(backend) << ": the background between them";
        GLint mode[2] = {};
        device().gl().GetIntegerv(GL_POLYGON_MODE, mode);
        EXPECT_EQ(mode[0], GL_FILL);
        ASSERT_TRUE(world.show(settings(backend, DebugView::Level)));
        EXPECT_EQ(look(world, down).size(), std::size_t{kWidth * kHeight}) << name_of(backend);
    }
}

TEST_F(DebugViewGlTest, OffIsAsIfThereHadNeverBeenAny) {
    const std::shared_ptr<const HeightSource> source = make_ridged_source({.seed = 7, .size = 257, .relief_m = 3});
    ReliefWorld world(source), never(source);
    for (int i = 0; i < 4; ++i)
        for (ReliefWorld* each : {&world, &never}) each->print({13.2 + 0.6 * i, 12.8}, 0.2 * i);
    const Target target(kWidth, kHeight);
    const View view = world.view({12.8, 12.7}, 1.7, {1, -0.6, 0.02}, kWidth, kHeight);
    for (const DetailBackend backend : {DetailBackend::None, DetailBackend::Parallax, DetailBackend::Hybrid}) {
        if (!show(world, settings(backend, DebugView::Off))) continue;
        ASSERT_TRUE(never.show(settings(backend, DebugView::Off)));
        for (int i = 1; i <= static_cast<int>(DebugView::Error); ++i) {
            ASSERT_TRUE(world.show(settings(backend, static_cast<DebugView>(i))));
            const Frame debug = world.draw(target, view);
            ASSERT_TRUE(world.show(settings(backend, DebugView::Off)));
            const Frame back = world.draw(target, view), other = never.draw(target, view);
            EXPECT_NE(debug.rgba, back.rgba) << i;
            EXPECT_EQ(back.rgba, other.rgba) << name_of(backend) << " after " << i;
            EXPECT_EQ(back.depth, other.depth) << name_of(backend) << " after " << i;
        }
    }
}

}  // namespace
}  // namespace tilth::test
