// Crashes and openings at every place of a scenario leave the same bits, with tiles that come and go, by both executors
// and in both precisions; and the program itself: pictures, exit status, messages.
#include <iostream>

#include "demo/gl/gl_route.h"
#include "demo/play_fixture.h"
#include "demo/world_play.h"
#include "tilth/io/png.h"

namespace tilth::test {
namespace {

class WorldPlayGl : public WorldPlay {
protected:
    void SetUp() override {
        WorldPlay::SetUp();
        auto route = demo::GlRoute::offscreen("egl");
        if (!route) GTEST_SKIP() << route.error().message;
        route_.emplace(std::move(*route));
        get_proc_ = route_->get_proc();
    }
    std::optional<demo::GlRoute> route_;
};

/// Hills as in `kHills`, with the executor left open.
std::string hills(const std::string& executor, const std::string& precision) {
    return "heights = \"ridged:seed=3,size=129,relief=30\"\ntexels_per_post = 4\ntile_size = 64\nexecutor = \"" +
           executor + "\"\nprecision = \"" + precision + "\"\n";
}

/// Strokes on tiles that are resident and on tiles that are away; undone and done again in between.
const std::vector<std::string> kSession{
    "camera = { eye = [24, 40, 24], look_at = [30, 10, 30] }",
    kCoarse,
    kDetail,
    "wait = { frames = 2, dt = 0.01 }",
    kBoots,
    "undo = 2",
    kHeap,
    "teleport = [110, 110]",
    "wait = { frames = 3, dt = 0.01 }",
    kWalk,
    "undo = 2",
    "redo = 1",
};

TEST_F(WorldPlayGl, ACrashOrAnOpeningAtAnyPlaceChangesNothing) {
    for (const std::string executor : {"cpu", "gpu"})
        for (const std::string precision : {"bits32", "bits16"}) {
            const std::string ground = hills(executor, precision);
            const StateHash expected = hash_after(ground, kSession);
            EXPECT_NE(expected, hash_after(ground, {}));
            int worlds = 0;
            const auto expect_same = [&](const std::vector<std::string>& steps, const std::string& what, bool crashes) {
                SCOPED_TRACE(executor + " " + precision + ": " + what);
                // A sync an edit is what takes time here: only where a crash comes before the next flush.
                const std::string store = text("store = \"", executor, precision, worlds++, "\"\nflush = \"",
                                               crashes ? "each" : "manual", "\"\n");
                EXPECT_EQ(hash_after(ground + store, steps), expected);
            };
            std::vector<std::string> everywhere;
            for (std::size_t place = 0; place < kSession.size(); ++place) {
                // Each place sees a crash by one executor and an opening by the other, in each precision.
                const bool crash = (place % 2 == 0) == (executor == "cpu");
                const std::string end = crash ? "crash = true" : "reopen = true";
                std::vector<std::string> steps = kSession;
                steps.insert(steps.begin() + std::ptrdiff_t(place) + 1, end);
                if (place % 3 == 0) steps.insert(steps.begin() + std::ptrdiff_t(place) + 1, "save = true");
                expect_same(steps, text(end, " after step ", place + 1), crash);
                everywhere.insert(everywhere.end(), {kSession[place], end});
            }
            expect_same(everywhere, "everywhere", true);
        }
}

TEST_F(WorldPlayGl, EveryExecutorOpensWhatAnotherLeft) {
    const StateHash expected = hash_after(hills("cpu", "bits32"), kSession);
    const std::string store = "store = \"world\"\n";
    const auto middle = kSession.begin() + 6;
    std::ignore = hash_after(hills("gpu", "bits32") + store, {kSession.begin(), middle});
    EXPECT_EQ(hash_after(hills("cpu", "bits32") + store, {middle, kSession.end()}), expected);
    EXPECT_EQ(hash_after(hills("gpu", "bits32") + store, {}), expected);
    get_proc_ = nullptr;
    EXPECT_EQ(hash_after(hills("cpu", "bits32") + store, {}), expected) << "a server without GL";
}

TEST_F(WorldPlayGl, CameraAndViewersAreKept) {
    for (const char* end : {"crash = true", "reopen = true"}) {
        SCOPED_TRACE(end);
        const std::string hole =
            "stamp = { shape = \"disc\", radius = 3, amplitude = -0.25, rule = \"min\", map = \"detail\", centre = ";
        const PlayedWorld world =
            play(hills("cpu", "bits32") + "store = \"" + std::string(end).substr(0, 5) + "\"\n",
                 {"camera = { eye = [24, 60, 24], look_at = [30, 10, 30] }", hole + "[24, 24] }", hole + "[104, 24] }",
                  hole + "[24, 104] }", hole + "[64, 64] }", "viewers = [[104, 24]]",
                  "wait = { frames = 2, dt = 0.01 }", "expect = { stat = \"resident.tiles\", equals = 2 }", end,
                  "expect = { stat = \"resident.tiles\", equals = 2 }", "wait = { frames = 60, dt = 0.01 }",
                  "expect = { stat = \"resident.tiles\", equals = 2 }"});
        EXPECT_TRUE(world.good) << world.messages;
        EXPECT_EQ(world.report.frames.wall_ms.size(), 62u);
    }
}

/// Turns one bit of the file's middle round.
void damage(const std::string& file) {
    std::fstream bytes(file, std::ios::binary | std::ios::in | std::ios::out);
    const auto middle = std::streamoff(fs::file_size(file) / 2);
    bytes.seekg(middle);
    const char byte = char(bytes.get());
    bytes.seekp(middle);
    bytes.put(char(byte ^ 0x10));
}

TEST_F(WorldPlayGl, ADamagedDetailPageIsAMessageAndNoFailure) {
    const std::string ground = hills("cpu", "bits32") + "store = \"world\"\n";
    const std::string dump = "dump = { map = \"detail\", region = [[0, 0], [128, 128]], what = \"code\", file = \"";
    const StateHash all = hash_after(ground, {kDetail, kDetail, "undo = 1", "save = true"});
    damage(path("world/pages-1.tlp"));
    const PlayedWorld world = play(ground, {dump + path("codes.tif") + "\" }"});
    EXPECT_TRUE(world.good) << world.messages;
    EXPECT_TRUE(world.report.failures.empty());
    EXPECT_EQ(world.report.hash, all);
    EXPECT_NE(world.messages.find("store: " + path("world")), std::string::npos) << world.messages;
    EXPECT_NE(world.messages.find("from the journal"), std::string::npos) << world.messages;
}

TEST_F(Play, TheScenarioOfTheCrashLosesNothing) {
    const fs::path store = folder_ / "w\xc3\xb6rld on disk";
    for (const char* executor : {"cpu", "gpu"}) {
        SCOPED_TRACE(executor);
        fs::remove_all(store);
        const Ran ran = play(TILTH_SOURCE_DIR "/demo/scenarios/keeps.toml",
                             "--size 320x180 --store '" + store.string() + "/' --executor " + executor);
        ASSERT_EQ(ran.status, 0) << ran.output;
        EXPECT_EQ(ran.output, "");
        const auto pixels = [&](const char* name) {
            auto read = io::read_png_rgb8((folder_ / name).string());
            EXPECT_TRUE(read) << name;
            return read ? read->pixels : std::vector<std::uint8_t>{};
        };
        const auto before = pixels("keeps_1_before.png");
        // How finely far ground is drawn follows bounds, of which the GPU executor's are wider until it is opened
        // again.
        if (std::string(executor) == "cpu") {
            EXPECT_TRUE(pixels("keeps_2_after_crash.png") == before) << "to the last bit of every pixel";
            EXPECT_TRUE(pixels("keeps_4_redone.png") == before);
        }
        EXPECT_FALSE(pixels("keeps_3_undone.png") == before);
        EXPECT_TRUE(fs::exists(store / "world.tlw"));
        EXPECT_EQ(stats()["world"]["durable"], stats()["world"]["edits"]);
    }
    EXPECT_FALSE(fs::exists(TILTH_SOURCE_DIR "/demo/scenarios/world.tlw"));
}

TEST_F(Play, ExitStatusesOfWorldsOnDisk) {
    const std::string ground = "[terrain]\nheights = \"flat:size=65,height=10\"\n[view]\nsize = [16, 16]\n";
    const std::string in_memory = write("memory.toml", ground + "[[step]]\nreopen = true\n");
    const Ran memory = play(in_memory, "");
    EXPECT_EQ(memory.status, 1);
    EXPECT_NE(memory.output.find("memory.toml:6: step 1: reopen: "), std::string::npos) << memory.output;
    EXPECT_NE(memory.output.find("--store DIR"), std::string::npos) << memory.output;

    const std::string store = "--store '" + (folder_ / "world").string() + "'";
    EXPECT_EQ(play(in_memory, store).status, 0) << "the flag is what it lacks";
    const std::string other =
        write("other.toml", "[terrain]\nheights = \"flat:size=65,height=11\"\nstore = \"world\"\n");
    const Ran by_file = play(other, "");
    EXPECT_EQ(by_file.status, 2);
    EXPECT_NE(by_file.output.find("other.toml:3: store: "), std::string::npos) << by_file.output;
    const Ran by_flag = play(other, store);
    EXPECT_EQ(by_flag.status, 2);
    EXPECT_NE(by_flag.output.find("other.toml:1: --store: "), std::string::npos) << by_flag.output;
}

}  // namespace
}  // namespace tilth::test
