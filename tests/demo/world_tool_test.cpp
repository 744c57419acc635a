// tilth-world, as a shell runs it.
#include <gtest/gtest.h>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "demo/run_program.h"
#include "io/scratch_folder.h"
#include "store/edit_script.h"
#include "tilth/core/hash.h"
#include "tilth/io/height_file.h"
#include "tilth/io/height_writer.h"

namespace tilth {
namespace {

using test::Ran;

Ran run_tool(const std::string& arguments) { return test::run_program(TILTH_WORLD_PROGRAM, arguments); }

class WorldTool : public testing::Test {
protected:
    void SetUp() override {
        const auto world = open();
        test::EditScript script(8);
        ASSERT_TRUE(test::advance(*world, script, 40));
        ASSERT_TRUE(world->save());
        ASSERT_TRUE(test::advance(*world, script, 50));
    }
    std::unique_ptr<SavedGround> open(std::uint64_t keep_journal_bytes = 64u << 20) {
        auto opened =
            test::open_script_world(made_, path_, {.keep_journal_bytes = keep_journal_bytes, .heights = made_.heights});
        EXPECT_TRUE(opened) << opened.error().message;
        return std::move(*opened);
    }
    /// A file of the world.
    [[nodiscard]] std::string file(const std::string& beginning) const {
        for (const auto& entry : std::filesystem::directory_iterator(path_))
            if (entry.path().filename().string().starts_with(beginning)) return entry.path().string();
        return {};
    }
    [[nodiscard]] Ran run(const std::string& command, const std::string& rest = "") const {
        return run_tool(command + " '" + path_ + "' " + rest);
    }

    test::ScratchFolder scratch_;
    test::ScriptWorld made_;
    std::string path_ = scratch_.path("a world");
};

TEST_F(WorldTool, TellsWhatAWorldIs) {
    const Ran info = run("info");
    EXPECT_EQ(info.status, 0) << info.output;
    EXPECT_TRUE(info.says(made_.heights)) << info.output;
    EXPECT_TRUE(info.says("129 x 129 posts")) << info.output;
    EXPECT_TRUE(info.says("edits: 50, of which the pages hold 40")) << info.output;
}

TEST_F(WorldTool, FindsDamage) {
    EXPECT_EQ(run("verify").status, 0);
    const std::string pages = file("pages-");
    auto bytes = test::ScratchFolder::bytes_of_file(pages);
    bytes[bytes.size() / 3] = static_cast<char>(~bytes[bytes.size() / 3]);
    scratch_.put("a world/" + std::filesystem::path(pages).filename().string(), bytes);
    const Ran verified = run("verify");
    EXPECT_EQ(verified.status, 1) << verified.output;
    EXPECT_TRUE(verified.says("pages-")) << verified.output;
}

TEST_F(WorldTool, CompactsWithoutChangingTheWorld) {
    const StateHash before = open()->ground().hash();
    const auto size = std::filesystem::file_size(file("pages-"));
    for (int i = 0; i < 5; ++i) {
        const auto world = open();
        ASSERT_TRUE(world->stamp({.centre = {60, 60}, .radius_m = 20, .amplitude_m = 0.01}));
        ASSERT_TRUE(world->save());
        ASSERT_TRUE(world->undo());
        ASSERT_TRUE(world->save());
    }
    const auto grown = std::filesystem::file_size(file("pages-"));
    EXPECT_GT(grown, size);
    const Ran compacted = run("compact");
    EXPECT_EQ(compacted.status, 0) << compacted.output;
    EXPECT_LT(std::filesystem::file_size(file("pages-")), grown);
    EXPECT_EQ(open()->ground().hash(), before);
}

TEST_F(WorldTool, ReplaysTheJournal) {
    const Ran replayed = run("replay");
    EXPECT_EQ(replayed.status, 0) << replayed.output;
    EXPECT_TRUE(replayed.says("the same"));
    EXPECT_TRUE(replayed.says(hex16(open()->ground().hash().detail))) << replayed.output;
    ASSERT_TRUE(open(0)->save());  // gives up the journal
    const Ran released = run("replay");
    EXPECT_EQ(released.status, 1) << released.output;
    EXPECT_TRUE(released.says("the journal begins at edit")) << released.output;
}

TEST_F(WorldTool, ExportsWhatAQueryAnswers) {
    for (const char* map : {"coarse", "detail", "sum"}) {
        const std::string out = scratch_.path(std::string(map) + ".tif");
        const Ran exported = run("export", text("--region 40 30 60 45 --map ", map, " --out '", out, "'"));
        ASSERT_EQ(exported.status, 0) << exported.output;
        const auto read = io::read_heights(out);
        ASSERT_TRUE(read) << read.error().message;
        const bool coarse = std::string(map) == "coarse";
        ASSERT_EQ((*read)->width(), coarse ? 21 : 61);
        ASSERT_EQ((*read)->depth(), coarse ? 16 : 46);
        const auto world = open();
        const double spacing = coarse ? 1 : 1.0 / 3;
        for (std::int32_t z = 0; z < (*read)->depth(); ++z)
            for (std::int32_t x = 0; x < (*read)->width(); ++x) {
                const double right = world->ground().height_m({40 + spacing * x, 30 + spacing * z},
                                                              coarse                         ? MapSelect::Coarse
                                                              : std::string(map) == "detail" ? MapSelect::Detail
                                                                                             : MapSelect::Sum);
                // A float has 24 bits; positions between texels are rounded, and slopes are below 100.
                ASSERT_NEAR((*read)->height_m({x, z}), right, std::abs(right) * 6e-8 + 1e-6);
            }
    }
}

TEST_F(WorldTool, ImportsWithinTheStepItStates) {
    std::vector<float> heights;
    for (int z = 0; z < 14; ++z)
        for (int x = 0; x < 21; ++x) heights.push_back(static_cast<float>(3 + 0.25 * x * std::sin(0.4 * z)));
    const std::string in = scratch_.path("in.tif");
    ASSERT_TRUE(io::write_floats(in, heights, 21, 14));
    auto before = open();
    const Ground& old = before->ground();
    std::vector<double> outside;
    for (int i = 0; i < 129; ++i) outside.push_back(old.height_m({double(i), 29}, MapSelect::Coarse));
    const std::size_t strokes = before->history().undoable();
    before.reset();

    const Ran imported = run("import", "--map coarse --at 40 30 '" + in + "'");
    ASSERT_EQ(imported.status, 0) << imported.output;
    const auto world = open();
    const double range = 20 * 0.25 * 2, step = range / 65535;
    for (int z = 0; z < 14; ++z)
        for (int x = 0; x < 21; ++x)
            ASSERT_NEAR(world->ground().height_m({40.0 + x, 30.0 + z}, MapSelect::Coarse),
                        heights[static_cast<std::size_t>(21 * z + x)], step)
                << x << ", " << z;
    for (int i = 0; i < 129; ++i)
        EXPECT_EQ(world->ground().height_m({double(i), 29}, MapSelect::Coarse), outside[static_cast<std::size_t>(i)]);
    EXPECT_EQ(world->history().undoable(), strokes + 1);
}

TEST_F(WorldTool, SaysWhatCannotBeDone) {
    const auto refused = [](const Ran& ran, const std::string& why) {
        EXPECT_EQ(ran.status, 2) << ran.output;
        EXPECT_TRUE(ran.says("tilth-world: ") || ran.says("--help")) << ran.output;
        EXPECT_TRUE(ran.says(why)) << ran.output;
    };
    refused(run_tool("info '" + scratch_.path("no world") + "'"), "no world");
    refused(run("replay", "--heights hill:size=129,peak=11,sigma=30"), "heights");
    refused(run("export", "--region 400 400 500 500 --out '" + scratch_.path("x.tif") + "'"), "--region");
    refused(run("import", "--map coarse --at 0 0 '" + scratch_.path("none.tif") + "'"), "none.tif");
    refused(run("polish"), "--help");
    const auto world = open();
    refused(run("info"), "lock");
}

}  // namespace
}  // namespace tilth
