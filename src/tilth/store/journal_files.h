// The files of a journal, one behind the other: names, headers, reading entries, appending them, letting old files go.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/edit.h"
#include "tilth/store/file_system.h"
#include "tilth/store/journal_entry.h"

namespace tilth {

/// A *segment*: one file, with edits `first`, `first + 1` and so on.
struct JournalSegment {
    std::uint64_t first = 1, count = 0;
    /// One more than its last edit.
    [[nodiscard]] std::uint64_t end() const { return first + count; }
    [[nodiscard]] std::uint64_t bytes() const;
};

inline constexpr std::size_t kJournalHeaderBytes = 64;
using JournalHeader = std::array<std::byte, kJournalHeaderBytes>;

/// Where edit `number` lies in the segment that begins with edit `first`.
constexpr std::uint64_t offset_of_entry(std::uint64_t first, std::uint64_t number) {
    return kJournalHeaderBytes + kJournalEntryBytes * (number - first);
}

/// Where a world's journal is.
struct JournalPlace {
    FileSystem* files = nullptr;
    std::string folder;
    std::uint64_t salt = 0;

    [[nodiscard]] std::string path(std::uint64_t first) const;
};

std::string name_of_segment(std::uint64_t first);
/// Empty: the name of something else.
std::optional<std::uint64_t> number_of_segment(std::string_view name);

JournalHeader encode_journal_header(std::uint64_t first, std::uint64_t salt);
/// False: torn or damaged. Fails (FileFormat) on a header that is whole, but of a newer version, of another world, or
/// of a file that was renamed; `path` begins the message.
Result<bool> check_journal_header(std::span<const std::byte> bytes, std::uint64_t first, std::uint64_t salt,
                                  std::string_view path);

/// Reads a segment's entries, in blocks, best in ascending order.
class EntryReader {
public:
    EntryReader(File& file, std::uint64_t first, std::uint64_t salt) : file_(&file), first_(first), salt_(salt) {}
    /// Empty: damaged, or behind the end of the file.
    Result<std::optional<Edit>> at(std::uint64_t number);

private:
    File* file_;
    std::uint64_t first_, salt_;
    std::vector<std::byte> block_;
    std::uint64_t block_begin_ = 0, block_end_ = 0;  ///< numbers of the edits in it
};

/// Appends to the last segment and begins new ones. Threads: one at a time.
class JournalWriter {
public:
    /// `segments` in order; `tail`: the last of them, open for writing, or nullptr: the next write begins a new one.
    JournalWriter(JournalPlace place, std::vector<JournalSegment> segments, std::unique_ptr<File> tail)
        : place_(std::move(place)), segments_(std::move(segments)), file_(std::move(tail)) {}

    /// Whole entries, the first of them edit `first`, the one behind the last. Durable on return: one write, one sync
    /// (and one of the folder with a new file). After an error nothing of it counts: the same entries, and more, are to
    /// be written again, to the same place. That is also the only cure for a failed sync: the system may take pages
    /// that it could not write for clean, so that a second sync alone would succeed and mean nothing.
    Result<void> write(std::uint64_t first, std::span<const std::byte> entries);
    /// See `Journal::release`.
    Result<void> release(std::uint64_t number, std::uint64_t keep_bytes);
    [[nodiscard]] const std::vector<JournalSegment>& segments() const { return segments_; }

private:
    Result<void> begin_segment(std::uint64_t first);
    Result<void> write_and_sync(const JournalSegment& segment, std::span<const std::byte> entries);
    JournalPlace place_;
    std::vector<JournalSegment> segments_;
    std::unique_ptr<File> file_;
    bool is_clean_ = true;  ///< nothing lies behind the last entry that counts
};

}  // namespace tilth
