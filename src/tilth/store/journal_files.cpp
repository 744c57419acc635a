#include "tilth/store/journal_files.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"

namespace tilth {
namespace {

constexpr std::string_view kPrefix = "journal-", kSuffix = ".tlj";
constexpr std::size_t kDigits = 20;                   // of the largest 64-bit number: names sort as numbers do
constexpr std::uint64_t kLargestNumber = 1ull << 57;  // offsets stay below 2^63
constexpr std::size_t kBlockEntries = 1024;           // 64 KiB at a time

constexpr std::uint64_t kMagic = magic_of("TILTH-J\n");
constexpr std::uint32_t kVersion = 1;
enum Place : std::size_t {
    kMagicAt = 0,
    kVersionAt = 8,
    kSaltAt = 16,
    kFirstAt = 24,
    kChecksumAt = 56,
};

/// Segments are closed when they have this share of what is to be kept: few files, and none that is much too old.
constexpr std::uint64_t kLeastShare = 16;

}  // namespace

std::uint64_t JournalSegment::bytes() const { return offset_of_entry(first, end()); }

std::string JournalPlace::path(std::uint64_t first) const { return folder + "/" + name_of_segment(first); }

std::string name_of_segment(std::uint64_t first) {
    const std::string digits = std::to_string(first);
    return std::string(kPrefix) + std::string(kDigits - digits.size(), '0') + digits + std::string(kSuffix);
}

std::optional<std::uint64_t> number_of_segment(std::string_view name) {
    if (name.size() != kPrefix.size() + kDigits + kSuffix.size()) return std::nullopt;
    if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) return std::nullopt;
    const std::string_view digits = name.substr(kPrefix.size(), kDigits);
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
    if (number == 0 || number > kLargestNumber) return std::nullopt;
    return number;
}

JournalHeader encode_journal_header(std::uint64_t first, std::uint64_t salt) {
    JournalHeader header{};
    put_field(header, kMagicAt, kMagic);
    put_field(header, kVersionAt, kVersion);
    put_field(header, kSaltAt, salt);
    put_field(header, kFirstAt, first);
    put_field(header, kChecksumAt, hash_bytes(std::span(header).first(kChecksumAt)));
    return header;
}

Result<bool> check_journal_header(std::span<const std::byte> bytes, std::uint64_t first, std::uint64_t salt,
                                  std::string_view path) {
    if (bytes.size() < kJournalHeaderBytes || get_field<std::uint64_t>(bytes, kMagicAt) != kMagic) return false;
    if (get_field<std::uint64_t>(bytes, kChecksumAt) != hash_bytes(bytes.first(kChecksumAt))) return false;
    if (const auto version = get_field<std::uint32_t>(bytes, kVersionAt); version != kVersion)
        return Error{ErrorCode::FileFormat, text(path, ": is of version ", version, ", this build reads ", kVersion,
                                                 "; open the world with a newer tilth")};
    if (get_field<std::uint64_t>(bytes, kSaltAt) != salt)
        return Error{ErrorCode::FileFormat, text(path, ": belongs to another world; move it out of this folder")};
    if (const auto begins = get_field<std::uint64_t>(bytes, kFirstAt); begins != first)
        return Error{ErrorCode::FileFormat, text(path, ": begins with edit ", begins, "; rename it to ",
                                                 name_of_segment(begins), ", or move it out of this folder")};
    return true;
}

Result<std::optional<Edit>> EntryReader::at(std::uint64_t number) {
    if (number < block_begin_ || number >= block_end_) {
        block_.resize(kBlockEntries * kJournalEntryBytes);
        const Result<std::size_t> read = file_->read(offset_of_entry(first_, number), block_);
        if (!read) return read.error();
        block_begin_ = number;
        block_end_ = number + *read / kJournalEntryBytes;
        if (number >= block_end_) return std::optional<Edit>();
    }
    const std::span<const std::byte> bytes = block_;
    const std::size_t at = (number - block_begin_) * kJournalEntryBytes;
    return decode_entry(bytes.subspan(at).first<kJournalEntryBytes>(), number, salt_);
}

Result<void> JournalWriter::begin_segment(std::uint64_t first) {
    Result<std::unique_ptr<File>> made = place_.files->open(place_.path(first), OpenMode::Create);
    if (!made) return made.error();
    const JournalHeader header = encode_journal_header(first, place_.salt);
    if (const Result<void> written = (*made)->write(0, header); !written) return written;  // next time: the same again
    file_ = *std::move(made);
    segments_.push_back({.first = first, .count = 0});
    return {};
}

Result<void> JournalWriter::write(std::uint64_t first, std::span<const std::byte> entries) {
    if (file_ == nullptr)
        if (const Result<void> begun = begin_segment(first); !begun) return begun;
    JournalSegment& segment = segments_.back();
    TILTH_ASSERT(segment.end() == first, "entries of a journal out of order");
    const Result<void> written = write_and_sync(segment, entries);
    is_clean_ = written.ok();
    if (written) {
        segment.count += entries.size() / kJournalEntryBytes;
    } else if (segment.count == 0) {  // its header is to be written again as well
        file_.reset();
        segments_.pop_back();
    }
    return written;
}

Result<void> JournalWriter::write_and_sync(const JournalSegment& segment, std::span<const std::byte> entries) {
    if (const Result<void> written = file_->write(segment.bytes(), entries); !written) return written;
    if (const Result<void> synced = file_->sync(); !synced) return synced;
    return segment.count == 0 ? place_.files->sync_folder(place_.folder) : Result<void>();
}

Result<void> JournalWriter::release(std::uint64_t number, std::uint64_t keep_bytes) {
    // A file with something half-written behind its end stays the last one, or that would lie in the middle.
    if (file_ != nullptr && is_clean_ && segments_.back().count > 0 &&
        segments_.back().bytes() > keep_bytes / kLeastShare)
        file_.reset();
    const std::size_t last = file_ == nullptr ? segments_.size() : segments_.size() - 1;
    std::uint64_t old_bytes = 0;
    for (std::size_t i = 0; i < last; ++i) old_bytes += segments_[i].bytes();
    std::size_t gone = 0;
    Result<void> outcome;
    while (gone < last && old_bytes > keep_bytes && segments_[gone].end() <= number + 1) {
        outcome = place_.files->remove(place_.path(segments_[gone].first));
        if (!outcome) break;
        old_bytes -= segments_[gone++].bytes();
    }
    if (gone == 0) return outcome;
    segments_.erase(segments_.begin(), segments_.begin() + static_cast<std::ptrdiff_t>(gone));
    const Result<void> synced = place_.files->sync_folder(place_.folder);
    return outcome ? synced : outcome;
}

}  // namespace tilth
