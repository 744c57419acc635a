// What the tests of the journal share: edits that are all different, and a journal that opens or fails the test.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "support/fault_files.h"
#include "tilth/store/journal.h"
#include "tilth/store/journal_files.h"

namespace tilth::test {

inline constexpr std::uint64_t kSalt = 0x5a17'5a17'0000'0001u;
inline constexpr FlushPolicy kManual{.when = FlushPolicy::When::Manual};
inline constexpr FlushPolicy kEach{.when = FlushPolicy::When::Each};

/// Any edit that can be: every field of the record is drawn.
inline Edit random_edit(std::mt19937_64& random) {
    Edit edit{.kind = static_cast<EditKind>(random() % 3), .begins_stroke = random() % 2 == 0, .record = {}};
    edit.record.sequence = random();
    if (edit.kind != EditKind::Stamp) return edit;
    StampRecord& record = edit.record;
    record.centre_x = static_cast<std::int64_t>(random());
    record.centre_z = static_cast<std::int64_t>(random());
    record.shape_hash = random();
    for (std::uint32_t* field :
         {&record.shape, &record.radius, &record.amplitude, &record.level, &record.rotation, &record.key})
        *field = static_cast<std::uint32_t>(random());
    record.map = static_cast<MapKind>(random() % 2);
    record.rule = static_cast<StampRule>(random() % 5);
    record.negative = random() % 2;
    record.mirror = random() % 2;
    return edit;
}

inline std::vector<Edit> random_edits(std::size_t count, std::uint64_t seed = 1) {
    std::mt19937_64 random(seed);
    std::vector<Edit> edits;
    for (std::size_t i = 0; i < count; ++i) edits.push_back(random_edit(random));
    return edits;
}

/// A journal, and what opening it found. Edit number n of a test is `edits[n - 1]`.
struct OpenJournal {
    std::unique_ptr<Journal> journal;
    JournalReport report;
    std::vector<Edit> tail;
};

inline Result<OpenJournal> try_open(FileSystem& files, std::uint64_t from = 0, const FlushPolicy& policy = kManual) {
    OpenJournal open;
    Result<std::unique_ptr<Journal>> journal =
        Journal::open(files, "world", kSalt, from, policy, open.report, open.tail);
    if (!journal) return journal.error();
    open.journal = *std::move(journal);
    return open;
}

inline OpenJournal open_journal(FileSystem& files, std::uint64_t from = 0, const FlushPolicy& policy = kManual) {
    Result<OpenJournal> open = try_open(files, from, policy);
    EXPECT_TRUE(open.ok()) << (open.ok() ? "" : open.error().message);
    return open.ok() ? *std::move(open) : OpenJournal{};
}

/// An empty disk with the world's folder.
inline std::unique_ptr<FaultFiles> new_disk() {
    auto disk = std::make_unique<FaultFiles>();
    EXPECT_TRUE(disk->make_folder("world").ok());
    EXPECT_TRUE(disk->sync_folder("").ok());
    return disk;
}

/// Appends edits first..last and flushes.
inline void append(Journal& journal, const std::vector<Edit>& edits, std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t number = first; number <= last; ++number) ASSERT_EQ(journal.append(edits[number - 1]), number);
    ASSERT_TRUE(journal.flush().ok());
}

inline std::string path_of(std::uint64_t first) { return "world/" + name_of_segment(first); }

/// `found` are the edits from `first` on.
inline void expect_edits(const std::vector<Edit>& found, const std::vector<Edit>& edits, std::uint64_t first) {
    ASSERT_LE(first - 1 + found.size(), edits.size());
    for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i], edits[first - 1 + i]) << "edit " << first + i;
}

}  // namespace tilth::test
