// The relief window is never stale: after any script of stamps, undo, walks, leaps and switches the picture is the one
// that a terrain gives which got the same edits and fills its window for the first time.
#include <gtest/gtest.h>
#include <ostream>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "render/support/scene.h"
#include "support/gl_context.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth::test {
namespace {

/// An edit of the script, as it can be done again.
struct Edit {
    enum class Kind { Stamp, Undo, Redo } kind = Kind::Stamp;
    StampRequest request;
};

struct Case {
    ExecutorKind executor = ExecutorKind::Gpu;
    HeightPrecision precision = HeightPrecision::bits32;
    SlopeFormat slopes = SlopeFormat::rg8;
    const char* name = "";

    friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

class ReliefScriptGlTest : public GlTest, public ::testing::WithParamInterface<Case> {
protected:
    static constexpr int kSide = 112;  // pixels
    static constexpr std::int32_t kPosts = 385, kTile = 256;
    static constexpr double kSpacingM = 0.1, kTileM = kTile * kSpacingM / 3;

    static std::unique_ptr<Terrain> terrain() {
        TerrainSettings settings{.undo_bytes = 1u << 26,
                                 .executor = GetParam().executor,
                                 .slopes = GetParam().slopes,
                                 .clipmap = {.n = 63, .levels = 3, .blend = 0.1},
                                 .shader_folder = TILTH_SOURCE_DIR "/shaders"};
        settings.ground.spacing_m = kSpacingM;
        settings.ground.tile_size = kTile;
        settings.ground.precision = GetParam().precision;
        return value(Terrain::create(make_ridged_source({.seed = 5, .size = kPosts, .relief_m = 4}), settings,
                                     test_context(default_route()).context->get_proc()));
    }
    static void edit(Terrain& ground, const Edit& edit) {
        switch (edit.kind) {
            case Edit::Kind::Stamp: {
                const Result<StampRecord> done = ground.stamp(edit.request);
                EXPECT_TRUE(done) << (done ? "" : done.error().message);
                break;
            }
            case Edit::Kind::Undo:
                EXPECT_TRUE(ground.undo());
                break;
            case Edit::Kind::Redo:
                EXPECT_TRUE(ground.redo());
                break;
        }
    }
    /// From low enough above the ground that all relief in reach is in the picture.
    static View view(const Terrain& ground, WorldPos eye) {
        return {.eye = {eye.x, ground.ground().height_m(eye, MapSelect::Coarse) + 1.3, eye.z},
                .forward = {0.03, -1, 0.02},
                .fov_y_rad = 2.1,
                .width = kSide,
                .height = kSide,
                .near_m = 0.05,
                .far_m = 300};
    }
    struct Picture {
        std::vector<std::uint8_t> rgba;
        std::vector<float> depth;
    };
    /// Which blocks relief programs draw depends on bounds that undo widens: where nothing is displaced, they hand a
    /// triangle's points on in another order, and depth rounds differently. 2^-22 is 8 micrometres of ground here.
    static bool differ(const Picture& a, const Picture& b, std::size_t pixel) {
        bool other = std::abs(double(a.depth[pixel]) - double(b.depth[pixel])) > 0x1p-22;
        for (std::size_t c = pixel * 4; c < pixel * 4 + 3; ++c) other |= std::abs(a.rgba[c] - b.rgba[c]) > 1;
        return other;
    }
    static long different(const Picture& a, const Picture& b) {
        long count = 0;
        for (std::size_t p = 0; p < a.depth.size(); ++p) count += differ(a, b, p);
        return count;
    }
    static Picture draw(Terrain& ground, const Target& target, const View& from) {
        target.clear(1, 0, 1);
        const Result<void> drawn = ground.draw(from, {.to_light = {0.5f, 0.45f, 0.3f}});
        EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
        return {target.pixels(), target.depths()};
    }
};

DetailSettings exact(DetailBackend backend, double reach = 1) {
    DetailSettings settings = detail_preset(backend, DetailPreset::Exact);
    settings.reach = reach;
    return settings;
}

// The eye beside a border of tiles; the viewer goes to the tile behind the next, so that the eye's own is given
// back while its neighbour is loaded, and comes again.
TEST_P(ReliefScriptGlTest, ATileThatLeavesTakesItsReliefWithItAndBringsItBack) {
    const Target target(kSide, kSide);
    const std::unique_ptr<Terrain> ground = terrain();
    const WorldPos eye{2 * kTileM - 0.4, 2.5 * kTileM}, middle{3.5 * kTileM, 2.5 * kTileM};
    for (int i = 0; i < 40; ++i)
        edit(*ground, {Edit::Kind::Stamp,
                       {.centre = {eye.x - 2 + 4 * std::fmod(i * 0.618034, 1.0), eye.z - 2 + 0.1 * i},
                        .radius_m = 0.3,
                        .amplitude_m = -0.1,
                        .map = MapChoice::Detail}});
    const auto resident = [&] {
        int count = 0;
        for (const TileReport& tile : ground->tiles()) count += tile.state == TileState::Resident;
        return count;
    };
    const auto go = [&](WorldPos viewer, int wanted, bool draws) {
        ground->set_viewers({&viewer, 1});
        EXPECT_TRUE(ground->update(0));
        EXPECT_TRUE(ground->drain());
        for (int i = 0; i < 100000 && resident() != wanted; ++i) {
            EXPECT_TRUE(ground->update(0));
            if (draws && i < 10) (void)draw(*ground, target, view(*ground, eye));
        }
        EXPECT_EQ(resident(), wanted);
    };
    const auto look = [&](WorldPos viewer, DetailBackend backend) {
        EXPECT_TRUE(ground->set_detail(exact(backend)));
        if (viewer.x != eye.x) go({1e4, 1e4}, 0, false);  // what is there is kept for a while
        go(viewer, viewer.x == eye.x ? 2 : 1, true);
        return draw(*ground, target, view(*ground, eye));
    };
    for (const DetailBackend backend : {DetailBackend::Geometry, DetailBackend::Parallax}) {
        const Picture whole = look(eye, backend), half = look(middle, backend);
        EXPECT_GT(different(whole, half), kSide * kSide / 50) << name_of(backend);
        ASSERT_TRUE(ground->set_detail({}));
        const Picture none = draw(*ground, target, view(*ground, eye));
        EXPECT_GT(different(none, half), kSide * kSide / 50) << name_of(backend);
        ASSERT_TRUE(ground->set_detail(exact(backend)));
        EXPECT_EQ(different(draw(*ground, target, view(*ground, eye)), half), 0) << name_of(backend) << ", refilled";
        EXPECT_EQ(different(look(eye, backend), whole), 0) << name_of(backend) << ", back";
    }
}

TEST_P(ReliefScriptGlTest, EveryPictureIsThatOfATerrainThatFillsItsWindowForTheFirstTime) {
    constexpr int kFrames = 48, kLookEvery = 4;
    const Target target(kSide, kSide);
    const std::unique_ptr<Terrain> ground = terrain();
    // Has no window but for one picture: without a backend there is none.
    std::unique_ptr<Terrain> fresh = terrain();
    std::mt19937 random(1);
    const auto real = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
    const auto whole = [&](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
    std::vector<Edit> script;
    const auto perform = [&](const Edit& e) {
        edit(*ground, e);
        edit(*fresh, e);
        script.push_back(e);
    };
    constexpr double kMapM = (kPosts - 1) * kSpacingM;
    WorldPos eye{kMapM / 2 + 0.3, kMapM / 2 - 0.2};
    DetailSettings settings = exact(DetailBackend::Geometry);
    ASSERT_TRUE(ground->set_detail(settings));
    const DetailBackend backends[] = {DetailBackend::Geometry, DetailBackend::Parallax, DetailBackend::Hybrid,
                                      DetailBackend::Tessellation, DetailBackend::None};
    long looks = 0, pixels_of_relief = 0;
    int leaves = 0, leaps = 0, undone = 0;
    int away = 0;  // frames for which the viewer is elsewhere
    for (int frame = 0; frame < kFrames; ++frame) {
        // Edits near the eye, in its tiles' neighbours, anywhere.
        for (int i = whole(0, 4); i > 0; --i) {
            const int where = whole(0, 9);
            const double about_m = where < 6 ? 2.5 : where < 8 ? kTileM : kMapM;
            const StampRule rules[] = {StampRule::Add, StampRule::Add, StampRule::Add, StampRule::Smooth,
                                       StampRule::Min, StampRule::Set, StampRule::Max};
            Edit stamp;
            stamp.request = {.shape = {static_cast<std::uint32_t>(whole(0, kBuiltinProfiles - 1))},
                             .centre = {eye.x + real(-about_m, about_m), eye.z + real(-about_m, about_m)},
                             .radius_m = real(0.05, 0.7),
                             .amplitude_m = real(-0.15, 0.15),
                             .map = MapChoice::Detail,
                             .rule = rules[whole(0, 6)]};
            if (stamp.request.rule == StampRule::Smooth) stamp.request.amplitude_m = 0.8;
            if (whole(0, 15) == 0) stamp.request.radius_m = 3;
            perform(stamp);
        }
        if (whole(0, 19) == 0) {
            Edit coarse;
            coarse.request = {.centre = eye, .radius_m = 2, .amplitude_m = real(-0.2, 0.2), .map = MapChoice::Coarse};
            perform(coarse);
        }
        for (int i = whole(0, 5) == 0 ? whole(1, 3) : 0; i > 0 && ground->undoable() > 0; --i, ++undone)
            perform({Edit::Kind::Undo, {}});
        for (int i = whole(0, 5) == 0 ? whole(1, 2) : 0; i > 0 && ground->redoable() > 0; --i)
            perform({Edit::Kind::Redo, {}});
        // Where the eye goes: a step, over a window's step or a tile's border, somewhere else, back.
        const int going = whole(0, 19);
        if (going < 9) eye = {eye.x + real(-0.4, 0.4), eye.z + real(-0.4, 0.4)};
        if (going >= 9 && going < 13) eye = {eye.x + real(-4, 4), eye.z + real(-4, 4)};
        if (going == 13) eye = {std::round(eye.x / kTileM) * kTileM, std::round(eye.z / kTileM) * kTileM};
        if (going >= 14 && going < 16) eye = {real(-1, kMapM + 1), real(-1, kMapM + 1)}, ++leaps;
        eye = {std::clamp(eye.x, -1.0, kMapM + 1), std::clamp(eye.z, -1.0, kMapM + 1)};
        if (whole(0, 14) == 0) away = whole(1, 4), ++leaves;
        const WorldPos viewer = away-- > 0 ? WorldPos{eye.x + 1e4, eye.z} : eye;
        ground->set_viewers({&viewer, 1});
        if (whole(0, 5) == 0) settings = exact(backends[whole(0, 4)], settings.reach);
        if (whole(0, 7) == 0) settings.reach = real(0.05, 1);
        if (!ground->set_detail(settings)) {  // what this context cannot do
            settings.backend = DetailBackend::Geometry;
            ASSERT_TRUE(ground->set_detail(settings));
        }
        for (Terrain* each : {ground.get(), fresh.get()}) ASSERT_TRUE(each->update(1.0 / 60));
        (void)draw(*ground, target, view(*ground, eye));
        if (whole(0, 9) == 0)
            (void)draw(*ground, target, view(*ground, {eye.x + 1.7, eye.z - 0.6}));  // two on a screen
        if (frame % kLookEvery != kLookEvery - 1) continue;

        // What both of them show once all tiles are there.
        const WorldPos here = eye;
        if (frame == kFrames - 1) {  // and all of it for the first time
            fresh = terrain();
            for (const Edit& e : script) edit(*fresh, e);
        }
        for (Terrain* each : {ground.get(), fresh.get()}) {
            each->set_viewers({&here, 1});
            ASSERT_TRUE(each->update(0));
            ASSERT_TRUE(each->drain());
            ASSERT_TRUE(each->update(0));
        }
        const View from = view(*fresh, here);
        ASSERT_EQ(from.eye.y, view(*ground, here).eye.y);
        for (const DetailBackend backend : {DetailBackend::Geometry, DetailBackend::Parallax}) {
            ASSERT_TRUE(fresh->set_detail({}));
            const Picture none = draw(*fresh, target, from);
            for (Terrain* each : {ground.get(), fresh.get()})
                ASSERT_TRUE(each->set_detail(exact(backend, settings.reach)));
            const Picture is = draw(*ground, target, from), should = draw(*fresh, target, from);
            long wrong = 0;
            for (std::size_t p = 0; p < is.depth.size(); ++p) {
                wrong += differ(is, should, p);
                pixels_of_relief += should.depth[p] != none.depth[p];
            }
            ASSERT_EQ(wrong, 0) << name_of(backend) << ", frame " << frame << ", eye " << here.x << ", " << here.z;
            ++looks;
        }
        ASSERT_TRUE(ground->set_detail(settings));
        ASSERT_TRUE(fresh->set_detail({}));
        (void)draw(*fresh, target, from);
    }
    std::printf("%ld pictures, %ld pixels of relief, %d leaps, %d leaves, %d undone\n", looks, pixels_of_relief, leaps,
                leaves, undone);
    EXPECT_EQ(looks, kFrames / kLookEvery * 2);
    EXPECT_GT(pixels_of_relief, looks * kSide * kSide / 20) << "there was relief to be wrong";
    EXPECT_GT(leaps, 0);
    EXPECT_GT(leaves, 0);
    EXPECT_GT(undone, 0);
}
INSTANTIATE_TEST_SUITE_P(
    Each, ReliefScriptGlTest,
    ::testing::Values(Case{ExecutorKind::Gpu, HeightPrecision::bits32, SlopeFormat::rg8, "Gpu32"},
                      Case{ExecutorKind::Gpu, HeightPrecision::bits16, SlopeFormat::rg16f, "Gpu16"},
                      Case{ExecutorKind::Cpu, HeightPrecision::bits32, SlopeFormat::rg16f, "Cpu32"},
                      Case{ExecutorKind::Cpu, HeightPrecision::bits16, SlopeFormat::rg8, "Cpu16"}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace tilth::test
