// Scenarios in which tiles come and go: footprints are found again, statistics tell what is resident, trouble with the
// store is told once, and no answer depends on what is in memory.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iostream>
#include <iterator>
#include <sstream>

#include "demo/gl/gl_route.h"
#include "demo/overlay/residency_map.h"
#include "demo/play_fixture.h"
#include "demo/player/player.h"
#include "demo/scenario/read_scenario.h"
#include "demo/world/open_world.h"
#include "demo/world/stamp_folder.h"
#include "demo/world/world_session.h"
#include "tilth/io/png.h"

namespace tilth::test {
namespace {

using Pixel = std::array<int, 3>;

Pixel pixel(const io::Rgb8Picture& picture, int x, int y) {
    const std::size_t at = (std::size_t(y) * std::size_t(picture.width) + std::size_t(x)) * 3;
    return {picture.pixels[at], picture.pixels[at + 1], picture.pixels[at + 2]};
}

/// As a clear stores a colour in 8 bits; drivers may round either way.
void expect_colour(const Pixel& got, const Vec3f& colour, const char* what) {
    const float c[] = {colour.x, colour.y, colour.z};
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(double(got[i]), 255.0 * double(c[i]), 1.0) << what;
}

std::string content_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Both routes, or those that this machine has.
std::vector<std::string> routes() {
    std::vector<std::string> open;
    for (const std::string route : {"egl", "osmesa"}) {
        if (const auto opened = demo::GlRoute::offscreen(route))
            open.push_back(route);
        else
            std::cout << "skipped " << route << ": " << opened.error().message << std::endl;
    }
    return open;
}

TEST_F(Play, FootprintsAreFoundAgain) {
    ASSERT_FALSE(routes().empty());
    for (const std::string& route : routes()) {
        SCOPED_TRACE(route);
        const Ran ran = play(TILTH_SOURCE_DIR "/demo/scenarios/footprints.toml", "--size 320x180 --context " + route);
        ASSERT_EQ(ran.status, 0) << ran.output;
        const auto picture = [&](const char* name) {
            auto read = io::read_png_rgb8((folder_ / name).string());
            EXPECT_TRUE(read) << name;
            return read ? *read : io::Rgb8Picture{};
        };
        const io::Rgb8Picture before = picture("footprints_1_before.png"), map = picture("footprints_2_resident.png"),
                              away = picture("footprints_3_away.png"), after = picture("footprints_4_after.png");
        EXPECT_EQ(before.pixels, after.pixels) << "what comes back is what went, to the last bit of every pixel";
        EXPECT_NE(before.pixels, away.pixels);

        // 7 x 7 tiles; two fifths of 180 pixels give cells of 10; a margin of 8, a board of 2 more.
        const int left = 320 - 8 - 70, top = 8;
        for (int y = 0; y < 180; ++y)
            for (int x = 0; x < 320; ++x) {
                const bool on_map = x >= left - 2 && x < left + 72 && y >= top - 2 && y < top + 72;
                if (!on_map) {
                    ASSERT_EQ(pixel(before, x, y), pixel(map, x, y)) << x << ", " << y;
                }
            }
        const TileReport resident{.tile = {2, 2}, .state = TileState::Resident, .interest = Interest::Active},
            absent{.tile = {2, 2}, .state = TileState::Absent};
        const auto of_tile = [&](const io::Rgb8Picture& p, int x, int z, int dx, int dy) {
            return pixel(p, left + x * 10 + dx, top + z * 10 + dy);
        };
        expect_colour(of_tile(map, 2, 2, 2, 2), demo::look_of(&resident).fill, "resident");
        expect_colour(of_tile(map, 2, 2, 1, 5), *demo::look_of(&resident).frame, "active");
        expect_colour(of_tile(map, 5, 5, 5, 5), demo::look_of(nullptr).fill, "untouched");
        expect_colour(of_tile(away, 2, 2, 2, 2), demo::look_of(&absent).fill, "written and gone");
        std::cout << route << ": smallest lead " << stats()["walk"]["smallest_lead_m"] << " m, "
                  << stats()["walk"]["smallest_lead_ms"] << " ms" << std::endl;
    }
}

/// Flat ground of 8 x 8 tiles of 16 m; every tile's middle is far from its apron.
const std::string kTiles =
    "[terrain]\nheights = \"flat:size=129,height=10\"\ntexels_per_post = 4\ntile_size = 64\n[view]\nsize = [16, 16]\n"
    "clipmap = { n = 15, levels = 3 }\n";

std::string hole(double x, double z) {
    return text("[[step]]\nstamp = { shape = \"disc\", centre = [", x, ", ", z,
                "], radius = 3, amplitude = -0.25, rule = \"min\", map = \"detail\" }\n");
}

TEST_F(Play, TilesAreResidentAboutEveryViewerAndNowhereElse) {
    const std::string scenario =
        write("viewers.toml",
              kTiles +
                  "[[step]]\ncamera = { eye = [24, 20, 24], look_at = [30, 10, 30] }\n"
                  "[[step]]\nexpect = { stat = \"resident.tile_bytes\", equals = 0 }\n" +
                  hole(24, 24) + hole(104, 24) + hole(24, 104) + hole(104, 104) +
                  "[[step]]\nviewers = [[104, 24], [104, 104]]\n"
                  "[[step]]\nwait = { frames = 2, dt = 0.01 }\n"
                  "[[step]]\nexpect = { stat = \"resident.tiles\", equals = 3 }\n"
                  "[[step]]\nviewers = [[24, 104]]\n"
                  "[[step]]\nwait = { frames = 60, dt = 0.01 }\n"
                  "[[step]]\nexpect = { stat = \"resident.tiles\", equals = 2 }\n"
                  "[[step]]\nviewers = []\n"
                  "[[step]]\nwait = { frames = 60, dt = 0.01 }\n"
                  "[[step]]\nexpect = { stat = \"resident.tiles\", equals = 1 }\n"
                  "[[step]]\nexpect = { stat = \"total.cache.late_stamps\", at_least = 1 }\n"  // of (24, 104), where
                                                                                               // nobody was
                  "[[step]]\nexpect = { stat = \"total.cache.evictions\", equals = 3 }\n"
                  "[[step]]\nexpect = { stat = \"total.cache.failures\", equals = 0 }\n"
                  "[[step]]\nexpect = { height_at = [104, 104], value = 9.75, within = 0 }\n"
                  "[[step]]\nexpect = { height_at = [24, 104], value = 9.75, within = 0 }\n");
    for (const char* executor : {"cpu", "gpu"}) {
        const Ran ran = play(scenario, std::string("--executor ") + executor);
        EXPECT_EQ(ran.status, 0) << executor << ": " << ran.output;
    }
}

TEST_F(Play, AWalksPrintsAreThoseOfThePath) {
    const std::string print =
        "shape = \"boot\", radius = 0.6, amplitude = -0.05, rule = \"min\", alternate = 0.7, mirror "
        "= true, map = \"detail\"";
    const std::string walk =
        write("walk.toml", kTiles +
                               "[[step]]\ncamera = { eye = [40, 12, 60], look_at = [50, 10, 60] }\n"
                               "[[step]]\nwalk = { to = [58, 72], speed = 9, dt = 0.04, stride = "
                               "1.5, print = { " +
                               print +
                               " } }\n"
                               "[[step]]\nexpect = { stat = \"walk.missing_frames\", equals = 0 }\n");
    const std::string path = write(
        "path.toml", kTiles + "[[step]]\npath = { points = [[40, 60], [58, 72]], spacing = 1.5, " + print + " }\n");
    std::vector<std::string> hashes;
    for (const std::string& scenario : {walk, path})
        for (const char* executor : {"cpu", "gpu"}) {
            const Ran ran = play(scenario, std::string("--executor ") + executor);
            ASSERT_EQ(ran.status, 0) << ran.output;
            hashes.push_back(stats()["hash"]["detail"]);
        }
    EXPECT_NE(hashes[0], "2d06800538d394c2") << "there are prints";
    for (const std::string& hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

TEST_F(Play, AWalkersFeetAlternate) {
    // A disc for a boot: flat, so that what it leaves is known. Left of +x is -z.
    const std::string scenario =
        write("feet.toml",
              kTiles +
                  "[[step]]\ncamera = { eye = [60, 12, 60], look_at = [70, 10, 60] }\n"
                  "[[step]]\nwalk = { to = [69, 60], speed = 5, dt = 0.1, stride = 3, print = { shape = \"disc\", "
                  "radius = 1, amplitude = -0.25, rule = \"min\", alternate = 1.5, map = \"detail\" } }\n"
                  "[[step]]\nquery = { kind = \"height\", at = [[60, 58.5], [60, 61.5], [63, 58.5], [63, 61.5], "
                  "[66, 58.5], [66, 61.5], [69, 58.5], [69, 61.5]], map = \"detail\" }\n");
    ASSERT_EQ(play(scenario, "").status, 0);
    EXPECT_EQ(stats()["queries"][0], Json::parse("[-0.25, 0.0, 0.0, -0.25, -0.25, 0.0, 0.0, -0.25]"));
}

TEST_F(Play, DumpsAreTheSameWhereverTheirTilesAre) {
    const std::string dump = "[[step]]\ndump = { map = \"detail\", region = [[28, 28], [36, 36]], what = \"";
    const auto dumps = [&](const std::string& when) {
        return dump + "code\", file = \"code_" + when + ".csv\" }\n" + dump + "slope\", file = \"slope_" + when +
               ".csv\" }\n";
    };
    const std::string scenario =
        write("dump.toml", kTiles + "[[step]]\ncamera = { eye = [32, 20, 32], look_at = [30, 10, 30] }\n" +
                               hole(32, 32) + "[[step]]\nwait = { frames = 2, dt = 0.01 }\n" + dumps("here") +
                               "[[step]]\nteleport = [120, 120]\n[[step]]\nwait = { frames = 60, dt = 0.01 }\n"
                               "[[step]]\nexpect = { stat = \"resident.tiles\", equals = 0 }\n" +
                               dumps("away"));
    for (const char* executor : {"cpu", "gpu"}) {
        SCOPED_TRACE(executor);
        const Ran ran = play(scenario, std::string("--executor ") + executor);
        ASSERT_EQ(ran.status, 0) << ran.output;
        for (const char* what : {"code", "slope"}) {
            const std::string here = content_of(folder_ / (std::string(what) + "_here.csv"));
            EXPECT_EQ(here, content_of(folder_ / (std::string(what) + "_away.csv"))) << what;
        }
        // -0.25 m in steps of 2^-28 m below the zero code.
        EXPECT_NE(content_of(folder_ / "code_here.csv").find("32,32," + std::to_string((1u << 31) - (1u << 26))),
                  std::string::npos);
    }
}

TEST_F(Play, ABoundOfMemoryThatHoldsNoFourTilesIsRefusedAtItsLine) {
    const std::string scenario =
        write("bound.toml", "[terrain]\nheights = \"flat:size=129,height=10\"\ntile_size = 64\ntile_memory = 1000\n");
    const Ran ran = play(scenario, "");
    EXPECT_EQ(ran.status, 2);
    EXPECT_NE(ran.output.find("bound.toml:4: tile_memory: "), std::string::npos) << ran.output;
}

/// Has a tile that cannot be read.
class BrokenStore final : public TileStore {
public:
    Result<std::vector<TileIndex>> tiles() override { return std::vector<TileIndex>{{1, 1}}; }
    Result<std::vector<Page>> load(TileIndex, const PageRect&) override {
        return Error{ErrorCode::FileFormat, "the disk has a scratch"};
    }
    Result<void> save(TileIndex, std::span<const Page>) override { return {}; }
};

TEST_F(Play, ATileThatCannotBeReadFailsOneStepAndStopsNoFrame) {
    auto route = demo::GlRoute::offscreen("egl");
    if (!route) GTEST_SKIP() << route.error().message;
    demo::Problems problems;
    const std::string shot = (folder_ / "coarse.png").string();
    auto scenario =
        demo::parse_scenario(kTiles +
                                 "[[step]]\ncamera = { eye = [24, 20, 24], look_at = [30, 10, 30] }\n"
                                 "[[step]]\nwait = { frames = 300, dt = 0.01 }\n"
                                 "[[step]]\nwait = { frames = 3, dt = 0.01 }\n"
                                 "[[step]]\nscreenshot = \"" +
                                 shot + "\"\n",
                             "broken.toml", {demo::shape_names(TILTH_SOURCE_DIR "/stamps"), demo::has_stat}, problems);
    ASSERT_TRUE(scenario) << problems.report("F");
    scenario->terrain.settings.tiles.store = std::make_shared<BrokenStore>();
    std::ostringstream errors;
    auto world = demo::WorldSession::open({scenario->terrain, demo::load_heights(scenario->terrain, problems),
                                           TILTH_SOURCE_DIR "/stamps", route->get_proc()},
                                          problems, errors);
    ASSERT_TRUE(world) << problems.report("F");
    auto screen = demo::Screen::create(route->get_proc(), scenario->view);
    ASSERT_TRUE(screen) << screen.error().message;
    demo::Player player(*world, *scenario, &*screen, {folder_, "egl", 0, 20}, errors);
    EXPECT_FALSE(player.play());
    const demo::RunReport report = player.report(false);
    EXPECT_EQ(report.frames.wall_ms.size(), 303u) << "frames go on";
    EXPECT_GE(report.total.cache.failures, 1u);
    ASSERT_GE(report.failures.size(), 2u);
    EXPECT_NE(report.failures[0].find("step 2: "), std::string::npos) << report.failures[0];
    EXPECT_NE(report.failures[0].find("the disk has a scratch"), std::string::npos) << report.failures[0];
    EXPECT_NE(report.failures[1].find("step 4: "), std::string::npos)
        << "the frames after it are good, and the screenshot lacks the tile: " << report.failures[1];
    EXPECT_TRUE(io::read_png_rgb8(shot)) << "it is made all the same";
}

}  // namespace
}  // namespace tilth::test
