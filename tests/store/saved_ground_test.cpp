// A ground on disk is, after whatever happened, the ground that was dented.
#include "tilth/store/saved_ground.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "io/scratch_folder.h"
#include "store/edit_script.h"
#include "support/fault_files.h"

namespace tilth {
namespace {

using test::EditScript;
using test::FaultFiles;
using test::joined;
using test::ReferenceWorld;
using test::ScratchFolder;
using test::ScriptWorld;

constexpr FlushPolicy kManual{.when = FlushPolicy::When::Manual};

/// A script's world and its reference, opened and closed together.
class BothWorlds {
public:
    BothWorlds(const ScriptWorld& made, std::uint64_t seed, std::string folder, WorldOptions options)
        : made_(made), seed_(seed), folder_(std::move(folder)), options_(std::move(options)), reference_(made, seed) {
        open();
    }
    void open() {
        world_.reset();
        auto opened = test::open_script_world(made_, folder_, options_);
        ASSERT_TRUE(opened) << opened.error().message;
        world_ = std::move(*opened);
        script_ = EditScript(seed_);
        EXPECT_EQ(joined(world_->reports()), "");
        ASSERT_LE(reference_.edits(), world_->world().appended());
        ASSERT_TRUE(reference_.advance_to(world_->world().appended()));
        reference_.begin_run();
        expect_same();
    }
    void advance_to(std::uint64_t edits) { ASSERT_TRUE(test::advance(*world_, script_, edits)); }
    void expect_same() {
        ASSERT_TRUE(reference_.advance_to(world_->world().appended()));
        EXPECT_EQ(world_->ground().hash(), reference_.hash()) << "after " << reference_.edits() << " edits";
        EXPECT_EQ(world_->history().undoable(), reference_.history().undoable());
        EXPECT_EQ(world_->history().redoable(), reference_.history().redoable());
    }
    SavedGround& world() { return *world_; }
    ReferenceWorld& reference() { return reference_; }
    void close() { world_.reset(); }

private:
    ScriptWorld made_;
    std::uint64_t seed_;
    std::string folder_;
    WorldOptions options_;
    std::unique_ptr<SavedGround> world_;
    ReferenceWorld reference_;
    EditScript script_{0};
};

class SavedGroundOf : public testing::TestWithParam<HeightPrecision> {
protected:
    [[nodiscard]] static ScriptWorld made() { return {.precision = GetParam()}; }
};
INSTANTIATE_TEST_SUITE_P(Precisions, SavedGroundOf, testing::Values(HeightPrecision::bits32, HeightPrecision::bits16),
                         [](const auto& of) { return of.param == HeightPrecision::bits32 ? "bits32" : "bits16"; });

TEST_P(SavedGroundOf, IsTheSameAfterSavesAndWithout) {
    const ScratchFolder folder;
    BothWorlds both(made(), 1, folder.path("world"), {.flush = kManual});
    both.advance_to(40);
    both.open();  // from the journal alone
    both.advance_to(75);
    ASSERT_TRUE(both.world().save());
    both.expect_same();
    both.open();  // from the pages alone
    EXPECT_EQ(both.world().world().committed(), 75u);
    both.advance_to(110);
    both.open();  // from both
    for (int i = 0; i < 4; ++i) {
        both.advance_to(both.world().world().appended() + 23);
        ASSERT_TRUE(both.world().save());
    }
    both.open();
    EXPECT_EQ(joined(both.world().world().verify()), "");
}

TEST_P(SavedGroundOf, IsUndoneToTheFirstStrokeAfterItWasOpened) {
    const ScratchFolder folder;
    BothWorlds both(made(), 2, folder.path("world"), {.flush = kManual});
    const StateHash untouched = both.world().ground().hash();
    both.advance_to(60);
    ASSERT_TRUE(both.world().save());
    both.open();
    const std::size_t strokes = both.world().history().undoable();
    const StateHash dented = both.world().ground().hash();
    ASSERT_GT(strokes, 20u);
    for (std::size_t i = 0; i < strokes; ++i) ASSERT_TRUE(both.world().undo());
    EXPECT_FALSE(both.world().undo());
    EXPECT_EQ(both.world().ground().hash(), untouched);
    for (std::size_t i = 0; i < strokes; ++i) ASSERT_TRUE(both.world().redo());
    EXPECT_EQ(both.world().ground().hash(), dented);
    ASSERT_TRUE(both.world().save());
}

TEST(SavedGround, OfAWorldThatWasTakenBackHasNoPages) {
    const ScratchFolder folder;
    const ScriptWorld made;
    auto world = test::open_script_world(made, folder.path("world"), {.flush = kManual});
    ASSERT_TRUE(world);
    EditScript script(3);
    ASSERT_TRUE(test::advance(**world, script, 30));
    ASSERT_TRUE((*world)->save());
    EXPECT_FALSE((*world)->world().tiles()->empty());
    while ((*world)->history().undoable() > 0) ASSERT_TRUE((*world)->undo());
    ASSERT_TRUE((*world)->save());
    EXPECT_TRUE((*world)->world().tiles()->empty());
}

TEST(SavedGround, LosesWhatWasNotFlushedAndNothingElse) {
    const ScratchFolder folder;
    BothWorlds both({}, 4, folder.path("world"), {.flush = kManual});
    both.advance_to(20);
    ASSERT_TRUE(both.world().flush());
    ASSERT_TRUE(both.world().save());
    both.advance_to(33);
    ASSERT_TRUE(both.world().flush());
    EXPECT_EQ(both.world().world().durable(), 33u);
    auto snapshot = both.world().snapshot();  // one that is never written
    ASSERT_TRUE(test::advance(both.world(), *std::make_unique<EditScript>(99), 40));
    both.world().world().abandon();
    both.open();
    EXPECT_EQ(both.world().world().appended(), 33u);
}

TEST(SavedGround, KeepsShapesWhicheverIsUsedFirst) {
    const ScratchFolder folder;
    const ScriptWorld made;
    StateHash dented;
    {
        auto world = SavedGround::open(made.ground(), folder.path("world"), {}, 0);
        ASSERT_TRUE(world);
        const std::vector<std::uint16_t> weights{0, 65535, 30000, 0};
        for (const char* name : {"first", "second", "third"})
            ASSERT_TRUE((*world)->shapes().add_image(name, 2, 2, weights));
        for (const char* name : {"third", "first"})
            ASSERT_TRUE((*world)->stamp(
                {.shape = *(*world)->shapes().find(name), .centre = {50, 60}, .radius_m = 3, .amplitude_m = 0.5}));
        dented = (*world)->ground().hash();
    }
    auto again = SavedGround::open(made.ground(), folder.path("world"), {}, 0);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ((*again)->ground().hash(), dented);
    EXPECT_EQ((*again)->shapes().find("third")->value, kBuiltinProfiles + 2);
}

TEST(SavedGround, IsLockedWhileItIsOpen) {
    const ScratchFolder folder;
    const ScriptWorld made;
    auto first = SavedGround::open(made.ground(), folder.path("world"), {}, 0);
    ASSERT_TRUE(first);
    auto second = SavedGround::open(made.ground(), folder.path("world"), {}, 0);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::Locked);
    EXPECT_NE(second.error().message.find("lock"), std::string::npos) << second.error().message;
    first = Error{};
    EXPECT_TRUE(SavedGround::open(made.ground(), folder.path("world"), {}, 0));
}

TEST(SavedGround, LiesInFoldersWithAnyName) {
    const ScratchFolder folder;
    BothWorlds both({}, 5, folder.path("mir \xd0\xbc\xd0\xb8\xd1\x80 \xe5\x9c\xb0 'x'"), {.flush = kManual});
    both.advance_to(10);
    ASSERT_TRUE(both.world().save());
    both.advance_to(12);
    both.open();
}

TEST(SavedGround, WantsTheParentOfItsFolder) {
    const ScratchFolder folder;
    const auto opened = SavedGround::open(ScriptWorld{}.ground(), folder.path("not there/world"), {}, 0);
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().message.find("not there"), std::string::npos) << opened.error().message;
    EXPECT_FALSE(std::filesystem::exists(folder.path("not there")));
}

TEST(SavedGround, OpensOnItsOwnHeightsAlone) {
    const ScratchFolder folder;
    const ScriptWorld made, other{.heights = "hill:size=129,peak=12,sigma=31"},
        coarser{.precision = HeightPrecision::bits16};
    ASSERT_TRUE(SavedGround::open(made.ground(), folder.path("world"), {}, 0));
    const auto on_other = SavedGround::open(other.ground(), folder.path("world"), {}, 0);
    ASSERT_FALSE(on_other);
    EXPECT_EQ(on_other.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(on_other.error().message.find("heights"), std::string::npos) << on_other.error().message;
    const auto on_coarser = SavedGround::open(coarser.ground(), folder.path("world"), {}, 0);
    ASSERT_FALSE(on_coarser);
    EXPECT_NE(on_coarser.error().message.find("precision"), std::string::npos) << on_coarser.error().message;
}

TEST(SavedGround, IsNotMadeOverTheRestsOfAnother) {
    const ScratchFolder folder;
    const ScriptWorld made;
    { ASSERT_TRUE(SavedGround::open(made.ground(), folder.path("world"), {}, 0)); }
    ASSERT_TRUE(std::filesystem::remove(folder.path("world/world.tlw")));
    const auto opened = SavedGround::open(made.ground(), folder.path("world"), {}, 0);
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().message.find("world.tlw"), std::string::npos) << opened.error().message;
}

TEST(SavedGround, StaysInItsFolderWhenSnapshotsFail) {
    FaultFiles disk;
    BothWorlds both({}, 6, "world", {.flush = kManual, .files = &disk});
    both.advance_to(20);
    disk.fail_at(1, test::Fault::NoSpace);
    EXPECT_FALSE(both.world().save());
    both.advance_to(50);
    EXPECT_FALSE(both.world().save());
    disk.make_room();
    ASSERT_TRUE(both.world().save());
    both.open();
    EXPECT_EQ(both.world().world().committed(), 50u);
}

// ---------------------------------------------------------------------------------------------------- a bad disk

/// What the tests of every single operation do: edits, saves, compaction. False: something was refused.
bool live(SavedGround& world, EditScript& script) {
    bool all_well = true;
    const auto do_edits = [&](std::uint64_t count) {
        // A stamp is refused when its shape cannot be kept; nothing has happened then.
        all_well = test::advance(world, script, world.world().appended() + count) && all_well;
        all_well = world.flush().ok() && all_well;
    };
    for (int round = 0; round < 4; ++round) {
        do_edits(5);
        all_well = world.save().ok() && all_well;
        for (int i = 0; i < 3; ++i) all_well = world.world().compact(16u << 10).ok() && all_well;
    }
    do_edits(2);
    return all_well;
}

WorldOptions on_disk(FaultFiles& disk) {
    return {.flush = kManual, .files = &disk, .log = {.most_waste = 0.2, .least_waste_bytes = 4096}};
}

std::uint64_t operations_of_a_life(const ScriptWorld& made) {
    FaultFiles disk;
    auto world = test::open_script_world(made, "world", on_disk(disk));
    EXPECT_TRUE(world);
    EditScript script(7);
    EXPECT_TRUE(live(**world, script));
    EXPECT_FALSE(disk.exists("world/pages-1.tlp")) << "it was compacted";
    return disk.counts().operations;
}

TEST(SavedGround, KeepsEverythingWhenTheDiskFillsUpAtAnyOperation) {
    const ScriptWorld made;
    const std::uint64_t operations = operations_of_a_life(made);
    ASSERT_GT(operations, 30u);
    std::uint64_t refused = 0;
    for (std::uint64_t k = 1; k <= operations; ++k) {
        SCOPED_TRACE(testing::Message() << "full at operation " << k << " of " << operations);
        FaultFiles disk;
        disk.fail_at(k, test::Fault::NoSpace, k);
        auto world = test::open_script_world(made, "world", on_disk(disk));
        if (!world) {
            EXPECT_EQ(world.error().code, ErrorCode::FileWrite) << world.error().message;
            ++refused;
            disk.make_room();
            world = test::open_script_world(made, "world", on_disk(disk));
        }
        ASSERT_TRUE(world) << world.error().message;
        EditScript script(7);
        ReferenceWorld reference(made, 7);
        const bool all_well = live(**world, script);
        if (disk.failed() && disk.counts().operations > k) {
            EXPECT_TRUE(!all_well || refused > 0);
        }
        ASSERT_TRUE(reference.advance_to((*world)->world().appended()));
        EXPECT_EQ((*world)->ground().hash(), reference.hash()) << "in memory";
        disk.make_room();
        ASSERT_TRUE((*world)->save());
        EXPECT_EQ(joined((*world)->world().verify()), "");
        world = Error{};
        auto again = test::open_script_world(made, "world", on_disk(disk));
        ASSERT_TRUE(again) << again.error().message;
        EXPECT_EQ(joined((*again)->reports()), "");
        EXPECT_EQ((*again)->world().appended(), reference.edits());
        EXPECT_EQ((*again)->ground().hash(), reference.hash()) << "opened again";
        if (HasFailure()) return;
    }
    EXPECT_GT(refused, 0u);
}

TEST(SavedGround, IsAsOfTheLastFlushWhenThePowerGoesAtAnyOperation) {
    const ScriptWorld made;
    const std::uint64_t operations = operations_of_a_life(made);
    for (std::uint64_t k = 1; k <= operations; ++k) {
        FaultFiles disk;
        disk.fail_at(k, test::Fault::PowerOff, k);
        std::uint64_t durable = 0;
        if (auto world = test::open_script_world(made, "world", on_disk(disk))) {
            EditScript script(7);
            live(**world, script);
            durable = (*world)->world().durable();
            (*world)->world().abandon();
        }
        for (std::uint64_t seed = 1; seed <= 2; ++seed) {
            SCOPED_TRACE(testing::Message()
                         << "power off at operation " << k << " of " << operations << ", seed " << seed);
            const std::unique_ptr<FaultFiles> after = disk.crash(k * 1000 + seed);
            ReferenceWorld reference(made, 7);
            for (int opening = 0; opening < 2; ++opening) {  // what opening repairs, it repairs for good
                auto world = test::open_script_world(made, "world", on_disk(*after));
                ASSERT_TRUE(world) << world.error().message;
                // Sectors of one write that was never synced can come to the disk in any order; then it cannot be told
                // from damage, and what lies behind the gap is kept aside. Once.
                for (const Error& error : (*world)->reports())
                    EXPECT_TRUE(opening == 0 && error.message.find("moved aside") != std::string::npos)
                        << error.message;
                EXPECT_GE((*world)->world().appended(), durable);
                EXPECT_EQ(joined((*world)->world().verify()), "");
                ASSERT_TRUE(reference.advance_to((*world)->world().appended()));
                EXPECT_EQ((*world)->ground().hash(), reference.hash());
                EXPECT_EQ((*world)->history().undoable(), reference.history().undoable());
            }
        }
        if (HasFailure()) return;
    }
}

}  // namespace
}  // namespace tilth
