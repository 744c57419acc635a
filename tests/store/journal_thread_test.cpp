// The journal's own thread and several callers at once. TSan sees the locks; the test sees order and durability.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <thread>

#include "store/journal_support.h"

namespace tilth {
namespace {

using test::FaultFiles;
using test::OpenJournal;

constexpr FlushPolicy kEvery{.when = FlushPolicy::When::Every, .interval_ms = 0.1};

TEST(JournalThread, ManyCallersOneOrder) {
    constexpr std::uint64_t kEdits = 4000;
    const std::vector<Edit> edits = test::random_edits(kEdits);
    for (const FlushPolicy::When when :
         {FlushPolicy::When::Every, FlushPolicy::When::Each, FlushPolicy::When::Manual}) {
        const std::unique_ptr<FaultFiles> disk = test::new_disk();
        {
            const OpenJournal open = test::open_journal(*disk, 0, {.when = when, .interval_ms = 0.1});
            Journal& journal = *open.journal;
            std::atomic<bool> done = false;
            std::thread flusher([&] {
                while (!done) EXPECT_TRUE(journal.flush().ok());
            });
            std::thread reader([&] {
                std::uint64_t before = 0;
                while (!done) {
                    const std::uint64_t durable = journal.durable(), appended = journal.appended();
                    EXPECT_LE(durable, appended);
                    EXPECT_LE(before, durable);
                    before = durable;
                    EXPECT_TRUE(journal.take_errors().empty());
                    EXPECT_EQ(journal.first(), 1u);
                    if (appended == 0) continue;
                    const std::uint64_t first = appended > 50 ? appended - 50 : 1;
                    const Result<std::vector<Edit>> read = journal.read(first, appended);
                    ASSERT_TRUE(read.ok()) << read.error().message;
                    ASSERT_EQ(read->size(), appended - first + 1);
                    test::expect_edits(*read, edits, first);
                    EXPECT_LE(journal.disk_bytes(), (64 + 64) * kEdits);
                }
            });
            std::thread releaser([&] {
                while (!done) EXPECT_TRUE(journal.release(0, 0).ok());  // many files; nothing goes
            });
            for (std::uint64_t number = 1; number <= kEdits; ++number)
                ASSERT_EQ(journal.append(edits[number - 1]), number);
            done = true;
            flusher.join();
            reader.join();
            releaser.join();
        }
        const std::unique_ptr<FaultFiles> after = disk->crash(3);
        const OpenJournal open = test::open_journal(*after);
        ASSERT_EQ(open.tail.size(), kEdits);
        test::expect_edits(open.tail, edits, 1);
    }
}

TEST(JournalThread, ItFlushesByItself) {
    const std::vector<Edit> edits = test::random_edits(10);
    const std::unique_ptr<FaultFiles> disk = test::new_disk();
    const OpenJournal open = test::open_journal(*disk, 0, kEvery);
    for (std::uint64_t number = 1; number <= 10; ++number) {
        open.journal->append(edits[number - 1]);
        while (open.journal->durable() < number) std::this_thread::yield();
        const std::unique_ptr<FaultFiles> after = disk->crash(number);
        EXPECT_EQ(test::open_journal(*after).tail.size(), number);
    }
}

// With an hour between flushes: it sleeps through edits, and wakes to end.
TEST(JournalThread, ItDoesNothingBeforeItsTimeAndEndsAtOnce) {
    const std::vector<Edit> edits = test::random_edits(10);
    const std::unique_ptr<FaultFiles> disk = test::new_disk();
    {
        const OpenJournal open =
            test::open_journal(*disk, 0, {.when = FlushPolicy::When::Every, .interval_ms = 60'000});
        for (const Edit& edit : edits) open.journal->append(edit);
        EXPECT_EQ(open.journal->durable(), 0u);
    }
    const OpenJournal open = test::open_journal(*disk);
    EXPECT_EQ(open.tail.size(), 10u);  // the end flushed
}

TEST(JournalThread, TroubleIsReportedOnceUntilItWentWell) {
    const std::vector<Edit> edits = test::random_edits(2000);
    const std::unique_ptr<FaultFiles> disk = test::new_disk();
    const OpenJournal open = test::open_journal(*disk, 0, kEvery);
    Journal& journal = *open.journal;
    std::uint64_t number = 0;
    for (int round = 0; round < 2; ++round) {
        disk->fail_at(1, test::Fault::NoSpace);
        journal.append(edits[number++]);
        std::vector<Error> errors;
        while (errors.empty()) {
            errors = journal.take_errors();
            std::this_thread::yield();
        }
        EXPECT_EQ(errors.size(), 1u);
        EXPECT_EQ(errors[0].code, ErrorCode::FileWrite);
        for (int i = 0; i < 500; ++i) journal.append(edits[number++]);
        EXPECT_FALSE(journal.flush().ok());
        EXPECT_FALSE(journal.flush().ok());
        EXPECT_TRUE(journal.take_errors().empty());
        disk->make_room();
        while (journal.durable() < number) std::this_thread::yield();  // by itself, when it tries again
        EXPECT_TRUE(journal.take_errors().empty());
    }
    const std::unique_ptr<FaultFiles> after = disk->crash(1);
    const OpenJournal again = test::open_journal(*after);
    ASSERT_EQ(again.tail.size(), number);
    test::expect_edits(again.tail, edits, 1);
}

TEST(JournalThread, AbandonedWhileOthersCall) {
    const std::vector<Edit> edits = test::random_edits(5000);
    for (int round = 0; round < 20; ++round) {
        const std::unique_ptr<FaultFiles> disk = test::new_disk();
        std::uint64_t durable = 0;
        {
            const OpenJournal open = test::open_journal(*disk, 0, kEvery);
            Journal& journal = *open.journal;
            std::promise<void> begun;
            std::thread other([&] {
                begun.get_future().wait();
                journal.abandon();
            });
            for (std::uint64_t number = 1; number <= 500; ++number) {
                journal.append(edits[number - 1]);
                if (number == 200) begun.set_value();
                if (number % 50 == 0) (void)journal.flush();
            }
            other.join();
            durable = journal.durable();
            EXPECT_GE(durable, 200u - 50);
        }
        const OpenJournal open = test::open_journal(*disk);
        EXPECT_EQ(open.tail.size(), durable);
        test::expect_edits(open.tail, edits, 1);
    }
}

}  // namespace
}  // namespace tilth
