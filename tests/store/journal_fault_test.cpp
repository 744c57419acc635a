// The journal on a disk that fills up, fails and loses power at every operation in turn.
#include <gtest/gtest.h>

#include <algorithm>

#include "store/journal_support.h"

namespace tilth {
namespace {

using test::Fault;
using test::FaultFiles;
using test::kEach;
using test::kManual;
using test::OpenJournal;
using test::path_of;

using DiskPtr = std::unique_ptr<FaultFiles>;

constexpr std::uint64_t kEdits = 60;

/// What a run promised: everything up to `durable`, of what was appended.
struct Promise {
    std::uint64_t durable = 0, appended = 0;
    std::uint64_t released = 0;  ///< edits up to here may be gone
};

/// Two lives of a journal with batches of all sizes and files that come and go. Errors end a batch, not the run.
Promise live(FaultFiles& disk, const std::vector<Edit>& edits, const FlushPolicy& policy) {
    Promise promise;
    for (int life = 0; life < 2; ++life) {
        Result<OpenJournal> open = test::try_open(disk, promise.released, policy);
        if (!open) return promise;
        Journal& journal = *open->journal;
        promise.durable = std::max(promise.durable, journal.durable());
        promise.appended = std::max(promise.appended, journal.appended());
        for (std::uint64_t batch = 1; journal.appended() < kEdits / 2 * (life + 1u); ++batch) {
            for (std::uint64_t i = 0; i < batch * batch; ++i) journal.append(edits[journal.appended()]);
            promise.appended = std::max(promise.appended, journal.appended());
            (void)journal.flush();
            promise.durable = std::max(promise.durable, journal.durable());
            if (batch != 3) continue;
            promise.released = journal.durable() - std::min<std::uint64_t>(journal.durable(), 4);
            (void)journal.release(promise.released, 0);
        }
        journal.abandon();
    }
    return promise;
}

std::uint64_t operations_of_a_life(const std::vector<Edit>& edits, const FlushPolicy& policy) {
    const DiskPtr disk = test::new_disk();
    const std::uint64_t before = disk->counts().operations;
    live(*disk, edits, policy);
    return disk->counts().operations - before;
}

class JournalFaults : public testing::TestWithParam<FlushPolicy::When> {
protected:
    const FlushPolicy policy_{.when = GetParam()};
    const std::vector<Edit> edits_ = test::random_edits(4 * kEdits);
};

// P1: the power goes during every operation, and the disk keeps what it likes of what was not synced.
TEST_P(JournalFaults, PowerCutsLoseNothingThatWasFlushed) {
    const std::uint64_t operations = operations_of_a_life(edits_, policy_);
    ASSERT_GT(operations, 20u);
    std::uint64_t kept_more = 0, damage = 0;
    for (std::uint64_t operation = 1; operation <= operations + 1; ++operation)
        for (std::uint64_t seed = 0; seed < 30; ++seed) {
            SCOPED_TRACE(testing::Message() << "power cut at " << operation << ", seed " << seed);
            const DiskPtr disk = test::new_disk();
            disk->fail_at(operation, Fault::PowerOff, seed);
            const Promise promise = live(*disk, edits_, policy_);
            const DiskPtr after = disk->crash(seed);
            std::uint64_t last = 0;
            {
                const OpenJournal open = test::open_journal(*after, promise.released);
                ASSERT_NE(open.journal, nullptr);
                last = open.journal->appended();
                ASSERT_GE(last, promise.durable);
                ASSERT_LE(last, promise.appended);
                ASSERT_EQ(open.tail.size(), last - promise.released);
                test::expect_edits(open.tail, edits_, promise.released + 1);
                kept_more += last > promise.durable;
                damage += open.report.damage.size();
                test::append(*open.journal, edits_, last + 1, last + 3);
            }
            const DiskPtr again = after->crash(seed + 1);  // at once: what opening did and promised is durable
            const OpenJournal open = test::open_journal(*again, promise.released);
            ASSERT_EQ(open.journal->appended(), last + 3);
            test::expect_edits(open.tail, edits_, promise.released + 1);
            ASSERT_TRUE(open.report.damage.empty());
            ASSERT_EQ(open.report.truncated_bytes, 0u);
            if (HasFatalFailure()) return;
        }
    EXPECT_GT(kept_more, 0u);  // the fake does keep some of what was not synced
    // A batch of many sectors can lose an early one and keep a later one; a single entry lies in one sector.
    if (GetParam() == FlushPolicy::When::Each) {
        EXPECT_EQ(damage, 0u);
    }
}

// P2: the disk is full from every operation on, until there is room.
TEST_P(JournalFaults, AFullDiskKeepsEditsInMemory) {
    const auto run = [&](FaultFiles& disk, bool& reported) {
        Result<OpenJournal> open = test::try_open(disk, 0, policy_);
        ASSERT_TRUE(open.ok());
        Journal& journal = *open->journal;
        std::size_t errors = 0, failures = 0;
        for (std::uint64_t number = 1; number <= kEdits; ++number) {
            ASSERT_EQ(journal.append(edits_[number - 1]), number);
            if (policy_.when == FlushPolicy::When::Manual && (number % 7 == 0 || number == kEdits)) {
                const Result<void> flushed = journal.flush();
                if (!flushed) {
                    EXPECT_EQ(flushed.error().code, ErrorCode::FileWrite);
                }
                failures += flushed.ok() ? 0 : 1;
            }
            const std::vector<Error> taken = journal.take_errors();
            errors += taken.size();
            const Result<std::vector<Edit>> read = journal.read(1, number);
            ASSERT_TRUE(read.ok()) << read.error().message;
            test::expect_edits(*read, edits_, 1);
        }
        reported = errors + failures > 0;
        EXPECT_LE(errors, 1u);  // and not for every edit
        if (policy_.when == FlushPolicy::When::Manual) {
            EXPECT_EQ(errors, 0u);
        }
        EXPECT_EQ(journal.appended(), kEdits);
        disk.make_room();
        ASSERT_TRUE(journal.flush().ok());
        EXPECT_EQ(journal.durable(), kEdits);
        EXPECT_TRUE(journal.take_errors().empty());
    };
    bool reported = false;
    const DiskPtr reference = test::new_disk();
    const std::uint64_t before = reference->counts().operations;
    run(*reference, reported);
    EXPECT_FALSE(reported);
    const std::uint64_t operations = reference->counts().operations - before;
    for (const Fault fault : {Fault::NoSpace, Fault::Once})
        for (std::uint64_t operation = 2; operation <= operations; ++operation) {  // 1: of opening
            SCOPED_TRACE(testing::Message() << "fault at " << operation);
            const DiskPtr disk = test::new_disk();
            disk->fail_at(operation, fault, operation);
            run(*disk, reported);
            if (HasFatalFailure()) return;
            EXPECT_TRUE(reported);
            EXPECT_EQ(disk->paths(), reference->paths());
            EXPECT_EQ(disk->bytes(path_of(1)), reference->bytes(path_of(1)));
            // And it is on the disk, also what a failed sync had left in doubt.
            for (std::uint64_t seed = 0; seed < 6; ++seed) {
                const DiskPtr after = disk->crash(seed);
                const OpenJournal open = test::open_journal(*after);
                ASSERT_EQ(open.tail.size(), kEdits) << seed;
                test::expect_edits(open.tail, edits_, 1);
            }
        }
}

// The same with files that come and go, opening and releasing included.
TEST_P(JournalFaults, EveryOperationCanFailOnce) {
    const std::uint64_t operations = operations_of_a_life(edits_, policy_);
    for (const Fault fault : {Fault::NoSpace, Fault::Once})
        for (std::uint64_t operation = 1; operation <= operations; ++operation) {
            SCOPED_TRACE(testing::Message() << "fault at " << operation);
            const DiskPtr disk = test::new_disk();
            disk->fail_at(operation, fault, operation);
            const Promise promise = live(*disk, edits_, policy_);
            disk->make_room();
            std::uint64_t last = 0;
            {
                const OpenJournal open = test::open_journal(*disk, promise.released);
                ASSERT_NE(open.journal, nullptr);
                last = open.journal->durable();
                ASSERT_GE(last, promise.durable);
                ASSERT_LE(last, promise.appended);
                test::expect_edits(open.tail, edits_, promise.released + 1);
                EXPECT_TRUE(open.report.damage.empty());
                open.journal->abandon();
            }
            // What opening handed out is durable, though the process before may have failed to sync it.
            for (std::uint64_t seed = 0; seed < 8; ++seed) {
                const DiskPtr after = disk->crash(seed);
                const OpenJournal open = test::open_journal(*after, promise.released);
                ASSERT_GE(open.journal->durable(), last) << seed;
                test::expect_edits(open.tail, edits_, promise.released + 1);
            }
            if (HasFatalFailure()) return;
        }
}

INSTANTIATE_TEST_SUITE_P(Policies, JournalFaults, testing::Values(FlushPolicy::When::Each, FlushPolicy::When::Manual),
                         [](const auto& when) { return when.param == FlushPolicy::When::Each ? "Each" : "Manual"; });

// Repairing damage on a disk that is full, or loses power meanwhile: the next opening finds the same.
TEST(JournalFault, RepairsCanFailAtEveryOperation) {
    const std::vector<Edit> edits = test::random_edits(60);
    for (const Fault fault : {Fault::NoSpace, Fault::PowerOff})
        for (std::uint64_t operation = 1; operation < 40; ++operation)
            for (std::uint64_t seed = 0; seed < 12; ++seed) {
                SCOPED_TRACE(testing::Message() << "fault at " << operation << ", seed " << seed);
                const DiskPtr disk = test::new_disk();
                {
                    const OpenJournal open = test::open_journal(*disk);
                    for (const std::uint64_t first : {1, 20, 40}) {
                        test::append(*open.journal, edits, first, first + 19 - (first == 1));
                        ASSERT_TRUE(open.journal->release(0, 0).ok());
                    }
                }
                disk->flip_bit(path_of(20), offset_of_entry(20, 30) * 8);
                disk->fail_at(operation, fault, seed);
                (void)test::try_open(*disk);
                const bool struck = disk->failed();
                disk->make_room();
                const DiskPtr after = disk->crash(seed);
                const OpenJournal open = test::open_journal(*after);
                ASSERT_EQ(open.tail.size(), 29u);
                test::expect_edits(open.tail, edits, 1);
                // Every edit behind the damage still lies in some file.
                std::vector<bool> found(edits.size() + 1);
                for (const std::string& path : after->paths()) {
                    const std::string name = path.substr(6, std::string("journal-00000000000000000000.tlj").size());
                    const std::uint64_t first = number_of_segment(name).value_or(1);
                    const std::vector<std::byte> bytes = after->bytes(path);
                    for (std::uint64_t n = first; n <= 59 && offset_of_entry(first, n) + 64 <= bytes.size(); ++n) {
                        const auto entry = std::span(bytes).subspan(offset_of_entry(first, n)).first<64>();
                        if (decode_entry(entry, n, test::kSalt)) found[n] = true;
                    }
                }
                for (std::uint64_t n = 1; n <= 59; ++n) ASSERT_EQ(found[n], n != 30) << n;
                if (!struck && fault == Fault::NoSpace) return;  // beyond the last operation
            }
}

}  // namespace
}  // namespace tilth
