// Worlds that earlier versions wrote open for ever, and are what they were. See samples/README.md.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "io/scratch_folder.h"
#include "store/edit_script.h"
#include "tilth/core/hash.h"

namespace tilth {
namespace {

/// What made them: the script with seed 42, saved after 24 edits, then 9 more.
constexpr std::uint64_t kSeed = 42, kSaved = 24, kEdits = 33;

struct Sample {
    const char* folder;
    HeightPrecision precision;
    StateHash hash;  ///< frozen with the files; a reference that does the same edits must have it too
};

void PrintTo(const Sample& sample, std::ostream* out) { *out << sample.folder; }

constexpr Sample kSamples[] = {
    {"version-1-bits32", HeightPrecision::bits32, {0xf52a283cde564eef, 0x823814e812eaaabd}},
    {"version-1-bits16", HeightPrecision::bits16, {0xeeb239386fa6dc5a, 0x23b8d554b1a5c6d9}},
};

test::ScriptWorld world_of(const Sample& sample) {
    return {.precision = sample.precision, .heights = "hill:size=33,peak=12,sigma=9"};
}

class Samples : public testing::TestWithParam<Sample> {
protected:
    static std::string folder() { return text(TILTH_SOURCE_DIR, "/tests/store/samples/", GetParam().folder); }
};
INSTANTIATE_TEST_SUITE_P(All, Samples, testing::ValuesIn(kSamples), [](const auto& of) {
    std::string name = of.param.folder;
    std::erase(name, '-');
    return name;
});

/// TILTH_WRITE_SAMPLES=1 writes samples that are not there; never over one that is.
TEST_P(Samples, AreThere) {
    if (const char* write = std::getenv("TILTH_WRITE_SAMPLES");
        write != nullptr && !std::filesystem::exists(folder())) {
        auto world = test::open_script_world(world_of(GetParam()), folder(),
                                             {.flush = {.when = FlushPolicy::When::Manual}, .heights = "a sample"});
        ASSERT_TRUE(world) << world.error().message;
        test::EditScript script(kSeed);
        ASSERT_TRUE(test::advance(**world, script, kSaved));
        ASSERT_TRUE((*world)->save());
        ASSERT_TRUE(test::advance(**world, script, kEdits));
    }
    ASSERT_TRUE(std::filesystem::exists(folder() + "/world.tlw"));
}

TEST_P(Samples, OpenAndAreWhatTheyWere) {
    const Sample& sample = GetParam();
    const test::ScratchFolder scratch;
    const std::string copy = scratch.path("world");
    std::filesystem::copy(folder(), copy);
    auto opened = test::open_script_world(world_of(sample), copy, {.flush = {.when = FlushPolicy::When::Manual}});
    ASSERT_TRUE(opened) << opened.error().message;
    SavedGround& world = **opened;
    for (const Error& error : world.reports()) ADD_FAILURE() << error.message;
    for (const Error& error : world.world().verify()) ADD_FAILURE() << error.message;
    EXPECT_EQ(world.world().identity().heights, "a sample");
    EXPECT_EQ(world.world().committed(), kSaved);
    EXPECT_EQ(world.world().appended(), kEdits);
    EXPECT_EQ(world.ground().hash(), sample.hash)
        << hex16(world.ground().hash().coarse) << " " << hex16(world.ground().hash().detail);

    test::ReferenceWorld reference(world_of(sample), kSeed);
    ASSERT_TRUE(reference.advance_to(kEdits));
    EXPECT_EQ(world.ground().hash(), reference.hash());
    ASSERT_EQ(world.history().undoable(), reference.history().undoable());
    while (world.history().undoable() > 0) {
        ASSERT_TRUE(world.undo());
        ASSERT_TRUE(reference.undo());
        ASSERT_EQ(world.ground().hash(), reference.hash());
    }
    ASSERT_TRUE(world.save());
}

}  // namespace
}  // namespace tilth
