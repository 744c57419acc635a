// The facade: executors agree, nothing is done when nothing is asked, the host's state comes back, bad input is
// refused.
#include "tilth/terrain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "support/gl_context.h"
#include "support/gl_state.h"
#include "support/random_world.h"
#include "tilth/source/analytic_sources.h"
#include "tilth/store/memory_store.h"

namespace tilth {
namespace {

StateHash hash_of(Terrain& terrain) { return test::value(terrain.hash()); }

class TerrainTest : public test::GlTest {
protected:
    static gl::GetProc get_proc() { return test::test_context(test::default_route()).context->get_proc(); }

    static TerrainSettings settings(ExecutorKind executor, HeightPrecision precision = HeightPrecision::bits32) {
        TerrainSettings made{.executor = executor, .clipmap = {.n = 31, .levels = 3}};
        made.ground.precision = precision;
        return made;
    }
    static std::shared_ptr<const HeightSource> ridged() {
        return make_ridged_source({.seed = 3, .size = 257, .relief_m = 100});
    }
    static std::unique_ptr<Terrain> terrain(ExecutorKind executor, HeightPrecision precision = HeightPrecision::bits32,
                                            bool with_gl = true) {
        return test::value(Terrain::create(ridged(), settings(executor, precision), with_gl ? get_proc() : nullptr));
    }
    static View view() {
        return {.eye = {128, 120, 128}, .forward = {0.6, -0.5, 0.4}, .width = 160, .height = 90, .far_m = 1000};
    }
    /// `frames` frames of random stamps on both maps.
    static void stamp_randomly(Terrain& terrain, int frames) {
        for (int frame = 0; frame < frames; ++frame) {
            for (const MapChoice map : {MapChoice::Coarse, MapChoice::Detail}) {
                RandomStamps random{.seed = 100 + static_cast<std::uint64_t>(frame), .count = 15, .map = map};
                random.region = {WorldPos{-5, -5}, WorldPos{261, 261}};
                random.radius_m = {0.1, map == MapChoice::Coarse ? 12.0 : 1.5};
                random.amplitude_m = {-1, 1};
                for (std::uint32_t shape = 0; shape < kBuiltinProfiles; ++shape) random.shapes.push_back({shape});
                random.rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth};
                for (const StampRequest& request : random_stamps(random, terrain.ground()))
                    ASSERT_TRUE(terrain.stamp(request));
            }
            ASSERT_TRUE(terrain.update(1.0 / 60));
        }
    }
};

TEST_F(TerrainTest, AllExecutorsLeaveTheSameBitsWithAndWithoutGl) {
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
        const std::unique_ptr<Terrain> gpu = terrain(ExecutorKind::Gpu, precision),
                                       cpu = terrain(ExecutorKind::Cpu, precision),
                                       server = terrain(ExecutorKind::Cpu, precision, false);
        const StateHash untouched = hash_of(*server);
        for (Terrain* each : {gpu.get(), cpu.get(), server.get()}) stamp_randomly(*each, 8);
        EXPECT_EQ(hash_of(*gpu), hash_of(*server));
        EXPECT_EQ(hash_of(*cpu), hash_of(*server));
        EXPECT_NE(untouched.coarse, hash_of(*server).coarse);
        EXPECT_NE(untouched.detail, hash_of(*server).detail);
        for (const WorldPos at : {WorldPos{10.25, 20.75}, WorldPos{128.5, 3.125}, WorldPos{200, 250.9}})
            EXPECT_EQ(gpu->height_m(at), server->height_m(at));
    }
}

TEST_F(TerrainTest, AFrameWithoutStampsDoesNothing) {
    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu}) {
        const std::unique_ptr<Terrain> ground = terrain(executor);
        stamp_randomly(*ground, 1);
        ASSERT_TRUE(ground->drain());
        ASSERT_TRUE(ground->update(1.0 / 60));
        const test::Target target(160, 90);
        target.clear(0, 0, 0);
        ASSERT_TRUE(ground->draw(view(), {}));
        const gl::FrameStats& frame = ground->last_frame();
        EXPECT_EQ(frame.deform, gl::StageStats{});
        EXPECT_EQ(frame.derive, gl::StageStats{});
        EXPECT_EQ(frame.mips, gl::StageStats{});
        EXPECT_EQ(frame.transfer, gl::TransferStats{});
        EXPECT_EQ(frame.render.texels, 0u);
        EXPECT_GT(frame.render.primitives, 0u) << "the frame was drawn";
    }
}

TEST_F(TerrainTest, AFrameWithOneStampTouchesItsTexelsAlone) {
    const std::unique_ptr<Terrain> ground = terrain(ExecutorKind::Gpu);
    ASSERT_TRUE(ground->stamp({.centre = {100, 100}, .radius_m = 10, .amplitude_m = -1, .map = MapChoice::Coarse}));
    ASSERT_TRUE(ground->update(0));
    EXPECT_EQ(ground->last_frame().deform.passes, 1u);
    EXPECT_EQ(ground->last_frame().deform.texels, 21u * 21u);
    EXPECT_EQ(ground->last_frame().derive.passes, 1u);
    EXPECT_EQ(ground->last_frame().derive.texels, 23u * 23u) << "the stencil reaches one texel further";
    EXPECT_LT(ground->last_frame().mips.texels, 23u * 23u / 2);
}

TEST_F(TerrainTest, EveryPublicCallLeavesTheHostsStateAsItWas) {
    const gl::Api& gl = device().gl();
    test::Target host(64, 64);
    host.bind();
    gl.Viewport(3, 4, 50, 40);  // a host's state that no default equals
    gl.Enable(GL_BLEND);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(1, 2, 30, 20);
    gl.ColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 8);
    gl.PixelStorei(GL_UNPACK_ROW_LENGTH, 77);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 2);
    gl.ActiveTexture(GL_TEXTURE3);
    host.colour().bind(3);
    gl.CullFace(GL_FRONT);
    gl.DepthFunc(GL_GEQUAL);

    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu, ExecutorKind::Automatic}) {
        test::GlState before = test::capture_state(device());
        const auto unchanged = [&](const char* call) {
            const test::GlState after = test::capture_state(device());
            for (const auto& [name, values] : before) EXPECT_EQ(values, after.at(name)) << call << " changed " << name;
        };
        std::unique_ptr<Terrain> ground = terrain(executor);
        unchanged("create");
        ASSERT_TRUE(ground->stamp({.centre = {100, 100}, .radius_m = 10, .amplitude_m = -1, .map = MapChoice::Coarse}));
        ASSERT_TRUE(ground->stamp({.centre = {90, 100},
                                   .radius_m = 9,
                                   .amplitude_m = 0.5,
                                   .map = MapChoice::Coarse,
                                   .rule = StampRule::Smooth}));
        unchanged("stamp");
        ASSERT_TRUE(ground->update(1.0 / 60));
        unchanged("update");
        const BrushCursor cursor{.centre = {120, 120}, .radius_m = 3};
        ASSERT_TRUE(ground->draw(view(), {}, &cursor));
        unchanged("draw");
        // Detail: a tile that is dented, drawn, left (read back and saved), and comes back (loaded and filled).
        for (const WorldPos viewer : {WorldPos{100, 100}, WorldPos{1e5, 1e5}, WorldPos{100, 100}}) {
            ground->set_viewers({&viewer, 1});
            unchanged("set_viewers");
            for (const StampRule rule : {StampRule::Add, StampRule::Smooth})
                ASSERT_TRUE(ground->stamp({.centre = {100, 100}, .radius_m = 1, .amplitude_m = 0.5, .rule = rule}));
            for (int frame = 0; frame < 3; ++frame) ASSERT_TRUE(ground->update(1.0 / 60));
            unchanged("update with detail");
            ASSERT_TRUE(ground->draw(view(), {}, &cursor));
            unchanged("draw with detail");
            ASSERT_TRUE(ground->drain());
            unchanged("drain with detail");
        }
        (void)ground->tiles();
        (void)ground->take_arrivals();
        (void)ground->take_errors();
        unchanged("reports of tiles");
        ASSERT_TRUE(ground->replay(
            *ground->stamp({.centre = {10, 10}, .radius_m = 10, .amplitude_m = 400, .map = MapChoice::Coarse})));
        ASSERT_TRUE(ground->drain());
        unchanged("drain");
        EXPECT_TRUE(std::isfinite(ground->height_m({1, 1})));
        unchanged("height_m");
        (void)ground->raycast({100, 500, 100}, {0, -1, 0}, 1000);
        unchanged("raycast");
        (void)hash_of(*ground);
        unchanged("hash");
        ASSERT_TRUE(ground->reload_shaders());
        unchanged("reload_shaders");
        (void)ground->total();
        (void)ground->gpu_bytes();
        ground.reset();
        unchanged("the destructor");
    }
    gl.Disable(GL_BLEND);
    gl.Disable(GL_SCISSOR_TEST);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl.PixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl.CullFace(GL_BACK);
    gl.DepthFunc(GL_LESS);
}

TEST_F(TerrainTest, AStampShowsInThePictureOfTheSameFrame) {
    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu}) {
        const std::unique_ptr<Terrain> ground =
            test::value(Terrain::create(std::make_shared<FlatSource>(257, 10.0), settings(executor), get_proc()));
        const test::Target target(120, 90);
        const View above{.eye = {128, 60, 128}, .forward = {0, -1, 0}, .width = 120, .height = 90};
        const auto picture = [&] {
            target.clear(1, 0, 1);
            EXPECT_TRUE(ground->draw(above, {}));
            return target.pixels();
        };
        const std::vector<std::uint8_t> before = picture();
        ASSERT_TRUE(ground->stamp({.centre = {128, 128}, .radius_m = 12, .amplitude_m = -4, .map = MapChoice::Coarse}));
        ASSERT_TRUE(ground->update(0));
        const std::vector<std::uint8_t> after = picture();
        int changed = 0;
        for (std::size_t i = 0; i < before.size(); i += 4)
            changed += before[i] != after[i] || before[i + 1] != after[i + 1];
        // The crater's disc of 12 m is seen from 50 m at 60 degrees: about 19 px in radius; its flat rim and middle do
        // not change.
        EXPECT_GT(changed, 400);
        EXPECT_LT(changed, 1300);
    }
}

TEST_F(TerrainTest, AutomaticSettlesOnAnExecutorAndSaysWhy) {
    const std::unique_ptr<Terrain> ground = terrain(ExecutorKind::Automatic);
    EXPECT_NE(ground->executor(), ExecutorKind::Automatic);
    EXPECT_NE(ground->executor_reason().find(" us by gpu and "), std::string::npos) << ground->executor_reason();
    if (device().quirks().software_rasterizer) {
        EXPECT_EQ(ground->executor(), ExecutorKind::Cpu);
    }
}

TEST_F(TerrainTest, AStampAndItsNegationRestoreTheHashOnTheGpu) {
    const std::unique_ptr<Terrain> ground = terrain(ExecutorKind::Gpu);
    const StateHash untouched = hash_of(*ground);
    std::vector<StampRecord> records;
    for (std::uint32_t shape = 0; shape < kBuiltinProfiles; ++shape)
        records.push_back(*ground->stamp({.shape = {shape},
                                          .centre = {60.0 + 20 * shape, 100.3},
                                          .radius_m = 11.7,
                                          .amplitude_m = 1.37,
                                          .map = MapChoice::Coarse}));
    ASSERT_TRUE(ground->update(0));
    EXPECT_NE(hash_of(*ground), untouched);
    for (const StampRecord& record : records) ASSERT_TRUE(ground->replay(negated(record)));
    ASSERT_TRUE(ground->update(0));
    EXPECT_EQ(hash_of(*ground), untouched);
}

TEST_F(TerrainTest, SaturationOnTheGpuIsReported) {
    const std::unique_ptr<Terrain> gpu = terrain(ExecutorKind::Gpu), cpu = terrain(ExecutorKind::Cpu);
    for (Terrain* ground : {gpu.get(), cpu.get()}) {
        for (int i = 0; i < 4; ++i)
            ASSERT_TRUE(
                ground->stamp({.centre = {100, 100}, .radius_m = 10, .amplitude_m = 300, .map = MapChoice::Coarse}));
        ASSERT_TRUE(ground->update(0));
        ASSERT_TRUE(ground->drain());
    }
    EXPECT_EQ(hash_of(*gpu), hash_of(*cpu));
    EXPECT_GT(cpu->total().deform.saturated, 0u);
    EXPECT_EQ(gpu->total().deform.saturated, cpu->total().deform.saturated);
}

TEST_F(TerrainTest, AFailingPassLosesNoStampAndAppliesNoneTwice) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(TILTH_BINARY_DIR) / "test-output" / "failing_pass";
    fs::remove_all(folder);
    fs::create_directories(folder.parent_path());
    fs::copy(TILTH_SOURCE_DIR "/shaders", folder, fs::copy_options::recursive);
    const fs::path shader = folder / "deform" / "stamps.frag";
    {
        std::ofstream broken(shader, std::ios::app);
        broken << "#ifdef SMOOTH\nthis does not compile\n#endif\n";
    }
    TerrainSettings from_folder = settings(ExecutorKind::Gpu);
    from_folder.shader_folder = folder.string();
    const std::unique_ptr<Terrain> gpu = test::value(Terrain::create(ridged(), from_folder, get_proc()));
    const std::unique_ptr<Terrain> cpu = terrain(ExecutorKind::Cpu);
    for (Terrain* ground : {gpu.get(), cpu.get()}) {
        for (const StampRule rule : {StampRule::Add, StampRule::Add, StampRule::Smooth, StampRule::Add})
            ASSERT_TRUE(ground->stamp(
                {.centre = {100, 100}, .radius_m = 10, .amplitude_m = 0.9, .map = MapChoice::Coarse, .rule = rule}));
    }
    ASSERT_TRUE(cpu->update(0));
    const Result<void> failed = gpu->update(0);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::ShaderCompile);
    EXPECT_NE(failed.error().message.find("stamps.frag"), std::string::npos) << failed.error().message;
    EXPECT_FALSE(device().take_debug_messages().empty()) << "the compiler's own words, which no other test may hear";
    EXPECT_EQ(gpu->last_frame().deform.fallbacks, 2u) << "the smooth stamp and the one behind it, by the CPU";
    EXPECT_EQ(hash_of(*gpu), hash_of(*cpu));
    EXPECT_TRUE(gpu->update(0)) << "nothing is left to be done";

    for (Terrain* ground : {gpu.get(), cpu.get()})  // over codes that the CPU has put there
        ASSERT_TRUE(ground->stamp({.centre = {104, 99}, .radius_m = 10, .amplitude_m = -2, .map = MapChoice::Coarse}));
    ASSERT_TRUE(cpu->update(0));
    ASSERT_TRUE(gpu->update(0));
    EXPECT_EQ(gpu->last_frame().deform.fallbacks, 0u);
    EXPECT_EQ(hash_of(*gpu), hash_of(*cpu));
}

TEST_F(TerrainTest, RecordsThatDoNotFitThisWorldAreRefused) {
    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu}) {
        const std::unique_ptr<Terrain> ground = terrain(executor);
        const StateHash untouched = hash_of(*ground);
        const StampRecord good = *ground->stamp({.centre = {50, 50}, .radius_m = 0.5, .amplitude_m = 0});
        const auto refused = [&](const char* field, auto change) {
            StampRecord bad = good;
            change(bad);
            const Result<void> replayed = ground->replay(bad);
            ASSERT_FALSE(replayed) << field;
            EXPECT_EQ(replayed.error().message.rfind(field, 0), 0u) << replayed.error().message;
        };
        refused("shape:", [](StampRecord& r) { r.shape = 99; });
        refused("shape:", [](StampRecord& r) { r.shape_hash ^= 1; });
        refused("map:", [](StampRecord& r) { r.map = static_cast<MapKind>(5); });
        refused("rule:", [](StampRecord& r) { r.rule = static_cast<StampRule>(5); });
        refused("amplitude:", [](StampRecord& r) { r.rule = StampRule::Smooth, r.amplitude = 65537; });
        refused("negative:", [](StampRecord& r) { r.negative = 2; });
        refused("mirror:", [](StampRecord& r) { r.mirror = 255; });
        refused("reserved:", [](StampRecord& r) { r.reserved = 1; });
        refused("radius:", [](StampRecord& r) { r.radius = (8192u << 18) + 1; });
        refused("centre:", [](StampRecord& r) { r.centre_x = INT64_MAX; });
        ASSERT_TRUE(ground->update(0));
        EXPECT_EQ(hash_of(*ground), untouched);
        StampRecord later = good;
        later.sequence = 1000;
        ASSERT_TRUE(ground->replay(later));
        EXPECT_EQ(ground->stamp({.centre = {50, 50}, .radius_m = 1})->sequence, 1001u)
            << "numbers continue behind a replay";
    }
}

TEST_F(TerrainTest, DiggingAndFillingForEverDoesNotEndInPassesOfOneStamp) {
    TerrainSettings small = settings(ExecutorKind::Gpu);
    const std::unique_ptr<Terrain> ground =
        test::value(Terrain::create(std::make_shared<FlatSource>(129, 10.0), small, get_proc()));
    const StateHash untouched = hash_of(*ground);
    std::uint64_t passes = 0, fallbacks = 0;
    for (int frame = 0; frame < 300; ++frame) {  // 2 400 stamps of 5 cm on a map of +- 32 m
        for (const double amplitude_m : {-0.05, 0.05, -0.05, 0.05, -0.05, 0.05, -0.05, 0.05})
            ASSERT_TRUE(ground->stamp(
                {.centre = {64, 64}, .radius_m = 10, .amplitude_m = amplitude_m, .map = MapChoice::Coarse}));
        ASSERT_TRUE(ground->update(0));
        passes += ground->last_frame().deform.passes;
        fallbacks += ground->last_frame().deform.fallbacks;
    }
    EXPECT_LT(passes, 310u) << "a frame's stamps share one pass, however long the history";
    EXPECT_GT(fallbacks, 0u) << "the history must be long enough to widen the bounds to the range";
    EXPECT_LT(fallbacks, 6u);
    EXPECT_EQ(ground->total().deform.saturated, 0u);
    EXPECT_EQ(hash_of(*ground), untouched);
}

TEST_F(TerrainTest, FlatGroundHasOneColourUpToItsBorder) {
    // 100 posts: the last post is none of the mips' own, and their next texel is padding.
    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu})
        for (const SlopeFormat format : {SlopeFormat::rg8, SlopeFormat::rg16f}) {
            TerrainSettings coarse = settings(executor);
            coarse.slopes = format;
            coarse.clipmap = {.n = 15, .levels = 5};
            const std::unique_ptr<Terrain> ground =
                test::value(Terrain::create(std::make_shared<FlatSource>(100, 10.0), coarse, get_proc()));
            const test::Target target(128, 128);
            target.clear(1, 0, 1);
            Shading shading;
            shading.specular = 0;  // which varies with the view
            const View above{.eye = {49.5, 110, 49.5}, .forward = {0, -1, 0}, .width = 128, .height = 128};
            ASSERT_TRUE(ground->draw(above, shading));
            const std::vector<std::uint8_t> pixels = target.pixels();
            const std::size_t middle = (64 * 128 + 64) * 4;
            int drawn = 0;
            for (std::size_t i = 0; i < pixels.size(); i += 4) {
                if (pixels[i] == 255 && pixels[i + 1] == 0 && pixels[i + 2] == 255) continue;
                ++drawn;
                for (std::size_t c = 0; c < 3; ++c)
                    ASSERT_NEAR(pixels[i + c], pixels[middle + c], 1) << i / 4 % 128 << ", " << i / 4 / 128;
            }
            EXPECT_GT(drawn, 10000);
        }
}

TEST_F(TerrainTest, AMirroredWorldDrawsFarFromItsSourceAndRefusesCoarseStamps) {
    TerrainSettings mirrored = settings(ExecutorKind::Cpu);
    mirrored.ground.mirror = true;
    const std::unique_ptr<Terrain> ground = test::value(Terrain::create(ridged(), mirrored, get_proc()));
    EXPECT_LT(ground->cpu_bytes(), 257u * 257u * 4u + 1000u);
    // Post p and 2 * 256 * k - p show the same post of the source.
    EXPECT_EQ(ground->height_m({100, 30}), ground->height_m({512.0 * 1000 - 100, 30}));
    EXPECT_EQ(ground->height_m({100, 30}), ground->height_m({512.0 * 1000 + 100, 512.0 * 700 - 30}));
    const Result<StampRecord> refused =
        ground->stamp({.centre = {100, 100}, .radius_m = 10, .amplitude_m = 1, .map = MapChoice::Coarse});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message.rfind("map:", 0), 0u) << refused.error().message;

    const test::Target target(160, 90);
    const auto picture = [&](double x) {
        View from_x = view();
        from_x.eye.x = x;
        target.clear(1, 0, 1);
        EXPECT_TRUE(ground->draw(from_x, {}));
        return target.pixels();
    };
    EXPECT_EQ(picture(128), picture(128 + 512.0 * 1000)) << "the world repeats every 512 posts";
}

TEST_F(TerrainTest, WithoutGlDrawingIsRefusedWithTheReason) {
    const std::unique_ptr<Terrain> server = terrain(ExecutorKind::Cpu, HeightPrecision::bits32, false);
    const Result<void> drawn = server->draw(view(), {});
    ASSERT_FALSE(drawn);
    EXPECT_NE(drawn.error().message.find("without a GL context"), std::string::npos);
    EXPECT_FALSE(Terrain::create(ridged(), settings(ExecutorKind::Gpu), nullptr));
}

TEST_F(TerrainTest, DrawingIntoNothingIsRefusedWithoutAGlError) {
    const std::unique_ptr<Terrain> ground = terrain(ExecutorKind::Cpu);
    const gl::Framebuffer empty = test::value(gl::Framebuffer::create(device(), "empty"));
    empty.bind();
    const Result<void> drawn = ground->draw(view(), {});
    ASSERT_FALSE(drawn);
    EXPECT_EQ(drawn.error().message.rfind("draw:", 0), 0u);
    (void)device().take_debug_messages();  // Mesa says why it is incomplete
}

TEST_F(TerrainTest, BadSettingsAreRefusedByTheFieldsName) {
    const auto refusal = [&](auto change) {
        TerrainSettings bad = settings(ExecutorKind::Cpu);
        change(bad);
        const Result<std::unique_ptr<Terrain>> made = Terrain::create(ridged(), bad, get_proc());
        return made ? std::string("accepted") : made.error().message;
    };
    EXPECT_EQ(refusal([](TerrainSettings& s) { s.ground.spacing_m = 0; }).rfind("spacing", 0), 0u);
    EXPECT_EQ(refusal([](TerrainSettings& s) { s.ground.quantum_m = 0.3; }).rfind("quantum", 0), 0u);
    EXPECT_EQ(refusal([](TerrainSettings& s) { s.ground.quantum_m = 1.0 / 65536; }).rfind("quantum", 0), 0u);
    EXPECT_EQ(refusal([](TerrainSettings& s) { s.ground.tile_size = 100; }).rfind("tile_size", 0), 0u);
    EXPECT_EQ(refusal([](TerrainSettings& s) { s.ground.origin.x = NAN; }).rfind("origin", 0), 0u);
    EXPECT_NE(refusal([](TerrainSettings& s) { s.clipmap.n = 30; }).find('n'), std::string::npos);
    EXPECT_NE(refusal([](TerrainSettings& s) { s.clipmap.n = 30; }), "accepted");
    EXPECT_NE(refusal([](TerrainSettings& s) { s.shader_folder = "/nowhere"; }), "accepted");
}

// Every way in which detail is shown, while stamps fall and the window moves: programs and textures are made,
// framebuffers bound, polygon mode and patches set.
TEST_F(TerrainTest, NoDetailBackendLeavesATraceInTheHostsState) {
    const gl::Api& gl = device().gl();
    test::Target host(64, 64);
    host.bind();
    gl.Viewport(3, 4, 50, 40);
    gl.Enable(GL_BLEND);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(1, 2, 30, 20);
    gl.ColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
    gl.PixelStorei(GL_UNPACK_ROW_LENGTH, 77);
    gl.ActiveTexture(GL_TEXTURE3);
    host.colour().bind(3);
    gl.CullFace(GL_FRONT);
    gl.DepthFunc(GL_GEQUAL);
    gl.DepthMask(GL_FALSE);
    gl.PolygonMode(GL_FRONT_AND_BACK, GL_POINT);
    const bool tessellates = device().capabilities().tessellation;
    if (tessellates) gl.PatchParameteri(GL_PATCH_VERTICES, 7);

    const test::GlState before = test::capture_state(device());
    const auto unchanged = [&](const std::string& call) {
        const std::string changed = test::difference(before, test::capture_state(device()));
        EXPECT_EQ(changed, "") << "by " << call;
        for (const gl::DebugMessage& message : device().take_debug_messages())
            ADD_FAILURE() << call << ": GL message " << message.text;
    };
    const struct {
        DebugView debug;
        bool phong;
    } looks[] = {{DebugView::Off, false}, {DebugView::Wireframe, true}, {DebugView::Off, false}};
    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu}) {
        TerrainSettings made = settings(executor);
        made.ground.spacing_m = 0.1;
        made.ground.tile_size = 256;
        made.clipmap = {.n = 63, .levels = 3};
        const std::unique_ptr<Terrain> ground =
            test::value(Terrain::create(std::make_shared<FlatSource>(257, 0.0), made, get_proc()));
        int frame = 0;
        for (const DetailBackend backend : {DetailBackend::Parallax, DetailBackend::Geometry,
                                            DetailBackend::Tessellation, DetailBackend::Hybrid, DetailBackend::None})
            for (const auto& [debug, phong] : looks) {
                if (phong && executor == ExecutorKind::Cpu) continue;  // the same programs again
                DetailSettings shown = detail_preset(backend, DetailPreset::High);
                shown.debug_view = debug;
                shown.phong.on = phong;
                const bool needs_gl4 =
                    phong || backend == DetailBackend::Tessellation || backend == DetailBackend::Hybrid;
                if (needs_gl4 && !tessellates) continue;
                const std::string name = std::string(name_of(backend)) + ", debug view " +
                                         std::to_string(static_cast<int>(debug)) + (phong ? ", phong" : "");
                ASSERT_TRUE(ground->set_detail(shown)) << name;
                unchanged("set_detail: " + name);
                // Half a metre on, over tiles' borders and over the window's step.
                const WorldPos eye{4 + 0.45 * frame, 8.4 + 0.2 * frame};
                ground->set_viewers({&eye, 1});
                for (const double off : {0.0, 0.6})
                    ASSERT_TRUE(ground->stamp({.centre = {eye.x + off, eye.z},
                                               .radius_m = 0.4,
                                               .amplitude_m = -0.1,
                                               .map = MapChoice::Detail}));
                ASSERT_TRUE(ground->update(0));
                ASSERT_TRUE(ground->drain());
                const View down{.eye = {eye.x, 2, eye.z},
                                .forward = {0.5, -1, 0.1},
                                .width = 64,
                                .height = 64,
                                .near_m = 0.1,
                                .far_m = 100};
                ASSERT_TRUE(ground->draw(down, {})) << name;
                unchanged("draw: " + name);
                if (backend != DetailBackend::None) {
                    EXPECT_GT(ground->last_frame().derive.passes, 0u) << name << ": the window was filled";
                }
                if (++frame == 5) {
                    ASSERT_TRUE(ground->reload_shaders());
                    unchanged("reload_shaders");
                }
            }
        EXPECT_GE(frame, tessellates ? 10 : 6);
    }
    gl.Disable(GL_BLEND);
    gl.Disable(GL_SCISSOR_TEST);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl.PixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    gl.CullFace(GL_BACK);
    gl.DepthFunc(GL_LESS);
    gl.DepthMask(GL_TRUE);
    gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    if (tessellates) gl.PatchParameteri(GL_PATCH_VERTICES, 3);
}

// 64 texels a post: not one block of the finest level fits into the largest window.
TEST_F(TerrainTest, ABackendWithoutRoomForReliefIsRefused) {
    TerrainSettings made = settings(ExecutorKind::Cpu);
    made.clipmap.n = 255;
    made.ground.texels_per_post = 64;
    const auto source = std::make_shared<FlatSource>(33, 0.0);
    const std::unique_ptr<Terrain> ground = test::value(Terrain::create(source, made, get_proc()));
    const Result<void> set = ground->set_detail({.backend = DetailBackend::Parallax});
    ASSERT_FALSE(set);
    EXPECT_EQ(set.error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(set.error().message.rfind("detail.backend: parallax", 0), 0u) << set.error().message;
    EXPECT_EQ(ground->detail(), DetailSettings());
    made.detail.backend = DetailBackend::Geometry;
    EXPECT_FALSE(Terrain::create(source, made, get_proc()));
}

TEST_F(TerrainTest, DetailSettingsOutOfRangeAreRefusedByTheFieldsNameAndChangeNothing) {
    const std::unique_ptr<Terrain> ground = terrain(ExecutorKind::Cpu);
    DetailSettings good = detail_preset(DetailBackend::Geometry, DetailPreset::High);
    good.reach = 0.7;
    ASSERT_TRUE(ground->set_detail(good));
    using Change = void (*)(DetailSettings&, double);
    const struct {
        const char* field;
        double least, most;  ///< allowed
        double below, above;
        Change set;
    } fields[] = {
        {"parallax.steps", 1, 256, 0, 257,
         [](DetailSettings& s, double v) { s.parallax.steps = static_cast<std::int32_t>(v); }},
        {"parallax.shadow_steps", 0, 64, -1, 65,
         [](DetailSettings& s, double v) { s.parallax.shadow_steps = static_cast<std::int32_t>(v); }},
        {"parallax.least_elevation_rad", 0.1 * M_PI / 180, 45 * M_PI / 180, 0.09 * M_PI / 180, 45.1 * M_PI / 180,
         [](DetailSettings& s, double v) { s.parallax.least_elevation_rad = v; }},
        {"parallax.range.lowest_m", -8, 0, -8.01, 0.01,
         [](DetailSettings& s, double v) {
             s.parallax.range = ParallaxSettings::Range{v, 1};
         }},
        {"parallax.range.highest_m", 0, 8, -0.01, 8.01,
         [](DetailSettings& s, double v) {
             s.parallax.range = ParallaxSettings::Range{-1, v};
         }},
        {"refinement.most_factor", 1, 64, 0, 65,
         [](DetailSettings& s, double v) { s.refinement.most_factor = static_cast<std::int32_t>(v); }},
        {"refinement.edge_px", 0.5, 64, 0.49, 64.1, [](DetailSettings& s, double v) { s.refinement.edge_px = v; }},
        {"phong.shape", 0, 1, -0.01, 1.01, [](DetailSettings& s, double v) { s.phong.shape = v; }},
        {"phong.most_factor", 1, 16, 0, 17,
         [](DetailSettings& s, double v) { s.phong.most_factor = static_cast<std::int32_t>(v); }},
        {"phong.edge_px", 0.5, 64, 0.49, 64.1, [](DetailSettings& s, double v) { s.phong.edge_px = v; }},
        {"reach", 0.05, 1, 0.04, 1.01, [](DetailSettings& s, double v) { s.reach = v; }},
        {"tessellated", 0.05, 0.9, 0.04, 0.91, [](DetailSettings& s, double v) { s.tessellated = v; }},
        {"blend", 0.02, 0.5, 0.01, 0.51, [](DetailSettings& s, double v) { s.blend = v; }}};
    for (const auto& f : fields) {
        for (const double v : {f.least, f.most}) {
            DetailSettings edge = good;
            f.set(edge, v);
            const Result<void> set = ground->set_detail(edge);
            EXPECT_TRUE(set) << f.field << " = " << v << ": " << (set ? "" : set.error().message);
        }
        ASSERT_TRUE(ground->set_detail(good));
        std::vector<double> bad{f.below, f.above};
        const std::string field = f.field;
        if (field.find("steps") == field.npos && field.find("factor") == field.npos)
            bad.insert(bad.end(), {std::nan(""), INFINITY, -INFINITY});
        for (const double v : bad) {
            DetailSettings wrong = good;
            f.set(wrong, v);
            const Result<void> set = ground->set_detail(wrong);
            ASSERT_FALSE(set) << f.field << " = " << v;
            EXPECT_EQ(set.error().code, ErrorCode::InvalidArgument);
            EXPECT_EQ(set.error().message.rfind("detail." + field + " is ", 0), 0u) << set.error().message;
            EXPECT_EQ(ground->detail(), good) << f.field;
            TerrainSettings made = settings(ExecutorKind::Cpu);
            made.detail = wrong;
            const auto refused = Terrain::create(std::make_shared<FlatSource>(33, 0.0), made, get_proc());
            ASSERT_FALSE(refused) << f.field << " = " << v;
            EXPECT_NE(refused.error().message.find(field), std::string::npos) << refused.error().message;
        }
    }
}

// Values that no enumerator has, as a host may read them from a file.
TEST_F(TerrainTest, DetailSettingsThatNameNothingAreRefused) {
    const std::unique_ptr<Terrain> ground = terrain(ExecutorKind::Cpu);
    const auto refused = [&](const char* field, auto change) {
        DetailSettings wrong;
        change(wrong);
        const Result<void> set = ground->set_detail(wrong);
        ASSERT_FALSE(set) << field;
        EXPECT_EQ(set.error().message.rfind(field, 0), 0u) << set.error().message;
        EXPECT_EQ(ground->detail(), DetailSettings()) << field;
    };
    refused("detail.backend", [](DetailSettings& s) { s.backend = static_cast<DetailBackend>(5); });
    refused("detail.parallax.method", [](DetailSettings& s) { s.parallax.method = static_cast<ParallaxMethod>(3); });
    refused("detail.debug_view", [](DetailSettings& s) { s.debug_view = static_cast<DebugView>(7); });
}

// A tile that was dented while nobody was near arrives in an `update` that has nothing to stamp.
TEST_F(TerrainTest, AnArrivalWithoutAStampLeavesTheHostsStateAsItWas) {
    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu}) {
        const std::unique_ptr<Terrain> ground = terrain(executor);
        const WorldPos away{1e6, 1e6}, here{100, 100};
        ground->set_viewers({&away, 1});
        ASSERT_TRUE(ground->stamp({.centre = here, .radius_m = 1, .amplitude_m = 0.5}));
        ASSERT_TRUE(ground->update(0));
        ground->set_viewers({&here, 1});
        const test::GlState before = test::capture_state(device());
        ASSERT_TRUE(ground->update(0));
        const test::GlState after = test::capture_state(device());
        for (const auto& [name, values] : before) EXPECT_EQ(values, after.at(name)) << name;
        EXPECT_GT(ground->tile_gpu_bytes(), 0u) << "it arrived in that very frame";
    }
}

// Rays over dents in tiles that are away, and over dents that only the GPU has: on the surface that a server without GL
// has.
TEST_F(TerrainTest, RaysHitTheGroundWhereverItsTilesAre) {
    for (const ExecutorKind executor : {ExecutorKind::Gpu, ExecutorKind::Cpu}) {
        GroundSettings layout{.tile_size = 64};
        TerrainSettings made = settings(executor);
        made.ground = layout;
        const auto source = std::make_shared<FlatSource>(257, 10.0);
        const std::unique_ptr<Terrain> ground = test::value(Terrain::create(source, made, get_proc()));
        made.executor = ExecutorKind::Cpu;
        const std::unique_ptr<Terrain> server = test::value(Terrain::create(source, made, nullptr));
        const WorldPos near{30, 30}, away{240, 240};
        ground->set_viewers({&near, 1});
        // A trench along x over many tiles, and a pit.
        for (Terrain* each : {ground.get(), server.get()}) {
            for (int i = 0; i < 120; ++i)
                ASSERT_TRUE(each->stamp({.centre = {10.0 + i, 30},
                                         .radius_m = 2.5,
                                         .amplitude_m = -2,
                                         .map = MapChoice::Detail,
                                         .rule = StampRule::Min}));
            ASSERT_TRUE(each->update(0));
        }
        const auto compare = [&](const char* when) {
            for (const Vec3d& from : {Vec3d{12, 8.6, 30}, Vec3d{30, 14, 30}, Vec3d{5, 30, 30}, Vec3d{125, 8.5, 30}})
                for (const Vec3d& to :
                     {Vec3d{124, 8.05, 30.2}, Vec3d{60, 8, 29.5}, Vec3d{12, 8, 30}, Vec3d{40, 9, 33}}) {
                    const Vec3d direction = towards(from, to);
                    const std::optional<double> hit = ground->raycast(from, direction, 500),
                                                wanted = server->raycast(from, direction, 500);
                    ASSERT_EQ(hit.has_value(), wanted.has_value()) << when << ": " << from.x << " to " << to.x;
                    EXPECT_NEAR(hit.value_or(0), wanted.value_or(0), 1e-9) << when << ": " << from.x << " to " << to.x;
                }
        };
        compare("resident");
        ground->set_viewers({&away, 1});
        for (int frame = 0; frame < 3; ++frame) ASSERT_TRUE(ground->update(0));
        compare("away");
    }
}

TEST_F(TerrainTest, AStoreWithoutGlIsRefusedAndNotIgnored) {
    TerrainSettings made = settings(ExecutorKind::Cpu);
    made.tiles.store = std::make_shared<MemoryStore>();
    const auto refused = Terrain::create(ridged(), made, nullptr);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Unsupported);
    EXPECT_EQ(refused.error().message.rfind("tiles.store:", 0), 0u) << refused.error().message;
}

}  // namespace
}  // namespace tilth
