// Phong tessellation of all levels through the whole renderer: no hole at any border, flat ground untouched,
// and levels that show relief stay as they are.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

#include "render/support/holes.h"
#include "support/gl_context.h"
#include "tilth/source/analytic_sources.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth::test {
namespace {

const char* const kShaders = TILTH_SOURCE_DIR "/shaders";

struct World {
    std::int32_t n = 63, levels = 4;
    bool mirror = false;
    SlopeFormat slopes = SlopeFormat::rg8;
    std::string shader_folder = kShaders;
};

class PhongGlTest : public GlTest {
protected:
    static constexpr int kWidth = 160, kHeight = 90;

    void SetUp() override {
        GlTest::SetUp();
        if (HasFatalFailure() || IsSkipped()) return;
        if (!device().capabilities().tessellation) GTEST_SKIP() << "no tessellation";
    }
    static std::unique_ptr<Terrain> terrain(const std::shared_ptr<const HeightSource>& source, const World& setup) {
        TerrainSettings settings{.executor = ExecutorKind::Cpu,
                                 .slopes = setup.slopes,
                                 .clipmap = {.n = setup.n, .levels = setup.levels, .blend = 0.1},
                                 .shader_folder = setup.shader_folder};
        settings.ground.tile_size = 512;
        settings.ground.mirror = setup.mirror;
        return value(Terrain::create(source, settings, test_context(default_route()).context->get_proc()));
    }
    static std::shared_ptr<const HeightSource> mountains() {
        return make_ridged_source({.seed = 7, .size = 257, .relief_m = 90});
    }
    static DetailSettings curved(DetailBackend backend = DetailBackend::None) {
        DetailSettings settings = detail_preset(backend, DetailPreset::Exact);
        settings.phong = {.on = true, .most_factor = 4, .edge_px = 2};
        return settings;
    }
    struct Frame {
        std::vector<std::uint8_t> rgba;
        std::vector<float> depth;
        std::uint64_t generated = 0, submitted = 0;  ///< triangles
    };
    static Frame draw(Terrain& ground, const Target& target, View view) {
        view.width = target.width(), view.height = target.height();
        EXPECT_TRUE(ground.update(0));
        target.clear(1, 0, 1);
        gl::Query query = value(gl::Query::create(device(), "generated", gl::QueryKind::PrimitivesGenerated));
        query.begin();
        const Result<void> drawn = ground.draw(view, {});
        query.end();
        EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
        return {target.pixels(), target.depths(), query.result(), ground.last_frame().render.primitives};
    }
    static void settle(Terrain& ground, WorldPos viewer) {
        ground.set_viewers({&viewer, 1});
        EXPECT_TRUE(ground.update(0));
        EXPECT_TRUE(ground.drain());
        EXPECT_TRUE(ground.update(0));
    }
    struct Found {
        long holes = 0, generated = 0;
        int frames = 0, with_sky = 0;
    };
    /// Round the map's middle (a mirrored world's: over its folds, too) at several heights.
    static Found fly_over(Terrain& ground, const Target& target, double middle, int frames, int first) {
        Found found;
        for (int i = first; i < first + frames; ++i) {
            const double turn = i * 0.7234567, radius = 10 + 45 * std::fmod(i * 0.618034, 1.0);
            const WorldPos at{middle + radius * std::cos(turn), middle + radius * std::sin(turn)};
            const double heights_m[] = {1.5, 5, 14, 30, 60}, pitches[] = {-0.12, -0.45, -0.9, -1.3};
            const double pitch = pitches[i % 4], heading = turn * 1.7;
            View view{
                .eye = {at.x, ground.height_m(at) + heights_m[i % 5], at.z},
                .forward = {std::cos(pitch) * std::cos(heading), std::sin(pitch), std::cos(pitch) * std::sin(heading)},
                .near_m = 0.1,
                .far_m = 3000};
            const bool down = i % 7 == 0;
            if (down) view.forward = {0, -1, 0};
            settle(ground, at);
            const Frame frame = draw(ground, target, view);
            const long sky = magenta_pixels(frame.rgba);
            const long holes = down ? sky : sky_within_ground(frame.rgba, kWidth, kHeight);
            if (holes > 0) keep_picture(text("phong_holes_", i), frame.rgba, kWidth, kHeight);
            found.holes += holes;
            found.generated += static_cast<long>(frame.generated);
            found.with_sky += sky > 0;
            ++found.frames;
        }
        return found;
    }
    /// Relief over everything that is flown over.
    static void roughen(Terrain& ground, double middle) {
        for (int i = 0; i < 400; ++i)
            ASSERT_TRUE(ground.stamp({.shape = {static_cast<std::uint32_t>(i % kBuiltinProfiles)},
                                      .centre = {middle - 60 + 120 * std::fmod(i * 0.618034, 1.0),
                                                 middle - 60 + 120 * std::fmod(i * 0.754878, 1.0)},
                                      .radius_m = 2.0 + i % 5,
                                      .amplitude_m = i % 2 == 0 ? 0.5 : -0.5,
                                      .map = MapChoice::Detail}));
    }
    /// A copy of the shaders in which the first `old_text` of `file` is `new_text`.
    static std::string mutated(const std::string& file, const std::string& old_text, const std::string& new_text) {
        namespace fs = std::filesystem;
        const fs::path folder = fs::path(TILTH_BINARY_DIR) / "test-output" / "render" / "mutated_phong";
        fs::remove_all(folder);
        fs::create_directories(folder);
        fs::copy(kShaders, folder, fs::copy_options::recursive);
        std::stringstream all;
        all << std::ifstream(folder / file).rdbuf();
        std::string changed = all.str();
        const std::size_t at = changed.find(old_text);
        EXPECT_NE(at, std::string::npos) << file << " has no \"" << old_text << "\" to mutate";
        if (at != std::string::npos) changed.replace(at, old_text.size(), new_text);
        std::ofstream(folder / file) << changed;
        return folder.string();
    }
};

TEST_F(PhongGlTest, NoFrameHasAHole) {
    const struct {
        World setup;
        DetailBackend backend;
    } flights[] = {{{.n = 31, .levels = 5}, DetailBackend::None},
                   {{.n = 63}, DetailBackend::None},
                   {{.n = 31, .levels = 5, .slopes = SlopeFormat::rg16f}, DetailBackend::Geometry},
                   {{.n = 63, .slopes = SlopeFormat::rg16f}, DetailBackend::Parallax},
                   {{.n = 63}, DetailBackend::Tessellation},
                   {{.n = 31, .levels = 6, .mirror = true}, DetailBackend::None},
                   {{.n = 63, .mirror = true, .slopes = SlopeFormat::rg16f}, DetailBackend::Geometry}};
    const Target target(kWidth, kHeight);
    int frames = 0, with_sky = 0;
    for (const auto& [setup, backend] : flights) {
        const std::unique_ptr<Terrain> ground = terrain(mountains(), setup);
        // A corner of four mirror images, far out; else the map's own middle.
        const double middle = setup.mirror ? 256.0 * 40 : 128;
        if (backend != DetailBackend::None) roughen(*ground, middle);
        ASSERT_TRUE(ground->set_detail(curved(backend)));
        const Found found = fly_over(*ground, target, middle, 25, frames);
        EXPECT_EQ(found.holes, 0) << "n " << setup.n << ", " << name_of(backend) << ", mirrored " << setup.mirror;
        frames += found.frames;
        with_sky += found.with_sky;
    }
    EXPECT_EQ(frames, 175);
    EXPECT_GT(with_sky, frames / 10) << "otherwise a hole could not be told from the ground";
    EXPECT_LT(with_sky, frames * 9 / 10);
}

// The proof that the test above can fail: curved up to a level's border, or with the points of an edge counted from
// the end at which each triangle happens to begin.
TEST_F(PhongGlTest, CurvedBordersAndEdgesCountedTwoWaysTear) {
    const struct {
        const char *file, *old_text, *new_text;
    } mutations[] = {
        {"render/phong/phong_vertex.glsl", "return refinement_fade(distance_units, u_n, is_coarsest);", "return 1.0;"},
        {"render/phong/phong_vertex.glsl", "clamp(0.25 * to_border, 0.0, 1.0)", "1.0"},
        {"render/phong/phong.tese", "k = parts - k;", ""}};
    const Target target(kWidth, kHeight);
    for (const auto& m : mutations) {
        const std::unique_ptr<Terrain> ground =
            terrain(mountains(), {.n = 31, .levels = 5, .shader_folder = mutated(m.file, m.old_text, m.new_text)});
        ASSERT_TRUE(ground->set_detail(curved()));
        const Found found = fly_over(*ground, target, 128, 25, 0);
        std::printf("%s without \"%s\": %ld pixels of holes\n", m.file, m.old_text, found.holes);
        EXPECT_GT(found.holes, 0) << m.old_text;
    }
}

TEST_F(PhongGlTest, FlatGroundIsUntouched) {
    const Target target(kWidth, kHeight);
    for (const SlopeFormat slopes : {SlopeFormat::rg8, SlopeFormat::rg16f}) {
        const std::unique_ptr<Terrain> ground = terrain(std::make_shared<FlatSource>(257, 3.7), {.slopes = slopes});
        for (const double pitch : {-0.1, -0.7, -1.5}) {
            const View view{
                .eye = {120.3, 9.1, 130.7}, .forward = {std::cos(pitch), std::sin(pitch), 0.1}, .far_m = 1000};
            ASSERT_TRUE(ground->set_detail({}));
            const Frame plain = draw(*ground, target, view);
            ASSERT_TRUE(ground->set_detail(curved()));
            (void)draw(*ground, target, view);  // the first draws with programs it makes
            const Frame phong = draw(*ground, target, view);
            // The tessellator hands the same three points on in another order: planes through them round differently.
            double depth_off = 0;
            for (std::size_t p = 0; p < phong.depth.size(); ++p)
                depth_off = std::max(depth_off, std::abs(double(phong.depth[p]) - double(plain.depth[p])));
            EXPECT_LE(depth_off, 0x1p-23) << pitch;
            long other_colours = 0;
            for (std::size_t b = 0; b < phong.rgba.size(); ++b) {
                other_colours += phong.rgba[b] != plain.rgba[b];
                EXPECT_LE(std::abs(phong.rgba[b] - plain.rgba[b]), 1) << pitch;
            }
            EXPECT_LE(other_colours, 5) << pitch;
            EXPECT_EQ(phong.generated, phong.submitted) << pitch << ": nothing is split";
            EXPECT_EQ(plain.generated, plain.submitted) << pitch;
            EXPECT_GT(plain.generated, 1000u);
        }
    }
}

// Relief is metres above triangles, so level 0 is not curved where a backend shows relief: the ground close by, with
// and without prints, is what it is without Phong. Farther levels are curved as ever.
class PhongReliefGlTest : public PhongGlTest {
protected:
    static constexpr WorldPos kAt{128.4, 128.3};
    static std::unique_ptr<Terrain> ground_with(bool relief, const std::string& shader_folder = kShaders) {
        std::unique_ptr<Terrain> ground = terrain(mountains(), {.n = 63, .shader_folder = shader_folder});
        if (relief) roughen(*ground, 128);
        settle(*ground, kAt);
        return ground;
    }
    /// Without Phong and with it; straight down, where level 0 alone is in sight (it ends at 30 m), or far along.
    static std::pair<Frame, Frame> both(Terrain& ground, DetailBackend backend, bool down) {
        const Target target(kWidth, kHeight);
        const double eye_m = ground.height_m(kAt) + 10;
        View view{.eye = {kAt.x, eye_m, kAt.z}, .forward = {0.02, -1, 0.01}, .fov_y_rad = 1.2};
        if (!down) view.eye.y += 20, view.forward = {1, -0.1, 0.3};
        DetailSettings off = curved(backend);
        off.phong.on = false;
        EXPECT_TRUE(ground.set_detail(off));
        Frame flat = draw(ground, target, view);
        EXPECT_TRUE(ground.set_detail(curved(backend)));
        Frame phong = draw(ground, target, view);
        if (down) {
            EXPECT_EQ(magenta_pixels(flat.rgba), 0);
        }
        return {std::move(flat), std::move(phong)};
    }
    /// How far apart the two grounds are along the view, metres, at the 90th percentile.
    static double rise_m(const std::pair<Frame, Frame>& frames) {
        const View view;
        const auto along_m = [&](double d) {
            return view.near_m * view.far_m / (view.far_m - d * (view.far_m - view.near_m));
        };
        std::vector<double> off;
        for (std::size_t p = 0; p < frames.first.depth.size(); ++p)
            if (frames.first.depth[p] < 1 && frames.second.depth[p] < 1)
                off.push_back(std::abs(along_m(frames.first.depth[p]) - along_m(frames.second.depth[p])));
        std::sort(off.begin(), off.end());
        return off.empty() ? 0 : off[off.size() * 9 / 10];
    }
};

TEST_F(PhongReliefGlTest, WithABackendTheFinestLevelIsNotCurved) {
    const std::unique_ptr<Terrain> rough = ground_with(true), smooth = ground_with(false);
    for (const DetailBackend backend : {DetailBackend::None, DetailBackend::Geometry, DetailBackend::Parallax,
                                        DetailBackend::Tessellation, DetailBackend::Hybrid}) {
        for (Terrain* ground : {rough.get(), smooth.get()}) {
            const double off_m = rise_m(both(*ground, backend, true));
            if (backend == DetailBackend::None)
                EXPECT_GT(off_m, 0.01);
            else
                EXPECT_LT(off_m, 1e-4) << name_of(backend);
            EXPECT_GT(rise_m(both(*ground, backend, false)), 0.01) << name_of(backend) << ", farther levels";
        }
    }
}

// And the test above would notice.
TEST_F(PhongReliefGlTest, ACurvedFinestLevelIsSeen) {
    const std::unique_ptr<Terrain> ground = ground_with(
        false, mutated("render/phong/phong_vertex.glsl", "if (level < u_phong_first_level) return 0.0;", ""));
    EXPECT_GT(rise_m(both(*ground, DetailBackend::Geometry, true)), 0.01);
}

}  // namespace
}  // namespace tilth::test
