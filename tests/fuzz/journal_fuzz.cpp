// A journal's folder: whatever its files hold, it opens on edits that stand in them, or refuses and touches nothing;
// and it goes on from there.
#include "fuzz/fuzz_input.h"
#include "support/fault_files.h"
#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"
#include "tilth/store/journal.h"
#include "tilth/store/journal_files.h"

namespace tilth::fuzz {
namespace {

using test::FaultFiles;

constexpr std::uint64_t kSalt = 0x5a17;
constexpr FlushPolicy kManual{.when = FlushPolicy::When::Manual};
using Disk = std::map<std::string, Bytes>;

Edit edit_of(std::uint8_t kind, std::uint64_t number) {
    Edit edit{.kind = static_cast<EditKind>(kind % 3), .begins_stroke = kind % 2 == 0, .record = {}};
    edit.record.sequence = number;
    if (edit.kind == EditKind::Stamp) edit.record.radius = kind;
    return edit;
}

Bytes header_of(Input& input, std::uint64_t first) {
    const std::uint8_t how = input.byte();
    Bytes header = copy_of(encode_journal_header(first, kSalt));
    switch (how % 16) {
        case 0:
            return Bytes(kJournalHeaderBytes);
        case 1:
            return copy_of(input.piece(kJournalHeaderBytes));
        case 2:
            return copy_of(encode_journal_header(first + 1, kSalt));
        case 3:
            return copy_of(encode_journal_header(first, kSalt + 1));
        case 4:  // of another version
            put_field(header, 8, std::uint32_t{input.byte()});
            put_field(header, 56, hash_bytes(std::span(header).first(56)));
            return header;
        default:
            return header;
    }
}

/// A segment in good order, with what the fuzzer makes of it.
void add_segment(Disk& disk, Input& input, std::uint64_t first) {
    Bytes bytes = header_of(input, first);
    std::uint64_t number = first;
    for (std::size_t runs = input.below(6); runs > 0; --runs) {
        const std::uint8_t how = input.byte(), count = input.byte() % 24;
        for (int i = 0; i < count; ++i, ++number) {
            const Edit edit = edit_of(static_cast<std::uint8_t>(how / 4), number);
            if (how % 4 == 0)
                append(bytes, repeated(input.piece(4), kJournalEntryBytes));
            else
                append(bytes, encode_entry(edit, how % 4 == 1 ? number + 1 : number, kSalt));
        }
    }
    append(bytes, input.piece(input.below(130)));
    damage(bytes, input);
    disk["world/" + name_of_segment(first)] = bytes;
}

Disk disk_of(Input& input, std::uint64_t& from) {
    Disk disk;
    const bool is_raw = input.flag();
    from = input.flag() ? input.any_number() % (1ull << 57) : input.byte();
    if (is_raw) {
        const std::size_t cut = input.number<std::uint16_t>();
        const std::uint64_t second = 2 + input.below(200);
        disk["world/" + name_of_segment(1)] = copy_of(input.piece(cut));
        if (!input.empty()) disk["world/" + name_of_segment(second)] = copy_of(input.rest());
        return disk;
    }
    std::uint64_t first = 1;
    for (std::size_t segments = 1 + input.below(4); segments > 0; --segments) {
        const std::uint8_t gap = input.byte();
        first += gap == 255 ? input.any_number() % (1ull << 56) : gap % 64;
        if (first <= 1ull << 57) add_segment(disk, input, first);
        first += 1;
    }
    return disk;
}

Disk content_of(const FaultFiles& files) {
    Disk disk;
    for (const std::string& path : files.paths()) disk[path] = files.bytes(path);
    return disk;
}

/// Edit `number` stands, sealed, at its place in the segment that should have it.
void check_written(const Disk& disk, const Edit& edit, std::uint64_t number) {
    auto segment = disk.upper_bound("world/" + name_of_segment(number));
    check(segment != disk.begin(), "an edit comes out of a segment");
    --segment;
    const std::uint64_t first = *number_of_segment(segment->first.substr(6));
    const std::uint64_t at = offset_of_entry(first, number);
    check(at + kJournalEntryBytes <= segment->second.size(), "an edit comes out of its file");
    const JournalBytes bytes = encode_entry(edit, number, kSalt);
    check(std::memcmp(bytes.data(), segment->second.data() + at, bytes.size()) == 0, "an edit is what its bytes say");
}

/// A segment goes on behind the beginning of the next one. No journal writes such, and what is found in them the second
/// time may be more: the next one may have been empty, and removed.
bool is_overlapping(const Disk& disk) {
    std::uint64_t end = 0;
    for (const auto& [path, bytes] : disk) {
        const std::uint64_t first = *number_of_segment(path.substr(6));
        if (first < end) return true;
        end = bytes.size() < kJournalHeaderBytes ? first
                                                 : first + bytes.size() / kJournalEntryBytes - 1;  // less the header
    }
    return false;
}

/// A good entry stands where edit `number`, or a later one, belongs.
bool has_entry_from(const Disk& disk, std::uint64_t number) {
    for (const auto& [path, bytes] : disk) {
        const std::uint64_t first = *number_of_segment(path.substr(6));
        for (std::uint64_t at = kJournalHeaderBytes; at + kJournalEntryBytes <= bytes.size();
             at += kJournalEntryBytes) {
            const std::uint64_t here = first + at / kJournalEntryBytes - 1;
            const auto entry = std::span(bytes).subspan(at).first<kJournalEntryBytes>();
            if (here >= number && decode_entry(entry, here, kSalt)) return true;
        }
    }
    return false;
}

struct Opened {
    std::unique_ptr<Journal> journal;
    JournalReport report;
    std::vector<Edit> tail;
};

Opened reopen(FaultFiles& files, std::uint64_t from) {
    Opened opened;
    auto journal = Journal::open(files, "world", kSalt, from, kManual, opened.report, opened.tail);
    check(journal.ok(), "what was opened once opens again");
    opened.journal = *std::move(journal);
    check(opened.journal->appended() == from + opened.tail.size(), "the tail is what there is");
    check(opened.journal->durable() == opened.journal->appended(), "what is handed out is durable");
    return opened;
}

void run(Input input) {
    std::uint64_t from = 0;
    const Disk disk = disk_of(input, from);
    FaultFiles files;
    check(files.make_folder("world").ok() && files.sync_folder("").ok(), "the disk works");
    std::uint64_t bytes = 0;
    for (const auto& [path, content] : disk) files.set_bytes(path, content), bytes += content.size();

    Opened first;
    {
        auto journal = Journal::open(files, "world", kSalt, from, kManual, first.report, first.tail);
        check(files.counts().most_read_bytes <= 1u << 16, "reads are no larger than a block");
        if (!journal) {
            check(journal.error().code == ErrorCode::FileFormat, "the files are to blame");
            check(journal.error().message.find("world/") != std::string::npos, "an error says where");
            check(content_of(files) == disk, "what is refused is not touched");
            return;
        }
        first.journal = *std::move(journal);
    }
    check(first.journal->appended() == from + first.tail.size(), "the tail is what there is");
    check(first.report.truncated_bytes <= bytes, "no more is cut off than there was");
    for (std::size_t i = 0; i < first.tail.size(); ++i) check_written(disk, first.tail[i], from + 1 + i);
    if (is_overlapping(disk)) return;
    check(!first.report.damage.empty() || !has_entry_from(disk, from + first.tail.size() + 1),
          "what is cut off in silence has no entry");

    // A crash right now changes nothing of what was handed out.
    const std::unique_ptr<FaultFiles> after = files.crash(input.byte());
    check(reopen(*after, from).tail == first.tail, "what was handed out survives a crash");

    const std::uint64_t last = first.journal->appended(), begin = first.journal->first();
    check(begin <= last + 1, "the first edit is not behind the last");
    if (begin <= last && last - begin < 10'000) {
        const Result<std::vector<Edit>> read = first.journal->read(begin, last);
        check(read ? read->size() == last - begin + 1 : read.error().code == ErrorCode::FileFormat, "read, or damaged");
        check(read.ok() || begin <= from, "what was looked at is good");
    }
    for (std::uint8_t i = 0; i < 2; ++i)
        check(first.journal->append(edit_of(i, last + 1 + i)) == last + 1 + i, "numbers go on");
    check(first.journal->flush().ok(), "it goes on");
    first.journal.reset();

    const Opened again = reopen(files, from);
    check(again.tail.size() == first.tail.size() + 2, "what was appended is there");
    check(std::equal(first.tail.begin(), first.tail.end(), again.tail.begin()), "and what was before");
    for (std::uint8_t i = 0; i < 2; ++i)
        check(again.tail[first.tail.size() + i] == edit_of(i, last + 1 + i), "as it was appended");
    check(again.report.damage.empty() && again.report.truncated_bytes == 0, "damage is found once");
    check(again.journal->release(last + 2, 0).ok(), "old files can go");
    check(again.journal->append(edit_of(0, 0)) == last + 3 && again.journal->flush().ok(), "and it goes on");
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
