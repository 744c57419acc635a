// Steps of undo and of worlds on disk: what each stroke is, what a crash costs, what is said when something fails. No
// GL.
#include <array>

#include "demo/world_play.h"

namespace tilth::test {
namespace {

const std::string kStore = "store = \"world/\"\n";

TEST_F(WorldPlay, EachStepThatStampsIsOneStroke) {
    const StateHash before = hash_after(kHills, {kHeap});
    for (const std::string& step : {kCoarse, kDetail, kBoots, kHeap, kWalk}) {
        SCOPED_TRACE(step);
        const StateHash after = hash_after(kHills, {kHeap, step});
        EXPECT_NE(after, before);
        EXPECT_EQ(hash_after(kHills, {kHeap, step, "undo = 1"}), before);
        EXPECT_EQ(hash_after(kHills, {kHeap, step, "undo = 1", "redo = 1"}), after);
    }
}

TEST_F(WorldPlay, UndoOfManyStrokesIsUntouchedGround) {
    const StateHash untouched = hash_after(kHills, {});
    const std::vector<std::string> strokes{kCoarse, kDetail, kBoots, kHeap, kWalk};
    std::vector<std::string> steps = strokes;
    steps.insert(steps.end(), {"undo = 2", "undo = 3"});
    EXPECT_EQ(hash_after(kHills, steps), untouched);
    steps.push_back("redo = 5");
    EXPECT_EQ(hash_after(kHills, steps), hash_after(kHills, strokes));
}

TEST_F(WorldPlay, FewerStrokesThanAskedForFailTheStepAndChangeNothing) {
    const StateHash after = hash_after(kHills, {kHeap, kBoots});
    const PlayedWorld undone = play(kHills, {kHeap, kBoots, "undo = 3"});
    ASSERT_EQ(undone.report.failures.size(), 1u);
    EXPECT_NE(undone.report.failures[0].find("step 3: undo: 3 strokes were asked for, and 2 can be undone"),
              std::string::npos)
        << undone.report.failures[0];
    EXPECT_EQ(undone.report.hash, after);
    const PlayedWorld redone = play(kHills, {kHeap, kBoots, "undo = 1", "redo = 1", "redo = 1"});
    ASSERT_EQ(redone.report.failures.size(), 1u);
    EXPECT_NE(redone.report.failures[0].find("step 5: redo: 1 strokes were asked for, and 0 can be redone"),
              std::string::npos)
        << redone.report.failures[0];
    EXPECT_EQ(redone.report.hash, after);
}

TEST_F(WorldPlay, StepsOfTheDiskFailInMemoryAndSayWhatToDo) {
    const PlayedWorld world = play(kHills, {kHeap, "save = true", "reopen = true", "crash = true"});
    ASSERT_EQ(world.report.failures.size(), 3u);
    for (const auto& [i, step] : {std::pair{0, "step 2: save: "}, {1, "step 3: reopen: "}, {2, "step 4: crash: "}}) {
        const std::string& failure = world.report.failures[std::size_t(i)];
        EXPECT_NE(failure.find(step), std::string::npos) << failure;
        EXPECT_NE(failure.find("set store in [terrain]"), std::string::npos) << failure;
    }
    EXPECT_EQ(world.report.hash, hash_after(kHills, {kHeap})) << "the run goes on";
    EXPECT_FALSE(world.report.world);
}

TEST_F(WorldPlay, ACrashCostsWhatWasNotFlushedAndNothingElse) {
    const std::string manual = kHills + "flush = \"manual\"\n";
    const StateHash saved = hash_after(kHills, {kCoarse, kBoots}), all = hash_after(kHills, {kCoarse, kBoots, kDetail});
    EXPECT_EQ(hash_after(manual + "store = \"a\"\n", {kCoarse, kBoots, "save = true", kDetail, "crash = true"}), saved);
    EXPECT_EQ(hash_after(manual + "store = \"b\"\n", {kCoarse, kBoots, "reopen = true", kDetail, "crash = true"}),
              saved);
    EXPECT_EQ(hash_after(manual + "store = \"c\"\n", {kCoarse, kBoots, kDetail, "reopen = true", "crash = true"}), all);
    EXPECT_EQ(hash_after(manual + "store = \"d\"\n", {kCoarse, kBoots, kDetail, "crash = true"}),
              hash_after(kHills, {}));
    EXPECT_EQ(hash_after(kHills + "store = \"e\"\n", {kCoarse, kBoots, "save = true", kDetail, "crash = true"}), all)
        << "each edit is durable unless another policy is asked for";
}

TEST_F(WorldPlay, OriginalHeightsAreThoseOfTheSourceAfterOpening) {
    // Levels of coarse min, max and set are original heights: not those that the first stroke left.
    const std::string deep = "stamp = { shape = \"disc\", centre = [64, 64], radius = 60, amplitude = -9 }";
    const StateHash after = hash_after(kHills, {deep, kCoarse});
    EXPECT_EQ(hash_after(kHills + "store = \"a\"\n", {deep, "save = true", "reopen = true", kCoarse}), after);
    EXPECT_EQ(hash_after(kHills + "store = \"b\"\n", {deep, "crash = true", kCoarse}), after);
}

TEST_F(WorldPlay, TheNextRunGoesOnWhereTheLastEnded) {
    const StateHash all = hash_after(kHills, {kCoarse, kBoots, kHeap, kDetail});
    ASSERT_EQ(play(kHills + kStore, {kCoarse, kBoots}).report.world->edits, 6u + 8u);
    EXPECT_EQ(hash_after(kHills + kStore, {kHeap, kDetail}), all);
    EXPECT_EQ(hash_after(kHills + kStore, {"undo = 4"}), hash_after(kHills, {})) << "strokes of both runs";
    EXPECT_EQ(hash_after(kHills + kStore, {"redo = 4"}), all);
}

TEST_F(WorldPlay, StatisticsAreOfAllOpenings) {
    const std::string frame = "wait = { frames = 1, dt = 0.01 }";
    const PlayedWorld one = play(kHills, {kHeap, frame, kDetail, frame, frame});
    const PlayedWorld two =
        play(kHills + kStore, {kHeap, frame, "save = true", "reopen = true", kDetail, frame, frame});
    EXPECT_TRUE(two.good) << two.messages;
    EXPECT_GT(one.report.total.deform.texels, 0u);
    EXPECT_EQ(two.report.total.deform.texels, one.report.total.deform.texels) << "a saved world replays nothing";
    EXPECT_EQ(two.report.frames.wall_ms.size(), 3u);
    EXPECT_EQ(two.report.total.store.snapshots, 1u);
    EXPECT_EQ(two.report.total.store.failures, 0u);
    ASSERT_TRUE(two.report.world);
    EXPECT_EQ(two.report.world->edits, 13u);
    EXPECT_EQ(two.report.world->durable, 13u);
    EXPECT_EQ(two.report.world->committed, 3u);
    EXPECT_EQ(two.report.queries.size(), 0u);
}

TEST_F(WorldPlay, AnotherWorldsFolderIsRefusedAtItsLine) {
    ASSERT_TRUE(play(kHills + kStore, {kHeap}).good);
    const std::string flat =
        "heights = \"ridged:seed=4,size=129,relief=30\"\ntexels_per_post = 4\ntile_size = 64\nexecutor = \"cpu\"\n";
    const std::string other_heights = open(flat + kStore, {})->messages.str();
    EXPECT_NE(other_heights.find("F:6: store: "), std::string::npos) << other_heights;
    EXPECT_NE(other_heights.find("heights"), std::string::npos) << other_heights;
    const std::string other_tiles = open(kHills + "detail = false\n" + kStore, {})->messages.str();
    EXPECT_NE(other_tiles.find("F:7: store: "), std::string::npos) << other_tiles;
    EXPECT_NE(other_tiles.find("detail"), std::string::npos) << other_tiles;
    const std::string no_parent = open(kHills + "store = \"no/such/parent\"\n", {})->messages.str();
    EXPECT_NE(no_parent.find("F:6: store: "), std::string::npos) << no_parent;
    const auto open_now = open(kHills + kStore, {});
    ASSERT_TRUE(open_now->world) << open_now->messages.str();
    const std::string locked = open(kHills + kStore, {})->messages.str();
    EXPECT_NE(locked.find("F:6: store: "), std::string::npos) << locked;
    EXPECT_NE(locked.find("locked"), std::string::npos) << locked;
}

TEST_F(WorldPlay, AWorldThatCannotBeOpenedAgainFailsThatStepAndAllBehindIt) {
    const auto opened =
        open(kHills + kStore, {kHeap, "reopen = true", kBoots, "query = { kind = \"height\", at = [[9, 9]] }"});
    ASSERT_TRUE(opened->world) << opened->messages.str();
    std::filesystem::remove(path("world/world.tlw"));
    const PlayedWorld world = played(*opened);
    EXPECT_FALSE(world.good);
    ASSERT_GE(world.report.failures.size(), 3u);
    EXPECT_NE(world.report.failures[0].find("step 2: "), std::string::npos);
    EXPECT_NE(world.report.failures[0].find("world.tlw"), std::string::npos) << world.report.failures[0];
    EXPECT_NE(world.report.failures[1].find("step 3: the world is not open"), std::string::npos);
    EXPECT_NE(world.report.failures[2].find("step 4: the world is not open"), std::string::npos);
    EXPECT_GT(world.report.total.deform.texels, 0u) << "what was done before still counts";
}

TEST_F(WorldPlay, ADamagedWorldIsAMessageAndNoFailure) {
    const StateHash all = hash_after(kHills + kStore, {kCoarse, "save = true"});
    const std::string pages = path("world/pages-1.tlp");
    std::fstream file(pages, std::ios::binary | std::ios::in | std::ios::out);
    ASSERT_TRUE(file);
    const auto middle = std::streamoff(std::filesystem::file_size(pages) / 2);
    file.seekg(middle);
    const char byte = char(file.get());
    file.seekp(middle);
    file.put(char(byte ^ 0x10));
    file.close();
    const PlayedWorld world = play(kHills + kStore, {"save = true"});
    EXPECT_TRUE(world.good);
    EXPECT_TRUE(world.report.failures.empty());
    EXPECT_EQ(world.report.hash, all);
    EXPECT_NE(world.messages.find("store: " + path("world")), std::string::npos) << world.messages;
    EXPECT_EQ(hash_after(kHills + kStore, {}), all) << "nothing more to tell: it was saved whole";
}

}  // namespace
}  // namespace tilth::test
