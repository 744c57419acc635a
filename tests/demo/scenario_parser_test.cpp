// Scenarios that are wrong are refused with line and key; a scenario that uses every key is read as it stands.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "demo/corpus.h"
#include "demo/player/viewer.h"
#include "demo/scenario/names.h"
#include "demo/scenario/read_scenario.h"
#include "demo/stats/run_report.h"
#include "demo/world/open_world.h"

namespace tilth::demo {
namespace {

const ScenarioContext kContext{{"gaussian", "cone", "paraboloid", "cosine", "crater", "disc", "boot", "tyre"},
                               has_stat};

std::optional<Scenario> parsed(const std::string& steps, Problems& problems,
                               const std::string& terrain = "heights = \"flat:size=65,height=0\"") {
    return parse_scenario("[terrain]\n" + terrain + "\n" + steps, "made_up.toml", kContext, problems);
}

TEST(ScenarioCorpus, EveryFileIsRefusedAtItsLineAndKey) {
    const auto files = test::corpus();
    ASSERT_GE(files.size(), 20u);
    for (const test::CorpusFile& file : files) {
        SCOPED_TRACE(file.path.filename().string());
        ASSERT_GT(file.line, 0) << "the first line must read '# expect: LINE KEY'";
        Problems problems;
        const auto scenario = read_scenario(file.path, kContext, problems);
        if (scenario) {
            EXPECT_EQ(load_heights(scenario->terrain, problems), nullptr);
        }
        bool found = false;
        for (const Problem& p : problems.list()) found |= p.line == file.line && p.key == file.key && !p.text.empty();
        EXPECT_TRUE(found) << problems.report("FILE");
        EXPECT_EQ(problems.report("FILE").find_first_of(std::string("\0\x1b\x7f", 3)), std::string::npos)
            << "control characters reach the terminal";
    }
}

TEST(ScenarioCorpus, CutAnywhereNeverCrashes) {
    std::ifstream in(TILTH_SOURCE_DIR "/demo/scenarios/tour.toml");
    std::ostringstream whole;
    whole << in.rdbuf();
    ASSERT_GT(whole.str().size(), 100u);
    for (std::size_t bytes = 0; bytes < whole.str().size(); bytes += 7) {
        Problems problems;
        const bool read =
            parse_scenario(std::string_view(whole.str()).substr(0, bytes), "cut.toml", kContext, problems).has_value();
        EXPECT_EQ(read, problems.empty());
    }
}

TEST(ScenarioCorpus, EveryByteFlippedIsReadOrRefused) {
    std::ifstream in(TILTH_SOURCE_DIR "/tests/demo/all_keys.toml");
    std::ostringstream whole;
    whole << in.rdbuf();
    ASSERT_GT(whole.str().size(), 100u);
    for (std::size_t at = 0; at < whole.str().size(); at += 5) {
        std::string text = whole.str();
        text[at] = static_cast<char>(text[at] ^ (1 << (at % 8)));
        Problems problems;
        const bool read = parse_scenario(text, "flipped.toml", kContext, problems).has_value();
        EXPECT_EQ(read, problems.empty());
    }
}

TEST(ReadScenario, MissingFileAndEmptyTextAreProblems) {
    Problems missing, empty;
    EXPECT_FALSE(read_scenario("no/such/file.toml", kContext, missing));
    EXPECT_EQ(missing.list().at(0).key, "scenario");
    EXPECT_FALSE(parse_scenario("", "empty.toml", kContext, empty));
    EXPECT_EQ(empty.report("empty.toml").substr(0, 22), "empty.toml:1: terrain:");
}

TEST(ReadScenario, AllProblemsAreReportedInTheFilesOrder) {
    Problems problems;
    EXPECT_FALSE(parsed("spacing = 0\ntile_size = 65\n[view]\nfov = 0\n", problems));
    EXPECT_EQ(problems.list().size(), 3u);
    const std::string report = problems.report("F");
    EXPECT_LT(report.find("F:3: spacing: "), report.find("F:4: tile_size: "));
    EXPECT_LT(report.find("F:4: tile_size: "), report.find("F:6: fov: "));
    EXPECT_NE(report.find("allowed"), std::string::npos);
}

TEST(ReadScenario, LaterStepsAreKnownButRefused) {
    for (const char* step : {"wave = {}", "shock = {}"}) {
        Problems problems;
        EXPECT_FALSE(parsed("[[step]]\n" + std::string(step), problems));
        const std::string report = problems.report("F");
        EXPECT_NE(report.find("F:4: "), std::string::npos) << report;
        EXPECT_NE(report.find("does not have"), std::string::npos) << report;
        EXPECT_EQ(report.find("unknown"), std::string::npos) << report;
    }
}

TEST(ReadScenario, EveryKeyOfTheFormIsUnderstood) {
    Problems problems;
    const auto scenario = read_scenario(TILTH_SOURCE_DIR "/tests/demo/all_keys.toml", kContext, problems);
    ASSERT_TRUE(scenario) << problems.report("all_keys.toml");
    const GroundSettings& ground = scenario->terrain.settings.ground;
    EXPECT_EQ(ground.spacing_m, 2.0);
    EXPECT_EQ(ground.origin, (WorldPos{1e7, -1e7}));
    EXPECT_EQ(ground.quantum_m, 0.015625);
    EXPECT_EQ(ground.texels_per_post, 4);
    EXPECT_EQ(ground.tile_size, 512);
    EXPECT_EQ(ground.precision, HeightPrecision::bits16);
    EXPECT_EQ(scenario->terrain.settings.executor, ExecutorKind::Cpu);
    EXPECT_EQ(scenario->terrain.settings.slopes, SlopeFormat::rg16f);
    const TileSettings& tiles = scenario->terrain.settings.tiles;
    EXPECT_EQ(tiles.band, 0.25);
    EXPECT_EQ(tiles.budget.frame_target_ms, 20);
    EXPECT_EQ(tiles.budget.most_ms, 2.5);
    EXPECT_EQ(tiles.budget.most_bytes, 1048576u);
    EXPECT_EQ(tiles.most_gpu_bytes, 67108864u);
    EXPECT_EQ(scenario->terrain.settings.clipmap.n, 127);
    EXPECT_EQ(scenario->terrain.settings.clipmap.levels, 4);
    EXPECT_EQ(scenario->terrain.settings.clipmap.blend, 0.2);
    EXPECT_EQ(scenario->terrain.settings.clipmap.refine_above_px, 2.5);
    EXPECT_EQ(scenario->view.shown, (ShownDetail{DetailBackend::Hybrid, DetailPreset::Exact, DebugView::Off, true}));
    DetailSettings curved = detail_preset(DetailBackend::Hybrid, DetailPreset::Exact);
    EXPECT_FALSE(curved.phong.on) << "no preset asks for it";
    curved.phong.on = true;
    EXPECT_EQ(scenario->terrain.settings.detail, curved);
    EXPECT_EQ(scenario->view.ambient, 0.5);
    EXPECT_EQ(scenario->view.diffuse, 1.25);
    EXPECT_EQ(scenario->view.width, 320);
    EXPECT_EQ(scenario->view.fov_degrees, 45);
    const WorldSettings& world = scenario->terrain.settings.world;
    EXPECT_EQ(world.folder, TILTH_SOURCE_DIR "/tests/demo/world") << "beside the scenario";
    EXPECT_EQ(world.options.flush.when, FlushPolicy::When::Every);
    EXPECT_EQ(world.options.flush.interval_ms, 2.5);
    ASSERT_EQ(scenario->steps.size(), 26u);
    EXPECT_EQ(std::get<CameraStep>(scenario->steps[1].action).above_ground_m, 2.0);
    const auto& stamp = std::get<StampStep>(scenario->steps[2].action);
    EXPECT_EQ(stamp.request.centre, (WorldPos{1e7 + 20, -1e7 + 20}));
    EXPECT_EQ(stamp.request.rule, StampRule::Set);
    EXPECT_EQ(stamp.request.map, MapChoice::Coarse);
    EXPECT_EQ(stamp.request.level_m, 3.0);
    EXPECT_EQ(stamp.request.key, 4294967295u);
    EXPECT_EQ(stamp.repeat, 1'000'000);
    const auto& random = std::get<RandomStep>(scenario->steps[4].action);
    EXPECT_EQ(random.shapes, (std::vector<std::string>{"gaussian", "boot"}))
        << "in the library's order, not the file's";
    EXPECT_EQ(random.rules, (std::vector<StampRule>{StampRule::Add, StampRule::Min}));
    EXPECT_EQ(std::get<WaitStep>(scenario->steps[7].action).dt_s, (std::vector<double>{0.01, 0.02}));
    EXPECT_TRUE(std::get<ScreenshotStep>(scenario->steps[9].action).overlay);
    EXPECT_EQ(std::get<DumpStep>(scenario->steps[10].action).what, DumpWhat::Slope);
    const auto& stat = std::get<ExpectStat>(std::get<ExpectStep>(scenario->steps[14].action).what);
    EXPECT_EQ(stat.path, "last_frame.deform.passes");
    EXPECT_EQ(scenario->steps[14].number, 15);
    EXPECT_EQ(std::get<ViewersStep>(scenario->steps[15].action).at, (std::vector<WorldPos>{{10, 20}, {30.5, -40}}));
    EXPECT_TRUE(std::get<ViewersStep>(scenario->steps[16].action).at.empty());
    EXPECT_TRUE(std::holds_alternative<SaveStep>(scenario->steps[17].action));
    EXPECT_TRUE(std::holds_alternative<ReopenStep>(scenario->steps[18].action));
    EXPECT_TRUE(std::holds_alternative<CrashStep>(scenario->steps[19].action));
    EXPECT_EQ(std::get<UndoStep>(scenario->steps[20].action).strokes, 3);
    EXPECT_EQ(std::get<RedoStep>(scenario->steps[21].action).strokes, 1);
    const auto& show = std::get<ShowStep>(scenario->steps[22].action);
    EXPECT_EQ(show.backend, DetailBackend::Tessellation);
    EXPECT_EQ(show.preset, DetailPreset::High);
    EXPECT_EQ(show.debug, DebugView::Fetches);
    const auto& off = std::get<ShowStep>(scenario->steps[23].action);
    EXPECT_FALSE(off.backend || off.preset || off.phong) << "what is absent stays as it was";
    EXPECT_EQ(off.debug, DebugView::Off);
    const auto& phong = std::get<ShowStep>(scenario->steps[24].action);
    EXPECT_EQ(phong.phong, true);
    EXPECT_FALSE(phong.backend || phong.preset || phong.debug);
    EXPECT_EQ(std::get<ShowStep>(scenario->steps[25].action).phong, false);
}

TEST(ReadScenario, LightAndRefinementAreTheLibrarysUnlessGiven) {
    Problems problems;
    const auto plain = parsed("[view]\nclipmap = { n = 63 }\n", problems);
    const auto lit = parsed("[view]\nambient = 0\ndiffuse = 100\nclipmap = { refine_above_px = 0.1 }\n", problems);
    ASSERT_TRUE(plain && lit) << problems.report("F");
    EXPECT_EQ(plain->terrain.settings.clipmap.refine_above_px, ClipmapSettings().refine_above_px);
    EXPECT_EQ(lit->terrain.settings.clipmap.refine_above_px, 0.1) << "the lowest that is allowed";
    const Shading own = shading_of(plain->view, 0, 1), given = shading_of(lit->view, 0, 1);
    EXPECT_EQ(own.ambient, Shading().ambient);
    EXPECT_EQ(own.diffuse, Shading().diffuse);
    EXPECT_EQ(given.ambient, 0.0f);
    EXPECT_EQ(given.diffuse, 100.0f);
}

TEST(ReadScenario, TilesAreTheLibrarysUnlessGiven) {
    Problems problems;
    const auto plain = parsed("[[step]]\nscreenshot = \"a.png\"\n", problems);
    const auto least = parsed("band = 0.02\nbudget = {}\n", problems), most = parsed("band = 0.9\n", problems);
    ASSERT_TRUE(plain && least && most) << problems.report("F");
    const TileSettings& tiles = plain->terrain.settings.tiles;
    EXPECT_EQ(tiles.band, TileSettings().band);
    EXPECT_EQ(tiles.budget.frame_target_ms, TileSettings().budget.frame_target_ms);
    EXPECT_EQ(least->terrain.settings.tiles.budget.most_bytes, TileSettings().budget.most_bytes);
    EXPECT_EQ(tiles.most_gpu_bytes, 0u);
    EXPECT_FALSE(std::get<ScreenshotStep>(plain->steps[0].action).overlay);
}

// Scenarios name what the library names, in its order.
TEST(ReadScenario, EveryBackendPresetAndDebugViewHasItsWord) {
    ASSERT_EQ(kBackendNames.size(), 5u);
    for (std::size_t i = 0; i < kBackendNames.size(); ++i)
        EXPECT_EQ(kBackendNames[i], name_of(static_cast<DetailBackend>(i)));
    ASSERT_EQ(kPresetNames.size(), 4u);
    for (std::size_t i = 0; i < kPresetNames.size(); ++i)
        EXPECT_EQ(kPresetNames[i], name_of(static_cast<DetailPreset>(i)));
    EXPECT_EQ(kDebugNames.at(static_cast<std::size_t>(DebugView::Error)), "error");
    EXPECT_EQ(kDebugNames.size(), static_cast<std::size_t>(DebugView::Error) + 1);
    for (const std::string& backend : kBackendNames)
        for (const std::string& preset : kPresetNames) {
            Problems problems;
            const auto scenario =
                parsed("[view]\nbackend = \"" + backend + "\"\npreset = \"" + preset + "\"\n", problems);
            ASSERT_TRUE(scenario) << problems.report("F");
            const DetailSettings& detail = scenario->terrain.settings.detail;
            EXPECT_EQ(name_of(detail.backend), backend);
            EXPECT_EQ(detail, settings_of(scenario->view.shown));
            EXPECT_TRUE(check_detail(detail));
        }
}

TEST(ShowStep, WhatIsAbsentStays) {
    const ShownDetail before{DetailBackend::Hybrid, DetailPreset::Exact, DebugView::Level, true};
    EXPECT_EQ(shown_after(before, {}), before);
    EXPECT_EQ(shown_after(before, {.backend = DetailBackend::None}),
              (ShownDetail{DetailBackend::None, DetailPreset::Exact, DebugView::Level, true}));
    EXPECT_EQ(shown_after(before, {.preset = DetailPreset::Low, .debug = DebugView::Off}),
              (ShownDetail{DetailBackend::Hybrid, DetailPreset::Low, DebugView::Off, true}));
    EXPECT_EQ(shown_after(before, {.phong = false}),
              (ShownDetail{DetailBackend::Hybrid, DetailPreset::Exact, DebugView::Level, false}));
    EXPECT_TRUE(settings_of(before).phong.on);
    EXPECT_FALSE(settings_of({}).phong.on);
}

TEST(ReadScenario, DetailIsSlopesAloneUnlessAskedFor) {
    Problems problems;
    const auto plain = parsed("[view]\nfov = 50\n", problems), bare = parsed("", problems);
    ASSERT_TRUE(plain && bare) << problems.report("F");
    EXPECT_EQ(plain->terrain.settings.detail.backend, DetailBackend::None);
    EXPECT_EQ(plain->terrain.settings.detail.debug_view, DebugView::Off);
    EXPECT_FALSE(plain->terrain.settings.detail.phong.on);
    EXPECT_EQ(bare->terrain.settings.detail.backend, DetailBackend::None);
}

TEST(ReadScenario, AWorldIsInMemoryAndFlushesEachEditUnlessGiven) {
    const auto world_of = [](const std::string& terrain) {
        Problems problems;
        const auto scenario = parsed("", problems, "heights = \"flat:size=65,height=0\"\n" + terrain);
        EXPECT_TRUE(scenario) << problems.report("F");
        return scenario ? scenario->terrain.settings.world : WorldSettings{};
    };
    EXPECT_EQ(world_of("").folder, "");
    EXPECT_EQ(world_of("").options.flush.when, FlushPolicy::When::Each);
    EXPECT_EQ(world_of("flush = \"each\"").options.flush.when, FlushPolicy::When::Each);
    EXPECT_EQ(world_of("flush = \"manual\"").options.flush.when, FlushPolicy::When::Manual);
    for (const auto& [text, ms] : {std::pair{"5ms", 5.0}, {"0.1ms", 0.1}, {"60000ms", 60000.0}}) {
        const FlushPolicy flush = world_of("flush = \"" + std::string(text) + "\"").options.flush;
        EXPECT_EQ(flush.when, FlushPolicy::When::Every) << text;
        EXPECT_EQ(flush.interval_ms, ms) << text;
    }
    EXPECT_EQ(world_of("store = \"/some/where///\"").folder, "/some/where") << "an absolute path stays one";
    EXPECT_EQ(world_of("store = \"/\"").folder, "/");
}

TEST(ReadScenario, AnAutoStampGoesToTheCoarseMapFromEightPostsOn) {
    Problems below, at;
    const std::string stamp =
        "[[step]]\nstamp = { shape = \"disc\", centre = [9, 9], amplitude = 1, rule = \"set\", radius = ";
    EXPECT_TRUE(parsed("spacing = 2\n" + stamp + "15.999 }", below)) << below.report("F");
    EXPECT_FALSE(parsed("spacing = 2\n" + stamp + "16 }", at)) << "a coarse set needs a level";
    EXPECT_EQ(at.list().at(0).key, "level");
}

}  // namespace
}  // namespace tilth::demo
