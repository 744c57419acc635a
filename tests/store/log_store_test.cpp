// The log store against a map that cannot fail: with work, crashes, full disks and compaction in any order.
#include "tilth/store/log_store.h"

#include <gtest/gtest.h>

#include "io/scratch_folder.h"
#include "store/log_store_support.h"

namespace tilth::test {
namespace {

const std::string kFirstFile = std::string(kFolder) + "/pages-1.tlp";

TEST(LogStore, HoldsWhatAMapHolds) {
    int compactions = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        FaultFiles disk;
        Worker worker(disk, seed, {.keys = 40, .most_bytes = 3000});
        for (int i = 0; i < 400 && !testing::Test::HasFailure(); ++i) {
            ASSERT_TRUE(worker.step()) << "seed " << seed << ", step " << i;
            if (i % 10 == 0) worker.expect_visible();
        }
        compactions += worker.compactions();
    }
    EXPECT_GT(compactions, 5);
}

TEST(LogStore, KeysOfAKindAreSortedAndReadNoBlob) {
    FaultFiles disk;
    ASSERT_TRUE(disk.make_folder(kFolder).ok());
    LogStoreReport report;
    auto store = open_store(disk, report);
    ASSERT_TRUE(store.ok());
    const std::vector<BlobKey> keys{{BlobKind::DetailPage, INT32_MIN, INT32_MAX},
                                    {BlobKind::DetailPage, -1, 5},
                                    {BlobKind::DetailPage, 0, INT32_MIN},
                                    {BlobKind::DetailPage, 0, 0},
                                    {BlobKind::DetailPage, INT32_MAX, INT32_MIN}};
    for (auto key = keys.rbegin(); key != keys.rend(); ++key) ASSERT_TRUE((*store)->put(*key, Bytes(100)).ok());
    ASSERT_TRUE((*store)->put({BlobKind::CoarsePage, 0, 0}, Bytes(1)).ok());
    ASSERT_TRUE((*store)->commit(1).ok());
    const std::uint64_t reads = disk.counts().reads;
    EXPECT_EQ(*(*store)->keys(BlobKind::DetailPage), keys);
    EXPECT_EQ((*(*store)->keys(BlobKind::CoarsePage)).size(), 1u);
    EXPECT_TRUE((*(*store)->keys(BlobKind::Stroke)).empty());
    EXPECT_EQ(disk.counts().reads, reads);
    EXPECT_FALSE((*(*store)->get({BlobKind::Stroke, 0, 0})).has_value());
    EXPECT_TRUE((*store)->erase({BlobKind::Stroke, 0, 0}).ok()) << "erasing what is not there is no error";
}

// The first and the last moment of every operation that touches the disk, and the middle of it.
TEST(LogStore, PowerCutAtEveryOperationLeavesTheLastCommitOrTheOneAtHand) {
    std::uint64_t cuts = 0;
    int compactions = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
        for (std::uint64_t operation = 1;; ++operation) {
            FaultFiles disk;
            Worker worker(disk, seed, {});
            disk.fail_at(operation, Fault::PowerOff, operation);
            for (int i = 0; i < 150 && worker.step() && !disk.failed(); ++i) {
            }
            if (!disk.failed()) break;
            compactions += worker.compactions();
            for (std::uint64_t crash = 0; crash < 8; ++crash) worker.expect_after_crash(operation * 8 + crash);
            ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed << ", operation " << operation;
            ++cuts;
        }
    EXPECT_GT(cuts, 500u);
    EXPECT_GT(compactions, 100);
}

TEST(LogStore, PowerCutWithBlobsThatAreWrittenBeforeTheCommit) {
    std::uint64_t cuts = 0;
    int truncations = 0;
    for (std::uint64_t operation = 1;; ++operation) {
        FaultFiles disk;
        Worker worker(disk, 3, {.keys = 6, .most_bytes = 700'000});
        disk.fail_at(operation, Fault::PowerOff, operation);
        for (int i = 0; i < 30 && worker.step() && !disk.failed(); ++i) {
        }
        if (!disk.failed()) break;
        for (std::uint64_t crash = 0; crash < 3; ++crash) worker.expect_after_crash(operation * 3 + crash);
        ASSERT_FALSE(testing::Test::HasFailure()) << "operation " << operation;
        ++cuts;
        truncations += worker.truncations();
    }
    EXPECT_GT(cuts, 20u);
    EXPECT_GT(truncations, 10) << "no crash ever left anything behind the last commit";
}

void expect_survives(Fault fault, std::uint64_t seed, const Worker::Settings& settings, int steps,
                     std::uint64_t& struck) {
    for (std::uint64_t operation = 3;; ++operation) {  // 1 and 2 make the folder
        FaultFiles disk;
        Worker worker(disk, seed, settings);
        disk.fail_at(operation - 2, fault, operation);
        int errors = 0, since = 0;
        for (int i = 0; i < steps; ++i) {
            if (!worker.step()) {
                if (++errors == 1) worker.expect_visible();
                worker.expect_after_crash(operation + static_cast<std::uint64_t>(errors));
            }
            if (disk.failed() && ++since == 12) disk.make_room();  // until then it goes on failing
            ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed << ", operation " << operation;
        }
        if (!disk.failed()) break;
        struck += errors > 0 ? 1 : 0;
        disk.make_room();
        if (!worker.is_open()) {
            ASSERT_TRUE(worker.reopen());
        }
        worker.expect_visible();
        ASSERT_TRUE(worker.put({BlobKind::World, 0, 0}, 100));
        ASSERT_TRUE(worker.commit()) << "seed " << seed << ", operation " << operation;
        worker.expect_visible();
        for (std::uint64_t crash = 0; crash < 4; ++crash) worker.expect_after_crash(operation * 4 + crash);
        ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed << ", operation " << operation;
    }
}

TEST(LogStore, FullDiskAtEveryOperationLosesNothing) {
    std::uint64_t struck = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) expect_survives(Fault::NoSpace, seed, {}, 120, struck);
    EXPECT_GT(struck, 200u);
}

TEST(LogStore, FullDiskWhilePutsAreWritten) {
    std::uint64_t struck = 0;
    expect_survives(Fault::NoSpace, 4, {.keys = 6, .most_bytes = 700'000}, 30, struck);
    EXPECT_GT(struck, 15u);
}

// A sync that failed once: what was written before it must be written again, the next sync would not.
TEST(LogStore, OneFailureAtEveryOperationLosesNothing) {
    std::uint64_t struck = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) expect_survives(Fault::Once, seed, {}, 120, struck);
    EXPECT_GT(struck, 200u);
}

TEST(LogStore, PutThatFailsLeavesTheOldBlob) {
    FaultFiles disk;
    Worker worker(disk, 1, {});
    ASSERT_TRUE(worker.reopen());
    const BlobKey key{BlobKind::DetailPage, 1, 2};
    ASSERT_TRUE(worker.put(key, 1000));
    ASSERT_TRUE(worker.commit());
    const std::uint64_t disk_bytes = worker.store().size().disk_bytes;
    disk.fail_at(1, Fault::NoSpace);
    EXPECT_FALSE(worker.put(key, 2'000'000)) << "larger than what is kept for later";
    EXPECT_EQ(worker.store().size().disk_bytes, disk_bytes) << "nothing of it stays";
    worker.expect_visible();
    EXPECT_EQ(worker.store().mark_of(key), std::optional(worker.last().mark));
    // What waits in memory is bounded: sooner or later puts fail, too.
    int accepted = 0;
    while (accepted < 1000 && worker.put({BlobKind::CoarsePage, accepted, 0}, 10'000)) ++accepted;
    EXPECT_LT(accepted, 150);
    worker.expect_visible();
    EXPECT_FALSE(worker.commit());
    disk.make_room();
    EXPECT_TRUE(worker.put(key, 2'000'000));
    EXPECT_TRUE(worker.commit());
    worker.expect_visible();
    EXPECT_EQ(worker.store().put(key, Bytes((64u << 20) + 1)).error().code, ErrorCode::InvalidArgument);
    worker.expect_visible();
}

TEST(LogStore, OpeningReadsIndexesAlone) {
    FaultFiles disk;
    ASSERT_TRUE(disk.make_folder(kFolder).ok());
    LogStoreReport report;
    auto store = open_store(disk, report, {.most_waste = 1});
    ASSERT_TRUE(store.ok());
    SplitMix64 random{5};
    constexpr std::uint64_t kCommits = 3000, kKeys = 500;
    for (std::uint64_t i = 1; i <= kCommits; ++i) {
        ASSERT_TRUE((*store)->put(random_key(random, kKeys), Bytes(2000)).ok());
        ASSERT_TRUE((*store)->commit(i).ok());
    }
    const std::uint64_t disk_bytes = (*store)->size().disk_bytes;
    // Every commit has one blob of 2 040 bytes. Its index costs by the logarithm: sizes at least double along the
    // chain.
    EXPECT_LT(disk_bytes, kCommits * (2040 + 80 + 32 * 12));
    const FaultFiles::Counts before = disk.counts();
    store = open_store(disk, report);
    ASSERT_TRUE(store.ok());
    EXPECT_LT(disk.counts().reads - before.reads, 3 + 2 * 10u) << "the chain of indexes is as long as a logarithm";
    EXPECT_LT(disk.counts().read_bytes - before.read_bytes, 3 * kKeys * 32);
    EXPECT_EQ((*store)->mark(), kCommits);
}

TEST(LogStore, CompactionGivesSpaceBackAndTakesSteps) {
    FaultFiles disk;
    Worker worker(disk, 1, {.keys = 1, .most_bytes = 1, .store = {.most_waste = 0.5, .least_waste_bytes = 100'000}});
    ASSERT_TRUE(worker.reopen());
    for (int i = 0; i < 200; ++i) ASSERT_TRUE(worker.put({BlobKind::DetailPage, i % 50, 0}, 4000));
    EXPECT_FALSE(*worker.store().compact(10'000)) << "without a commit there is nothing to keep";
    ASSERT_TRUE(worker.commit());
    const std::uint64_t before = worker.store().size().disk_bytes;
    EXPECT_GT(before, 800'000u);
    // Work goes on between the steps.
    int steps = 0;
    for (bool more = true; more; ++steps) {
        const std::uint64_t written = disk.counts().written_bytes;
        const Result<bool> result = worker.store().compact(20'000);
        ASSERT_TRUE(result.ok());
        more = *result;
        EXPECT_LE(disk.counts().written_bytes - written, (1u << 20) + 30'000u);
        if (steps == 2) {
            ASSERT_TRUE(worker.put({BlobKind::DetailPage, 3, 0}, 500));
            ASSERT_TRUE(worker.erase({BlobKind::DetailPage, 4, 0}));
            ASSERT_TRUE(worker.commit());
        }
        if (steps == 4) {  // these are not committed when it ends
            ASSERT_TRUE(worker.put({BlobKind::DetailPage, 5, 0}, 600));
            ASSERT_TRUE(worker.put({BlobKind::Stroke, 5, 0}, 700));
            ASSERT_TRUE(worker.erase({BlobKind::DetailPage, 6, 0}));
        }
        worker.expect_visible();
        ASSERT_LT(steps, 100);
    }
    EXPECT_GT(steps, 8);
    EXPECT_EQ(disk.paths(), std::vector<std::string>{"world/pages-2.tlp"});
    EXPECT_LT(worker.store().size().disk_bytes, 240'000u);
    for (std::uint64_t crash = 0; crash < 10; ++crash) worker.expect_after_crash(crash);
    ASSERT_TRUE(worker.commit());
    worker.expect_visible();
    for (std::uint64_t crash = 0; crash < 10; ++crash) worker.expect_after_crash(crash);
}

TEST(LogStore, CompactionAsAskedForEnds) {
    FaultFiles disk;
    Worker worker(disk, 2, {.keys = 30, .most_bytes = 500, .store = {.most_waste = 0, .least_waste_bytes = 0}});
    for (int i = 0; i < 60; ++i) ASSERT_TRUE(worker.step());
    ASSERT_TRUE(worker.put({BlobKind::World, 0, 0}, 10));  // not committed
    int steps = 0;
    while (*worker.store().compact(1)) ASSERT_LT(++steps, 1000);
    EXPECT_FALSE(*worker.store().compact(1));
    worker.expect_visible();
}

TEST(LogStore, CompactionCanBeForcedWhereLittleIsWasted) {
    FaultFiles disk;
    Worker worker(disk, 1, {.keys = 1, .most_bytes = 1, .store = {}});
    ASSERT_TRUE(worker.reopen());
    constexpr int kBlobs = 200;
    for (int i = 0; i < kBlobs; ++i) ASSERT_TRUE(worker.put({BlobKind::DetailPage, i, 0}, 4000));
    ASSERT_TRUE(worker.commit());
    EXPECT_FALSE(*worker.store().compact(10'000, true)) << "nothing is wasted";
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(worker.put({BlobKind::DetailPage, i, 0}, 4000));
    ASSERT_TRUE(worker.commit());
    EXPECT_FALSE(*worker.store().compact(10'000, true)) << "2 % is not worth a copy of everything";
    for (int i = 0; i < 8; ++i) ASSERT_TRUE(worker.put({BlobKind::DetailPage, i, 0}, 4000));
    ASSERT_TRUE(worker.commit());
    EXPECT_FALSE(*worker.store().compact(10'000)) << "6 % is no reason";
    const std::uint64_t before = worker.store().size().disk_bytes;
    EXPECT_EQ(worker.store().size().temporary_bytes, 0u);
    ASSERT_TRUE(*worker.store().compact(10'000, true));
    for (int steps = 0; *worker.store().compact(50'000); ++steps) {  // once begun it ends, whoever asks
        ASSERT_LT(steps, 100);
        const BlobStore::Size size = worker.store().size();
        EXPECT_EQ(size.disk_bytes - size.temporary_bytes, before);
        EXPECT_GT(size.temporary_bytes, 0u);
    }
    EXPECT_EQ(worker.store().size().temporary_bytes, 0u);
    EXPECT_LT(worker.store().size().disk_bytes, before - 12 * 4000);
    EXPECT_FALSE(*worker.store().compact(10'000, true));
    worker.expect_visible();
    for (std::uint64_t crash = 0; crash < 10; ++crash) worker.expect_after_crash(crash);
}

TEST(LogStore, CompactionKeepsDamagedBlobsDamaged) {
    FaultFiles disk;
    const LogStoreSettings all{.most_waste = 0, .least_waste_bytes = 0};
    ASSERT_TRUE(disk.make_folder(kFolder).ok());
    LogStoreReport report;
    auto store = open_store(disk, report, all);
    ASSERT_TRUE(store.ok());
    const BlobKey bad{BlobKind::DetailPage, 0, 0}, good{BlobKind::DetailPage, 0, 1}, other{BlobKind::DetailPage, 0, 2};
    for (const BlobKey& key : {bad, good, other}) {
        ASSERT_TRUE((*store)->put(key, Bytes(1000, std::byte{7})).ok());
        ASSERT_TRUE((*store)->commit(1 + static_cast<std::uint64_t>(key.z)).ok());
    }
    ASSERT_TRUE((*store)->put(other, Bytes(10)).ok());
    ASSERT_TRUE((*store)->commit(9).ok());
    store = Error{};  // closed
    disk.flip_bit(kFirstFile, (3 * 4096 + 40 + 500) * 8);

    store = open_store(disk, report, all);
    ASSERT_TRUE(store.ok());
    const Result<std::optional<Bytes>> before = (*store)->get(bad);
    ASSERT_FALSE(before.ok());
    EXPECT_EQ(before.error().code, ErrorCode::FileFormat);
    EXPECT_NE(before.error().message.find(kFirstFile + ": at byte 12288"), std::string::npos) << before.error().message;
    while (*(*store)->compact(1)) {
    }
    store = Error{};
    store = open_store(disk, report, all);
    ASSERT_TRUE(store.ok());
    EXPECT_EQ((*store)->mark(), 9u);
    EXPECT_EQ((*(*store)->keys(BlobKind::DetailPage)).size(), 3u);
    const Result<std::optional<Bytes>> after = (*store)->get(bad);
    ASSERT_FALSE(after.ok());
    EXPECT_NE(after.error().message.find("world/pages-2.tlp: at byte "), std::string::npos);
    EXPECT_EQ(**(*store)->get(good), Bytes(1000, std::byte{7}));
    EXPECT_EQ((*store)->mark_of(good), std::optional<std::uint64_t>(2));
    EXPECT_EQ(**(*store)->get(other), Bytes(10));
}

// A power cut may leave a removed file behind, or one that was given up: the newest commit counts, not the name.
TEST(LogStore, OldFileThatComesBackIsRemoved) {
    FaultFiles disk;
    Worker worker(disk, 2, {.keys = 5, .store = {.most_waste = 0, .least_waste_bytes = 0}});
    ASSERT_TRUE(worker.reopen());
    for (int i = 0; i < 10; ++i) {
        ASSERT_TRUE(worker.put({BlobKind::DetailPage, i % 3, 0}, 1000));
        ASSERT_TRUE(worker.commit());
    }
    const Bytes old = disk.bytes(kFirstFile);
    while (*worker.store().compact(1u << 20)) {
    }
    ASSERT_EQ(disk.paths(), std::vector<std::string>{"world/pages-2.tlp"});
    const Bytes compacted = disk.bytes("world/pages-2.tlp");
    disk.set_bytes(kFirstFile, old);
    ASSERT_TRUE(worker.reopen());
    worker.expect_visible();
    EXPECT_EQ(disk.paths(), std::vector<std::string>{"world/pages-2.tlp"});

    // The other way round: the old file went on and has a later commit.
    FaultFiles other;
    ASSERT_TRUE(other.make_folder(kFolder).ok());
    other.set_bytes(kFirstFile, old);
    LogStoreReport report;
    auto store = open_store(other, report);
    ASSERT_TRUE(store.ok());
    for (std::uint64_t mark = 100; mark < 102; ++mark) {
        ASSERT_TRUE((*store)->put({BlobKind::World, 0, 0}, Bytes(5)).ok());
        ASSERT_TRUE((*store)->commit(mark).ok());
    }
    store = Error{};
    other.set_bytes("world/pages-2.tlp", compacted);
    store = open_store(other, report);
    ASSERT_TRUE(store.ok());
    EXPECT_EQ((*store)->mark(), 101u);
    EXPECT_EQ(other.paths(), std::vector<std::string>{kFirstFile});
}

/// One commit with blobs 0 to 3; then 2 to 5 and an erasure of 0, with a sync that failed and lost their bytes.
struct FailedSync {
    FaultFiles disk;
    LogStoreReport report;
    Result<std::unique_ptr<LogStore>> store = Error{};
    SplitMix64 random{12};
    Blobs committed, visible;

    static BlobKey key(std::int32_t x) { return {BlobKind::DetailPage, x, 7}; }

    FailedSync() {
        disk.drop_pages_of_failed_syncs();
        EXPECT_TRUE(disk.make_folder(kFolder).ok());
        EXPECT_TRUE(disk.sync_folder("").ok());
        store = open_store(disk, report, {.most_waste = 0, .least_waste_bytes = 0});
        for (std::int32_t x = 0; x < 4; ++x) committed[key(x)] = random_bytes(random, 3000);
        EXPECT_TRUE((*store)->put(key(1), Bytes(5000)).ok());  // waste, for compaction to begin
        for (const auto& [key, bytes] : committed) EXPECT_TRUE((*store)->put(key, bytes).ok());
        EXPECT_TRUE((*store)->commit(1).ok());
        visible = committed;
        for (std::int32_t x = 2; x < 6; ++x) put(key(x));
        EXPECT_TRUE((*store)->erase(key(0)).ok());
        visible.erase(key(0));
        disk.fail_at(2, Fault::Once);  // behind the write
        EXPECT_FALSE((*store)->commit(2).ok());
        EXPECT_TRUE(disk.failed());
    }
    void put(BlobKey key) {
        visible[key] = random_bytes(random, 3000);
        EXPECT_TRUE((*store)->put(key, visible[key]).ok());
    }
    void expect_commit_fails(std::int32_t x) {
        const Result<void> done = (*store)->commit(2);
        ASSERT_FALSE(done.ok()) << "it lacks what was put";
        EXPECT_EQ(done.error().code, ErrorCode::FileWrite);
        EXPECT_NE(done.error().message.find(text("(", x, ", 7)")), std::string::npos) << done.error().message;
        EXPECT_EQ((*store)->mark(), 1u);
    }
    void expect_after_crash(std::uint64_t mark, const Blobs& blobs) {
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            const std::unique_ptr<FaultFiles> after = disk.crash(seed);
            LogStoreReport found;
            auto reopened = open_store(*after, found);
            ASSERT_TRUE(reopened.ok());
            EXPECT_EQ((*reopened)->mark(), mark);
            EXPECT_EQ(blobs_of(**reopened), blobs);
            EXPECT_TRUE(found.damage.empty());
        }
    }
};

TEST(LogStore, WhatAFailedSyncLostIsNeverCommitted) {
    FailedSync work;
    for (int i = 0; i < 4; ++i) work.expect_commit_fails(2);
    work.expect_after_crash(1, work.committed);
    // One after the other is made good, by new bytes or by erasing.
    work.put(FailedSync::key(2));
    for (int i = 0; i < 3; ++i) work.expect_commit_fails(3);
    EXPECT_TRUE((*work.store)->erase(FailedSync::key(3)).ok());
    work.visible.erase(FailedSync::key(3));
    for (int i = 0; i < 3; ++i) work.expect_commit_fails(4);
    work.put(FailedSync::key(5));
    for (int i = 0; i < 3; ++i) work.expect_commit_fails(4);
    work.put(FailedSync::key(4));
    ASSERT_TRUE((*work.store)->commit(3).ok());
    EXPECT_EQ(blobs_of(**work.store), work.visible);
    work.expect_after_crash(3, work.visible);
    // And it goes on as ever, the lost frames being waste.
    while (*(*work.store)->compact(1)) {
    }
    work.put(FailedSync::key(1));
    ASSERT_TRUE((*work.store)->commit(4).ok());
    work.expect_after_crash(4, work.visible);
}

TEST(LogStore, CompactionDoesNotTakeWhatAFailedSyncLost) {
    FailedSync work;
    Result<bool> more = true;
    for (int steps = 0; more.ok() && *more; ++steps) {
        ASSERT_LT(steps, 100);
        more = (*work.store)->compact(1);
    }
    ASSERT_FALSE(more.ok()) << "it would be finished with blobs that are gone";
    EXPECT_EQ(more.error().code, ErrorCode::FileWrite);
    EXPECT_NE(more.error().message.find("(2, 7)"), std::string::npos) << more.error().message;
    for (int i = 0; i < 2; ++i) work.expect_commit_fails(2);
    work.expect_after_crash(1, work.committed);
    for (std::int32_t x = 2; x < 6; ++x) work.put(FailedSync::key(x));
    while (*(*work.store)->compact(1)) {
    }
    work.expect_after_crash(1, work.committed);
    ASSERT_TRUE((*work.store)->commit(2).ok());
    EXPECT_EQ(blobs_of(**work.store), work.visible);
    work.expect_after_crash(2, work.visible);
}

// The disk has it as it comes: nobody else's sync waits for the whole of a new file.
TEST(LogStore, CompactionSyncsAsItGoes) {
    for (const std::uint64_t step : {1u << 20, 1u << 30}) {
        FaultFiles disk;
        ASSERT_TRUE(disk.make_folder(kFolder).ok());
        LogStoreReport report;
        auto store = open_store(disk, report, {.most_waste = 0, .least_waste_bytes = 0});
        ASSERT_TRUE(store.ok());
        for (std::int32_t x = 0; x < 45; ++x)
            ASSERT_TRUE((*store)->put({BlobKind::Stroke, x % 40, 0}, Bytes(1u << 20)).ok());
        ASSERT_TRUE((*store)->commit(1).ok());
        const std::uint64_t syncs = disk.counts().syncs;
        std::uint64_t since = 0, most = 0, seen = syncs, last = disk.counts().written_bytes;
        bool more = true;
        while (more) {
            more = *(*store)->compact(step);
            const FaultFiles::Counts now = disk.counts();
            since += now.written_bytes - last, last = now.written_bytes;
            most = std::max(most, since);
            if (now.syncs != seen) since = 0, seen = now.syncs;
        }
        EXPECT_GE(disk.counts().syncs - syncs, 3 + 2u) << "one made the file, two end it";
        if (step == 1u << 20) {
            EXPECT_LE(most, 19u << 20);
        }
    }
}

TEST(LogStore, WorksOnTheSystemsFiles) {
    const ScratchFolder scratch;
    const std::string folder = scratch.path("Gel\xc3\xa4nde mit Spuren");
    FileSystem& files = system_files();
    LogStoreReport report;
    const LogStoreSettings all{.most_waste = 0, .least_waste_bytes = 0};
    EXPECT_EQ(LogStore::open(files, folder, kSalt, all, report).error().code, ErrorCode::NotFound);
    EXPECT_FALSE(LogStore::open(files, scratch.put("file", Bytes(1)), kSalt, all, report).ok());
    ASSERT_TRUE(files.make_folder(folder).ok());

    SplitMix64 random{8};
    Blobs expected;
    for (std::uint64_t round = 1; round <= 4; ++round) {
        auto store = LogStore::open(files, folder, kSalt, all, report);
        ASSERT_TRUE(store.ok()) << store.error().message;
        EXPECT_EQ(blobs_of(**store), expected);
        EXPECT_EQ((*store)->mark(), round - 1);
        for (int i = 0; i < 200; ++i) {
            const BlobKey key = random_key(random, 100);
            expected[key] = random_bytes(random, random.next() % 20'000);
            ASSERT_TRUE((*store)->put(key, expected[key]).ok());
        }
        ASSERT_TRUE((*store)->commit(round).ok());
        EXPECT_EQ(blobs_of(**store), expected);
        if (round % 2 == 0)
            while (*(*store)->compact(100'000)) {
            }
        ASSERT_TRUE((*store)->put({BlobKind::World, 0, 0}, Bytes(2'000'000)).ok());  // written, never committed
        EXPECT_EQ((*files.list(folder)).size(), 1u);
    }
    EXPECT_GT(report.truncated_bytes, 2'000'000u);
}

}  // namespace
}  // namespace tilth::test
