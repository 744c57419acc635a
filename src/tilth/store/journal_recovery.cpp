#include "tilth/store/journal_recovery.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace tilth {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
constexpr std::size_t kCopyBytes = 1u << 16;

struct FoundSegment {
    std::uint64_t first = 1;
    std::string path;
    std::unique_ptr<File> file;
    std::uint64_t bytes = 0;
    bool has_header = false;

    /// One more than the last edit that the file has room for, good or not.
    [[nodiscard]] std::uint64_t end() const {
        return bytes <= kJournalHeaderBytes ? first : first + (bytes - kJournalHeaderBytes) / kJournalEntryBytes;
    }
};

class Recovery {
public:
    Recovery(const JournalPlace& place, std::uint64_t from, JournalReport& report, std::vector<Edit>& tail)
        : place_(place), from_(from), report_(report), tail_(tail) {}

    Result<RecoveredJournal> run() {
        if (const Result<void> found = find_segments(); !found) return found.error();
        if (const Result<void> read = read_wanted(); !read) return read.error();
        const Result<bool> goes_on = something_follows();
        if (!goes_on) return goes_on.error();
        const Result<void> cut = *goes_on ? move_rest_aside() : cut_torn_tail();
        if (!cut) return cut.error();
        return make_durable();
    }

private:
    Result<void> find_segments();
    Result<void> read_wanted();
    Result<bool> something_follows();
    Result<void> cut_torn_tail();
    Result<void> move_rest_aside();
    Result<void> copy_aside(const FoundSegment& segment, std::uint64_t number);
    Result<RecoveredJournal> make_durable();
    [[nodiscard]] std::string free_name(std::uint64_t number) const;
    [[nodiscard]] Error damage_at_end() const;
    /// One more than the last edit that can be in it.
    [[nodiscard]] std::uint64_t limit(std::size_t i) const {
        return i + 1 < found_.size() ? found_[i + 1].first : kNoLimit;
    }
    /// The segment in which the good entries end; nullptr: there is none, or the first begins too late.
    [[nodiscard]] FoundSegment* last() { return kept_ == 0 ? nullptr : &found_[kept_ - 1]; }

    const JournalPlace& place_;
    const std::uint64_t from_;
    JournalReport& report_;
    std::vector<Edit>& tail_;
    std::vector<FoundSegment> found_;
    std::size_t kept_ = 0;    ///< the first so many of them are good
    std::uint64_t next_ = 1;  ///< the first edit that is not there
};

Result<void> Recovery::find_segments() {
    const Result<std::vector<std::string>> names = place_.files->list(place_.folder);
    if (!names) return names.error();
    for (const std::string& name : *names) {
        const std::optional<std::uint64_t> first = number_of_segment(name);
        if (!first) continue;
        FoundSegment segment{.first = *first, .path = place_.path(*first), .file = nullptr};
        Result<std::unique_ptr<File>> file = place_.files->open(segment.path, OpenMode::Read);
        if (!file) return file.error();
        segment.file = *std::move(file);
        const Result<std::uint64_t> size = segment.file->size();
        if (!size) return size.error();
        segment.bytes = *size;
        JournalHeader bytes{};
        const Result<std::size_t> read = segment.file->read(0, bytes);
        if (!read) return read.error();
        const Result<bool> checked =
            check_journal_header(std::span(bytes).first(*read), segment.first, place_.salt, segment.path);
        if (!checked) return checked.error();
        segment.has_header = *checked;
        found_.push_back(std::move(segment));
    }
    std::sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    return {};
}

// From the first wanted edit on, through all segments, up to the first that is not there.
Result<void> Recovery::read_wanted() {
    next_ = from_ + 1;
    while (kept_ < found_.size() && found_[kept_].first <= next_) ++kept_;
    if (kept_ == 0) return {};
    while (true) {
        EntryReader reader(*last()->file, last()->first, place_.salt);
        for (; next_ < limit(kept_ - 1); ++next_) {
            Result<std::optional<Edit>> entry = reader.at(next_);
            if (!entry) return entry.error();
            if (!*entry) return {};
            tail_.push_back(**entry);
        }
        ++kept_;
    }
}

Result<bool> Recovery::something_follows() {
    for (std::size_t i = kept_; i < found_.size(); ++i)
        if (found_[i].has_header) return true;
    for (std::size_t i = kept_ == 0 ? 0 : kept_ - 1; i < found_.size(); ++i) {
        EntryReader reader(*found_[i].file, found_[i].first, place_.salt);
        const std::uint64_t end = std::min(found_[i].end(), limit(i));
        for (std::uint64_t number = std::max(found_[i].first, next_); number < end; ++number) {
            const Result<std::optional<Edit>> entry = reader.at(number);
            if (!entry) return entry.error();
            if (*entry) return true;
        }
    }
    return false;
}

Result<void> Recovery::cut_torn_tail() {
    for (; found_.size() > kept_; found_.pop_back()) {
        report_.truncated_bytes += found_.back().bytes;
        if (const Result<void> removed = place_.files->remove(found_.back().path); !removed) return removed;
    }
    if (last() == nullptr) return {};
    if (last()->end() < next_ && last()->end() > last()->first && next_ == from_ + 1)
        report_.damage.push_back({ErrorCode::FileFormat,
                                  text(last()->path, ": offset ", last()->bytes, ": ends with edit ", last()->end() - 1,
                                       "; edits up to ", from_, " are missing, which the pages hold")});
    const std::uint64_t good = offset_of_entry(last()->first, next_);
    if (last()->bytes <= good) return {};
    report_.truncated_bytes += last()->bytes - good;
    Result<std::unique_ptr<File>> file = place_.files->open(last()->path, OpenMode::Write);
    if (!file) return file.error();
    last()->bytes = good;
    return (*file)->truncate(good);
}

Error Recovery::damage_at_end() const {
    const std::string aside = "; what lies behind was moved aside, to *.damaged, and is not used";
    if (kept_ == 0)
        return {ErrorCode::FileFormat, text(found_[0].path, ": offset 0: begins with edit ", found_[0].first,
                                            "; edits ", next_, " to ", found_[0].first - 1, " are missing", aside)};
    const FoundSegment& segment = found_[kept_ - 1];
    return {ErrorCode::FileFormat, text(segment.path, ": offset ", offset_of_entry(segment.first, next_), ": edit ",
                                        next_, next_ < segment.end() ? " is damaged" : " is missing", aside)};
}

// In an order in which a crash leaves damage that is found again: copies first, the cut last.
Result<void> Recovery::move_rest_aside() {
    report_.damage.push_back(damage_at_end());
    FoundSegment* const segment = last();
    const bool has_rest = segment != nullptr && segment->bytes > offset_of_entry(segment->first, next_);
    const bool is_all_rest = has_rest && segment->first == next_;
    if (is_all_rest) --kept_;
    if (has_rest && !is_all_rest)
        if (const Result<void> copied = copy_aside(*segment, next_); !copied) return copied;
    for (; found_.size() > kept_; found_.pop_back()) {
        const std::string aside = free_name(found_.back().first);
        if (const Result<void> moved = place_.files->rename(found_.back().path, aside); !moved) return moved;
    }
    if (const Result<void> synced = place_.files->sync_folder(place_.folder); !synced) return synced;
    if (!has_rest || is_all_rest) return {};
    Result<std::unique_ptr<File>> file = place_.files->open(segment->path, OpenMode::Write);
    if (!file) return file.error();
    segment->bytes = offset_of_entry(segment->first, next_);
    return (*file)->truncate(segment->bytes);
}

/// Never one that exists: nothing that was moved aside is replaced.
std::string Recovery::free_name(std::uint64_t number) const {
    std::string name = place_.path(number) + ".damaged";
    for (int i = 2; place_.files->exists(name); ++i) name = text(place_.path(number), ".damaged-", i);
    return name;
}

/// The entries from `number` on, behind a header of their own.
Result<void> Recovery::copy_aside(const FoundSegment& segment, std::uint64_t number) {
    Result<std::unique_ptr<File>> to = place_.files->open(free_name(number), OpenMode::Create);
    if (!to) return to.error();
    if (const Result<void> written = (*to)->write(0, encode_journal_header(number, place_.salt)); !written)
        return written;
    std::vector<std::byte> block(kCopyBytes);
    const std::uint64_t from = offset_of_entry(segment.first, number);
    for (std::uint64_t at = from; at < segment.bytes;) {
        const Result<std::size_t> read = segment.file->read(at, block);
        if (!read) return read.error();
        if (*read == 0) break;
        const Result<void> written = (*to)->write(kJournalHeaderBytes + (at - from), std::span(block).first(*read));
        if (!written) return written;
        at += *read;
    }
    return (*to)->sync();
}

// What was read may never have reached the disk (a process that died before its sync, or whose sync failed): it is
// written and synced again before it counts. Only the last segment can be so.
Result<RecoveredJournal> Recovery::make_durable() {
    RecoveredJournal recovered{.segments = {}, .tail = nullptr, .last = next_ - 1};
    for (std::size_t i = 0; i < kept_; ++i) {
        FoundSegment& found = found_[i];
        const std::uint64_t end = std::min(found.end(), limit(i));
        if (end == found.first) {  // nothing in it: begun, and then the process ended
            if (const Result<void> removed = place_.files->remove(found.path); !removed) return removed.error();
            continue;
        }
        recovered.segments.push_back({.first = found.first, .count = end - found.first});
        const bool is_last = i + 1 == kept_;
        if (found.has_header && !is_last) continue;
        Result<std::unique_ptr<File>> file = place_.files->open(found.path, OpenMode::Write);
        if (!file) return file.error();
        if (!found.has_header)
            report_.damage.push_back(
                {ErrorCode::FileFormat,
                 text(found.path, ": offset 0: the header is damaged; it was written again, no edit is lost")});
        if (const Result<void> written = (*file)->write(0, encode_journal_header(found.first, place_.salt)); !written)
            return written.error();
        std::vector<std::byte> block;
        const std::uint64_t begin = std::max(found.first, from_ + 1);
        for (std::uint64_t number = begin; is_last && number < next_; ++number) {
            const JournalBytes entry = encode_entry(tail_[number - from_ - 1], number, place_.salt);
            block.insert(block.end(), entry.begin(), entry.end());
            if (block.size() < kCopyBytes && number + 1 < next_) continue;
            const std::uint64_t at = offset_of_entry(found.first, number + 1) - block.size();
            if (const Result<void> written = (*file)->write(at, block); !written) return written.error();
            block.clear();
        }
        if (const Result<void> synced = (*file)->sync(); !synced) return synced.error();
        if (is_last && end == next_) recovered.tail = *std::move(file);
    }
    if (const Result<void> synced = place_.files->sync_folder(place_.folder); !synced) return synced.error();
    return recovered;
}

}  // namespace

Result<RecoveredJournal> recover_journal(const JournalPlace& place, std::uint64_t from, JournalReport& report,
                                         std::vector<Edit>& tail) {
    report = {};
    tail.clear();
    return Recovery(place, from, report, tail).run();
}

}  // namespace tilth
