// The journal: what was flushed is there, in order, whatever happened; what is there is a prefix of what was appended.
#include "tilth/store/journal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "io/scratch_folder.h"
#include "store/journal_support.h"
#include "tilth/core/hash.h"

namespace tilth {
namespace {

using test::FaultFiles;
using test::kEach;
using test::kManual;
using test::kSalt;
using test::OpenJournal;
using test::path_of;

using DiskPtr = std::unique_ptr<FaultFiles>;

/// Edits in segments that begin with the given numbers; the last has `last` as its last edit.
DiskPtr disk_with(const std::vector<Edit>& edits, const std::vector<std::uint64_t>& firsts, std::uint64_t last) {
    DiskPtr disk = test::new_disk();
    const OpenJournal open = test::open_journal(*disk);
    for (std::size_t i = 0; i < firsts.size(); ++i) {
        test::append(*open.journal, edits, firsts[i], i + 1 < firsts.size() ? firsts[i + 1] - 1 : last);
        // Closes the segment (it has a 16th of what is kept) and keeps it (it does not exceed it).
        EXPECT_TRUE(open.journal->release(0, 0).ok());
    }
    open.journal->abandon();
    for (const std::uint64_t first : firsts) EXPECT_TRUE(disk->exists(path_of(first))) << first;
    return disk;
}

std::vector<std::string> damaged_files(const FaultFiles& disk) {
    std::vector<std::string> found = disk.paths();
    std::erase_if(found, [](const std::string& path) { return path.find(".damaged") == std::string::npos; });
    return found;
}

bool mentions(const std::vector<Error>& errors, const std::string& what) {
    return std::any_of(errors.begin(), errors.end(),
                       [&](const Error& error) { return error.message.find(what) != std::string::npos; });
}

TEST(Journal, ANewOneIsEmptyAndMakesNoFile) {
    const DiskPtr disk = test::new_disk();
    {
        const OpenJournal open = test::open_journal(*disk);
        EXPECT_TRUE(open.tail.empty());
        EXPECT_EQ(open.journal->appended(), 0u);
        EXPECT_EQ(open.journal->durable(), 0u);
        EXPECT_EQ(open.journal->first(), 1u);
        EXPECT_TRUE(open.journal->flush().ok());
        EXPECT_EQ(open.journal->disk_bytes(), 0u);
    }
    EXPECT_TRUE(disk->paths().empty());
}

TEST(Journal, ReopeningGivesWhatIsAboveTheSnapshot) {
    const std::vector<Edit> edits = test::random_edits(3000);  // more than one block
    const DiskPtr disk = disk_with(edits, {1, 1500, 1501}, 3000);
    for (const std::uint64_t from : {0, 1, 1023, 1024, 1025, 1498, 1499, 1500, 1501, 2999, 3000}) {
        const OpenJournal open = test::open_journal(*disk, from);
        EXPECT_EQ(open.tail.size(), 3000 - from);
        test::expect_edits(open.tail, edits, from + 1);
        EXPECT_EQ(open.journal->appended(), 3000u);
        EXPECT_EQ(open.journal->durable(), 3000u);
        EXPECT_EQ(open.journal->first(), 1u);
        EXPECT_EQ(open.report.truncated_bytes, 0u);
        EXPECT_TRUE(open.report.damage.empty());
        EXPECT_EQ(open.journal->disk_bytes(), 3 * 64 + 3000 * 64u);
    }
}

TEST(Journal, OpeningReadsWhatIsWantedAlone) {
    const std::vector<Edit> edits = test::random_edits(20'000);
    const DiskPtr disk = disk_with(edits, {1}, 20'000);
    const FaultFiles::Counts before = disk->counts();
    const OpenJournal open = test::open_journal(*disk, 19'990);
    const FaultFiles::Counts after = disk->counts();
    EXPECT_EQ(open.tail.size(), 10u);
    EXPECT_LE(after.read_bytes - before.read_bytes, 64u + 10 * 64u);
    EXPECT_LE(after.most_read_bytes, 1u << 16);
}

TEST(Journal, OnTheRealDisk) {
    const std::vector<Edit> edits = test::random_edits(300);
    const test::ScratchFolder scratch;
    const std::string folder = scratch.path("a world, größer");
    ASSERT_TRUE(system_files().make_folder(folder).ok());
    const FlushPolicy every{.when = FlushPolicy::When::Every, .interval_ms = 1};
    std::uint64_t number = 0;
    for (const FlushPolicy& policy : {kManual, kEach, every}) {
        JournalReport report;
        std::vector<Edit> tail;
        Result<std::unique_ptr<Journal>> journal =
            Journal::open(system_files(), folder, kSalt, 0, policy, report, tail);
        ASSERT_TRUE(journal.ok()) << journal.error().message;
        ASSERT_EQ(tail.size(), number);
        test::expect_edits(tail, edits, 1);
        for (int i = 0; i < 100; ++i, ++number) {
            (*journal)->append(edits[number]);
            if (policy.when == FlushPolicy::When::Each) {
                EXPECT_EQ((*journal)->durable(), number + 1);
            }
        }
        EXPECT_TRUE((*journal)->take_errors().empty());
    }
    JournalReport report;
    std::vector<Edit> tail;
    ASSERT_TRUE(Journal::open(system_files(), folder, kSalt, 0, kManual, report, tail).ok());
    EXPECT_EQ(tail.size(), 300u);
    test::expect_edits(tail, edits, 1);
}

TEST(Journal, ReadGivesFilesAndMemory) {
    const std::vector<Edit> edits = test::random_edits(2500);
    const DiskPtr disk = disk_with(edits, {1, 700}, 2000);
    const OpenJournal open = test::open_journal(*disk, 1990);
    for (std::uint64_t number = 2001; number <= 2500; ++number) open.journal->append(edits[number - 1]);
    for (const auto& [first, last] : {std::pair{1, 1}, {1, 2500}, {699, 701}, {2000, 2001}, {2100, 2500}}) {
        const Result<std::vector<Edit>> read =
            open.journal->read(static_cast<std::uint64_t>(first), static_cast<std::uint64_t>(last));
        ASSERT_TRUE(read.ok()) << read.error().message;
        ASSERT_EQ(read->size(), static_cast<std::size_t>(last - first + 1));
        test::expect_edits(*read, edits, static_cast<std::uint64_t>(first));
    }
    EXPECT_FALSE(open.journal->read(0, 5).ok());
    EXPECT_FALSE(open.journal->read(5, 4).ok());
    EXPECT_FALSE(open.journal->read(2500, 2501).ok());
}

TEST(Journal, AbandoningLosesOnlyWhatWasNotFlushed) {
    const std::vector<Edit> edits = test::random_edits(30);
    const DiskPtr disk = test::new_disk();
    {
        const OpenJournal open = test::open_journal(*disk);
        test::append(*open.journal, edits, 1, 20);
        for (std::uint64_t number = 21; number <= 25; ++number) open.journal->append(edits[number - 1]);
        open.journal->abandon();
        const std::uint64_t writes = disk->counts().writes;
        EXPECT_EQ(open.journal->append(edits[25]), 26u);
        EXPECT_FALSE(open.journal->flush().ok());
        EXPECT_TRUE(open.journal->release(20, 0).ok());
        EXPECT_EQ(disk->counts().writes, writes);
        EXPECT_EQ(open.journal->durable(), 20u);
    }
    const OpenJournal open = test::open_journal(*disk);
    EXPECT_EQ(open.tail.size(), 20u);
    test::expect_edits(open.tail, edits, 1);
}

// Every byte length of a torn tail, with and without bytes that look like nothing, and like an old entry.
TEST(Journal, ATornTailIsCutOff) {
    const std::vector<Edit> edits = test::random_edits(20);
    const DiskPtr whole = disk_with(edits, {1}, 12);
    const std::vector<std::byte> bytes = whole->bytes(path_of(1));
    ASSERT_EQ(bytes.size(), 64 + 12 * 64u);
    for (std::size_t size = 0; size <= bytes.size(); ++size) {
        const DiskPtr disk = test::new_disk();
        disk->set_bytes(path_of(1), {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
        const std::uint64_t whole_edits = size < 64 ? 0 : (size - 64) / 64;
        {
            const OpenJournal open = test::open_journal(*disk);
            ASSERT_EQ(open.tail.size(), whole_edits) << size;
            test::expect_edits(open.tail, edits, 1);
            EXPECT_TRUE(open.report.damage.empty()) << size;
            EXPECT_EQ(open.report.truncated_bytes, size < 64 ? 0 : (size - 64) % 64) << size;
            test::append(*open.journal, edits, whole_edits + 1, 15);
        }
        const OpenJournal open = test::open_journal(*disk);
        ASSERT_EQ(open.tail.size(), 15u) << size;
        test::expect_edits(open.tail, edits, 1);
        EXPECT_EQ(open.report.truncated_bytes, 0u);
    }
    for (const int fill : {0x00, 0xff})  // the file system made the file longer, and no more
        for (const std::size_t more : {1u, 64u, 1000u}) {
            const DiskPtr disk = test::new_disk();
            std::vector<std::byte> longer = bytes;
            longer.resize(bytes.size() + more, static_cast<std::byte>(fill));
            disk->set_bytes(path_of(1), longer);
            const OpenJournal open = test::open_journal(*disk);
            EXPECT_EQ(open.tail.size(), 12u);
            EXPECT_EQ(open.report.truncated_bytes, more);
            EXPECT_TRUE(open.report.damage.empty());
            EXPECT_EQ(disk->bytes(path_of(1)), bytes);
        }
}

TEST(Journal, DamageInTheMiddleIsReportedAndMovedAside) {
    const std::vector<Edit> edits = test::random_edits(60);
    for (const std::uint64_t damaged : {1, 2, 19, 20, 21, 30, 39, 40}) {  // of segments 1..19, 20..39, 40..50
        const DiskPtr disk = disk_with(edits, {1, 20, 40}, 50);
        const std::uint64_t first = damaged < 20 ? 1 : damaged < 40 ? 20 : 40;
        const std::vector<std::byte> original = disk->bytes(path_of(first));
        const std::uint64_t offset = 64 * (damaged - first + 1);
        disk->flip_bit(path_of(first), offset * 8 + 100);
        {
            const OpenJournal open = test::open_journal(*disk);
            EXPECT_EQ(open.tail.size(), damaged - 1);
            test::expect_edits(open.tail, edits, 1);
            ASSERT_EQ(open.report.damage.size(), 1u) << damaged;
            EXPECT_TRUE(mentions(open.report.damage, path_of(first) + ": offset " + std::to_string(offset)));
            EXPECT_EQ(open.report.truncated_bytes, 0u);
            EXPECT_EQ(open.journal->appended(), damaged - 1);
            test::append(*open.journal, edits, damaged, 45);  // its numbers are free again
        }
        // Every entry behind the damage is aside, in files that are segments themselves.
        std::uint64_t aside = 0;
        for (const std::string& path : damaged_files(*disk)) {
            const std::string name = path.substr(6, path.size() - 6 - std::string(".damaged").size());
            const std::uint64_t begins = number_of_segment(name).value_or(0);
            const std::vector<std::byte> bytes = disk->bytes(path);
            EXPECT_TRUE(check_journal_header(bytes, begins, kSalt, path).ok()) << path;
            for (std::uint64_t number = begins; offset_of_entry(begins, number) < bytes.size(); ++number, ++aside) {
                const std::span<const std::byte> entry = std::span(bytes).subspan(offset_of_entry(begins, number), 64);
                const std::optional<Edit> edit = decode_entry(entry.first<64>(), number, kSalt);
                EXPECT_EQ(edit.has_value(), number != damaged) << number;
                if (edit) {
                    EXPECT_EQ(*edit, edits[number - 1]);
                }
            }
        }
        EXPECT_EQ(aside, 50 - damaged + 1);
        const OpenJournal open = test::open_journal(*disk);
        EXPECT_EQ(open.tail.size(), 45u) << damaged;
        test::expect_edits(open.tail, edits, 1);
        EXPECT_TRUE(open.report.damage.empty());
    }
}

TEST(Journal, ASecondDamageDoesNotReplaceWhatTheFirstMovedAside) {
    const std::vector<Edit> edits = test::random_edits(30);
    const DiskPtr disk = disk_with(edits, {1}, 30);
    for (std::size_t round = 1; round <= 3; ++round) {
        disk->flip_bit(path_of(1), offset_of_entry(1, 10) * 8);
        const OpenJournal open = test::open_journal(*disk);
        EXPECT_EQ(open.tail.size(), 9u);
        EXPECT_EQ(damaged_files(*disk).size(), round);
        test::append(*open.journal, edits, 10, 30);
    }
}

TEST(Journal, EntriesUpToTheSnapshotAreNotLookedAt) {
    const std::vector<Edit> edits = test::random_edits(40);
    const DiskPtr disk = disk_with(edits, {1, 20}, 40);
    disk->flip_bit(path_of(1), offset_of_entry(1, 5) * 8);
    disk->flip_bit(path_of(20), offset_of_entry(20, 25) * 8);
    const OpenJournal open = test::open_journal(*disk, 30);
    EXPECT_EQ(open.tail.size(), 10u);
    test::expect_edits(open.tail, edits, 31);
    EXPECT_TRUE(open.report.damage.empty());
    EXPECT_TRUE(open.journal->read(26, 40).ok());
    const Result<std::vector<Edit>> read = open.journal->read(1, 40);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::FileFormat);
    EXPECT_NE(read.error().message.find(path_of(1) + ": offset 320: edit 5"), std::string::npos)
        << read.error().message;
}

TEST(Journal, AMissingSegmentIsReportedAndLaterEditsAreFoundAgain) {
    const std::vector<Edit> edits = test::random_edits(60);
    for (const std::uint64_t from : {0, 5, 19, 25}) {  // 20..39 is gone
        const DiskPtr disk = disk_with(edits, {1, 20, 40}, 50);
        ASSERT_TRUE(disk->remove(path_of(20)).ok());
        const std::uint64_t last = std::max<std::uint64_t>(from, 19);
        {
            const OpenJournal open = test::open_journal(*disk, from);
            EXPECT_EQ(open.tail.size(), last - from);
            test::expect_edits(open.tail, edits, from + 1);
            EXPECT_EQ(open.report.damage.size(), 1u);
            EXPECT_TRUE(mentions(open.report.damage, "edit " + std::to_string(last + 1) + " is missing"));
            EXPECT_TRUE(disk->exists(path_of(40) + ".damaged"));
            test::append(*open.journal, edits, last + 1, 55);
        }
        const OpenJournal open = test::open_journal(*disk, from);
        EXPECT_EQ(open.tail.size(), 55 - from);
        test::expect_edits(open.tail, edits, from + 1);
        EXPECT_TRUE(open.report.damage.empty());
    }
}

TEST(Journal, AGapInFrontOfEverythingIsReported) {
    const std::vector<Edit> edits = test::random_edits(60);
    const DiskPtr disk = disk_with(edits, {1, 20, 40}, 50);
    ASSERT_TRUE(disk->remove(path_of(1)).ok());
    {
        const OpenJournal open = test::open_journal(*disk, 12);
        EXPECT_TRUE(open.tail.empty());
        EXPECT_TRUE(mentions(open.report.damage, path_of(20)));
        EXPECT_TRUE(mentions(open.report.damage, "edits 13 to 19 are missing"));
        EXPECT_EQ(damaged_files(*disk).size(), 2u);
        test::append(*open.journal, edits, 13, 30);
    }
    const OpenJournal open = test::open_journal(*disk, 12);
    EXPECT_EQ(open.tail.size(), 18u);
    test::expect_edits(open.tail, edits, 13);
}

TEST(Journal, NumbersGoOnBehindThePages) {
    const std::vector<Edit> edits = test::random_edits(100);
    const DiskPtr disk = disk_with(edits, {1}, 50);
    {
        const OpenJournal open = test::open_journal(*disk, 60);  // the pages have edits that the journal lost
        EXPECT_TRUE(open.tail.empty());
        EXPECT_EQ(open.report.damage.size(), 1u);
        EXPECT_EQ(open.journal->appended(), 60u);
        EXPECT_EQ(open.journal->durable(), 60u);
        EXPECT_EQ(open.journal->first(), 61u);
        test::append(*open.journal, edits, 61, 70);
        EXPECT_EQ(open.journal->first(), 61u);
        EXPECT_TRUE(disk->exists(path_of(61)));
        const Result<std::vector<Edit>> read = open.journal->read(45, 65);
        ASSERT_FALSE(read.ok());
        EXPECT_EQ(read.error().code, ErrorCode::NotFound);
        EXPECT_NE(read.error().message.find("edit 51"), std::string::npos);
    }
    const OpenJournal open = test::open_journal(*disk, 60);
    EXPECT_EQ(open.tail.size(), 10u);
    test::expect_edits(open.tail, edits, 61);
    EXPECT_TRUE(open.report.damage.empty());  // what is missing is in the pages: said once

    const DiskPtr nothing = test::new_disk();  // everything was released
    const OpenJournal later = test::open_journal(*nothing, 1000);
    EXPECT_EQ(later.journal->appended(), 1000u);
    EXPECT_TRUE(later.report.damage.empty());
    EXPECT_EQ(later.journal->append(edits[0]), 1001u);
}

TEST(Journal, ADamagedHeaderCostsNothing) {
    const std::vector<Edit> edits = test::random_edits(50);
    for (const std::uint64_t first : {1, 20, 40})
        for (std::uint64_t bit = 0; bit < 512; bit += 7) {
            const DiskPtr disk = disk_with(edits, {1, 20, 40}, 50);
            const std::vector<std::byte> good = disk->bytes(path_of(first));
            disk->flip_bit(path_of(first), bit);
            const OpenJournal open = test::open_journal(*disk);
            EXPECT_EQ(open.tail.size(), 50u);
            test::expect_edits(open.tail, edits, 1);
            ASSERT_EQ(open.report.damage.size(), 1u);
            EXPECT_TRUE(mentions(open.report.damage, path_of(first) + ": offset 0"));
            EXPECT_EQ(disk->bytes(path_of(first)), good);
        }
}

TEST(Journal, FilesOfOthersAreRefusedAndNotTouched) {
    const std::vector<Edit> edits = test::random_edits(20);
    const DiskPtr good = disk_with(edits, {1}, 20);
    const std::vector<std::byte> bytes = good->bytes(path_of(1));
    const auto refused = [&](const std::string& path, std::vector<std::byte> content, const std::string& because) {
        const DiskPtr disk = test::new_disk();
        disk->set_bytes(path, content);
        const Result<OpenJournal> open = test::try_open(*disk);
        ASSERT_FALSE(open.ok()) << because;
        EXPECT_EQ(open.error().code, ErrorCode::FileFormat);
        EXPECT_NE(open.error().message.find(because), std::string::npos) << open.error().message;
        EXPECT_EQ(open.error().message.rfind(path, 0), 0u) << open.error().message;
        EXPECT_EQ(disk->bytes(path), content);
    };
    std::vector<std::byte> newer = bytes;
    newer[8] = std::byte{2};
    const std::uint64_t sum = hash_bytes(std::span(newer).first(56));
    std::memcpy(newer.data() + 56, &sum, 8);
    refused(path_of(1), newer, "version 2");
    refused(path_of(5), bytes, "begins with edit 1");
    std::vector<std::byte> other = bytes;
    const JournalHeader header = encode_journal_header(1, kSalt + 1);
    std::copy(header.begin(), header.end(), other.begin());
    refused(path_of(1), other, "another world");
    // Names that are not ours are left alone.
    const DiskPtr disk = test::new_disk();
    for (const char* name : {"world/journal-1.tlj", "world/journal-00000000000000000000.tlj",
                             "world/journal-99999999999999999999.tlj", "world/journal-0000000000000000000x.tlj"})
        disk->set_bytes(name, bytes);
    EXPECT_TRUE(test::open_journal(*disk).tail.empty());
    EXPECT_EQ(disk->paths().size(), 4u);
}

TEST(Journal, FilesThatCannotBeReadAreAnError) {
    const DiskPtr disk = disk_with(test::random_edits(20), {1}, 20);
    disk->fail_reads(path_of(1));
    const Result<OpenJournal> open = test::try_open(*disk);
    ASSERT_FALSE(open.ok());
    EXPECT_EQ(open.error().code, ErrorCode::FileRead);
    for (const double interval : {0.0, -1.0, 60'001.0, std::numeric_limits<double>::quiet_NaN()}) {
        const FlushPolicy policy{.when = FlushPolicy::When::Every, .interval_ms = interval};
        EXPECT_FALSE(test::try_open(*test::new_disk(), 0, policy).ok());
    }
}

TEST(Journal, ReleaseLetsOldFilesGo) {
    const std::vector<Edit> edits = test::random_edits(200);
    const DiskPtr disk = test::new_disk();
    const OpenJournal open = test::open_journal(*disk);
    Journal& journal = *open.journal;
    constexpr std::uint64_t kSegment = 64 + 10 * 64;
    for (std::uint64_t first = 1; first <= 100; first += 10) {
        test::append(journal, edits, first, first + 9);
        ASSERT_TRUE(journal.release(first + 9, 5 * kSegment).ok());
        const std::uint64_t kept = std::min<std::uint64_t>(5, (first + 9) / 10);
        EXPECT_EQ(disk->paths().size(), kept);
        EXPECT_EQ(journal.disk_bytes(), kept * kSegment);
        EXPECT_EQ(journal.first(), first + 10 - 10 * kept);
    }
    EXPECT_FALSE(journal.read(50, 60).ok());
    EXPECT_TRUE(journal.read(51, 100).ok());
    // What is not in the pages stays, whatever the bound.
    ASSERT_TRUE(journal.release(75, 0).ok());
    EXPECT_EQ(journal.first(), 71u);
    // What is in memory alone is not released.
    journal.append(edits[100]);
    ASSERT_TRUE(journal.release(101, 0).ok());
    EXPECT_EQ(journal.first(), 101u);
    EXPECT_TRUE(disk->paths().empty());
    const Result<std::vector<Edit>> unflushed = journal.read(101, 101);
    ASSERT_TRUE(unflushed.ok());
    EXPECT_EQ((*unflushed)[0], edits[100]);
    ASSERT_TRUE(journal.flush().ok());
    EXPECT_TRUE(disk->exists(path_of(101)));
    const OpenJournal again = test::open_journal(*disk, 100);
    EXPECT_EQ(again.tail.size(), 1u);
}

// A world that is saved often does not get a file for every few edits.
TEST(Journal, SmallFilesAreGoneOnWith) {
    const std::vector<Edit> edits = test::random_edits(5000);
    const DiskPtr disk = test::new_disk();
    const OpenJournal open = test::open_journal(*disk);
    constexpr std::uint64_t kKeep = 64'000;
    for (std::uint64_t number = 1; number <= 5000; ++number) {
        open.journal->append(edits[number - 1]);
        if (number % 5 != 0) continue;
        ASSERT_TRUE(open.journal->flush().ok());
        ASSERT_TRUE(open.journal->release(number, kKeep).ok());
        ASSERT_LE(disk->paths().size(), 18u);
        ASSERT_LE(open.journal->disk_bytes(), kKeep + kKeep / 16 + 6 * 64);
    }
    EXPECT_LE(open.journal->first(), 5000 - kKeep / 64 + kKeep / 64 / 8);  // and what is kept is nearly all that may be
}

}  // namespace
}  // namespace tilth
