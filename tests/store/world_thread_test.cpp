// A world is stamped on one thread while another commits and compacts: nothing is lost, nothing races.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "store/edit_script.h"
#include "support/fault_files.h"

namespace tilth {
namespace {

TEST(WorldThreads, StampsWhileASnapshotIsWritten) {
    test::FaultFiles disk;
    const test::ScriptWorld made{.undo_bytes = 2u << 20};
    const WorldOptions options{.flush = {.when = FlushPolicy::When::Every, .interval_ms = 0.2},
                               .files = &disk,
                               .log = {.most_waste = 0.2, .least_waste_bytes = 8192}};
    std::uint64_t edits = 0;
    {
        auto opened = test::open_script_world(made, "world", options);
        ASSERT_TRUE(opened) << opened.error().message;
        SavedGround& world = **opened;
        test::EditScript script(31);
        for (int round = 0; round < 8; ++round) {
            const Snapshot snapshot = world.snapshot();
            Result<void> outcome;
            std::atomic<bool> is_done = false;
            std::thread writer([&] {
                outcome = world.commit(snapshot);
                for (bool more = outcome.ok(); more;) {
                    const auto step = world.world().compact(16u << 10);
                    if (!step) outcome = step.error();
                    more = step && *step;
                }
                for (const Error& error : world.world().verify()) outcome = error;
                is_done = true;
            });
            do {
                EXPECT_TRUE(test::advance(world, script, world.world().appended() + 5));
                EXPECT_TRUE(world.world().take_errors().empty());
                EXPECT_LE(world.world().committed(), world.world().appended());
                EXPECT_GT(world.world().size().page_bytes, 0u);
            } while (!is_done);
            writer.join();
            ASSERT_TRUE(outcome) << outcome.error().message;
            world.finish(snapshot, outcome);
        }
        ASSERT_TRUE(world.flush());
        edits = world.world().appended();
    }
    test::ReferenceWorld reference(made, 31);
    ASSERT_TRUE(reference.advance_to(edits));
    const auto again = test::open_script_world(made, "world", options);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ((*again)->world().appended(), edits);
    EXPECT_EQ((*again)->ground().hash(), reference.hash());
}

}  // namespace
}  // namespace tilth
