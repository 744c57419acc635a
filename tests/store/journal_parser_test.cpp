// Journal files with flipped bits, cut short, grown and stirred: never a crash, never an edit that was not appended.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "store/journal_support.h"

namespace tilth {
namespace {

using test::FaultFiles;
using test::OpenJournal;
using test::path_of;

/// Edits 1..60 in three files.
std::unique_ptr<FaultFiles> three_files(const std::vector<Edit>& edits) {
    std::unique_ptr<FaultFiles> disk = test::new_disk();
    const OpenJournal open = test::open_journal(*disk);
    for (const std::uint64_t first : {1, 21, 41}) {
        test::append(*open.journal, edits, first, first + 19);
        EXPECT_TRUE(open.journal->release(0, 0).ok());
    }
    return disk;
}

void spoil(FaultFiles& disk, std::mt19937_64& random) {
    const std::vector<std::string> paths = disk.paths();
    const std::string path = paths[random() % paths.size()];
    std::vector<std::byte> bytes = disk.bytes(path);
    switch (random() % 6) {
        case 0:
        case 1:
        case 2:
            for (std::uint64_t flips = 1 + random() % 3; flips > 0 && !bytes.empty(); --flips)
                bytes[random() % bytes.size()] ^= static_cast<std::byte>(1u << (random() % 8));
            break;
        case 3:
            bytes.resize(random() % (bytes.size() + 1));
            break;
        case 4:
            bytes.resize(bytes.size() + random() % 300, static_cast<std::byte>(random() % 3));
            break;
        default: {  // bytes of one place at another
            const std::size_t count = std::min<std::size_t>(bytes.size() / 2, 1 + random() % 200);
            const std::size_t from = random() % (bytes.size() - count + 1), to = random() % (bytes.size() - count + 1);
            const std::vector<std::byte> moved(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                                               bytes.begin() + static_cast<std::ptrdiff_t>(from + count));
            std::copy(moved.begin(), moved.end(), bytes.begin() + static_cast<std::ptrdiff_t>(to));
        }
    }
    disk.set_bytes(path, bytes);
}

TEST(JournalFiles, TenThousandDamages) {
    const std::vector<Edit> edits = test::random_edits(80);
    const std::unique_ptr<FaultFiles> good = three_files(edits);
    std::mt19937_64 random(10);
    int whole = 0, shorter = 0, reported = 0;
    for (int round = 0; round < 10'000; ++round) {
        SCOPED_TRACE(round);
        const std::unique_ptr<FaultFiles> disk = test::new_disk();
        for (const std::string& path : good->paths()) disk->set_bytes(path, good->bytes(path));
        for (std::uint64_t times = 1 + random() % 2; times > 0; --times) spoil(*disk, random);
        const std::uint64_t from = random() % 4 == 0 ? random() % 70 : 0;
        Result<OpenJournal> open = test::try_open(*disk, from);
        ASSERT_TRUE(open.ok()) << open.error().message;  // no damage makes a header of another kind
        test::expect_edits(open->tail, edits, from + 1);
        ASSERT_EQ(open->journal->appended(), from + open->tail.size());
        ASSERT_LE(disk->counts().most_read_bytes, 1u << 16);
        const std::uint64_t last = open->journal->appended(), first = open->journal->first();
        (last == std::max<std::uint64_t>(from, 60) ? whole : shorter) += 1;
        reported += !open->report.damage.empty();
        if (last < 60 && from <= last && open->report.damage.empty()) {
            ASSERT_GT(open->report.truncated_bytes + 61, last);
        }
        // What it says it has, it gives, or says what is damaged.
        if (first <= last) {
            const Result<std::vector<Edit>> read = open->journal->read(first, last);
            if (read) {
                ASSERT_EQ(read->size(), last - first + 1);
                test::expect_edits(*read, edits, first);
            } else {
                ASSERT_EQ(read.error().code, ErrorCode::FileFormat);
                ASSERT_LE(first, from);  // what was wanted was looked at
            }
        }
        // And it goes on.
        test::append(*open->journal, edits, last + 1, last + 2);
        open->journal.reset();
        const OpenJournal again = test::open_journal(*disk, from);
        ASSERT_EQ(again.journal->appended(), last + 2);
        test::expect_edits(again.tail, edits, from + 1);
        ASSERT_TRUE(again.report.damage.empty());
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(whole, 100);
    EXPECT_GT(shorter, 1000);
    EXPECT_GT(reported, 1000);
}

}  // namespace
}  // namespace tilth
