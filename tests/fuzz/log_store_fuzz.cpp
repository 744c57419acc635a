// pages-<n>.tlp: whatever one or two of them hold, the store opens on blobs whose checksums are right, or refuses and
// touches nothing; opening again gives the same, and so does compaction; and it can be worked on.
//
// Bytes that no checksum protects would not come far, so that half of the inputs are the description of a file: frames,
// indexes and superblocks with any numbers in them, sealed properly, and then a little damage.
#include <set>

#include "fuzz/fuzz_input.h"
#include "support/fault_files.h"
#include "tilth/core/hash.h"
#include "tilth/store/log_format.h"
#include "tilth/store/log_store.h"

namespace tilth::fuzz {
namespace {

using namespace log_format;
using test::FaultFiles;

constexpr std::uint64_t kSalt = 0x5a17;
using Disk = std::map<std::string, Bytes>;

/// Writes one file, as the fuzzer says.
class FileMaker {
public:
    FileMaker(Input& input, std::uint64_t number) : input_(input), tag_{kSalt, number} {}

    Bytes run() {
        bytes_ = encode_empty_file(tag_);
        places_ = {{kFirstFrame, kFirstFrame}};
        for (std::size_t frames = input_.below(24); frames > 0 && !input_.empty(); --frames) add_frame();
        for (const unsigned slot : {0u, 1u}) write_superblock(slot);
        append(bytes_, input_.piece(input_.below(100)));
        damage(bytes_, input_);
        return std::move(bytes_);
    }

private:
    struct Place {
        std::uint64_t begin = 0, end = 0;
    };

    BlobKey key() {
        const std::uint8_t which = input_.byte();
        if (which == 255)
            return {static_cast<BlobKind>(1 + input_.below(255)), input_.number<std::int32_t>(),
                    input_.number<std::int32_t>()};
        return {static_cast<BlobKind>(1 + which % 5), which / 5 % 4, 0};
    }
    /// Mostly one where something lies.
    Place place() {
        const std::uint8_t which = input_.byte();
        if (which == 255) return {input_.any_number(), input_.any_number()};
        if (which == 254) return {};
        return places_[which % places_.size()];
    }

    void add_frame() {
        const std::uint8_t how = input_.byte();
        FrameHeader header{.type = static_cast<FrameType>(1 + how % 3), .key = key()};
        Bytes payload;
        if (header.type == FrameType::Blob) payload = copy_of(input_.piece(input_.below(80)));
        if (header.type == FrameType::Index) payload = index();
        header.length = static_cast<std::uint32_t>(payload.size());
        header.payload_hash = hash_bytes(payload);
        if (how >= 240) header.length = input_.number<std::uint32_t>() | 1u << 20;  // more than there is
        if (how % 64 == 63) header.payload_hash ^= 1;
        const std::uint64_t offset = bytes_.size();
        append(bytes_, encode_frame_header(header, tag_, offset));
        append(bytes_, payload);
        places_.push_back({offset, bytes_.size()});
        if (header.type == FrameType::Blob) blobs_.push_back({header.key, {offset, 0, header.length}});
        if (header.type == FrameType::Index) indexes_.push_back({offset, bytes_.size()});
    }

    Bytes index() {
        const std::uint8_t how = input_.byte();
        Index made{.generation = number(how % 2 == 0, ++generation_), .mark = number(how % 4 < 2, generation_ * 3)};
        const Place previous = how % 8 < 4 || indexes_.empty() ? Place{} : how % 8 < 7 ? indexes_.back() : place();
        made.previous = previous.begin, made.previous_end = previous.end;
        if (how >= 64) {  // all blobs so far
            for (const AddedBlob& blob : blobs_) made.added.push_back(blob);
        }
        for (std::size_t added = how / 8 % 4; added > 0; --added)
            made.added.push_back({key(), {place().begin, input_.any_number(), input_.number<std::uint16_t>()}});
        for (std::size_t erased = how / 32 % 2; erased > 0; --erased) made.erased.push_back(key());
        std::set<BlobKey> keys;
        for (const AddedBlob& blob : made.added) keys.insert(blob.key);
        for (const BlobKey& key : made.erased) keys.erase(key);
        last_blobs_ = keys.size();
        last_mark_ = made.mark;
        Bytes payload = encode_index(made);
        if (how == 63) damage(payload, input_);
        return payload;
    }

    void write_superblock(unsigned slot) {
        const std::uint8_t how = input_.byte();
        if (how % 8 == 0) return;  // of generation 0
        const Place at =
            how % 8 == 7 || indexes_.empty() ? place() : indexes_[indexes_.size() - 1 - slot % indexes_.size()];
        const Superblock made{
            .generation = number(how % 16 < 12, generation_ - std::min<std::uint64_t>(generation_, slot)),
            .mark = number(how < 128, last_mark_),
            .index_offset = at.begin,
            .end = commit_end(how >= 240 ? place().end : at.end),
            .blobs = number(how < 192, last_blobs_)};
        std::ranges::copy(encode_superblock(made, tag_, slot),
                          bytes_.begin() + static_cast<std::ptrdiff_t>(superblock_offset(slot)));
    }

    /// Behind the end of a frame or of the file: what a superblock says of its own commit is right when it is sealed.
    std::uint64_t commit_end(std::uint64_t wanted) const {
        const bool is_border = std::ranges::any_of(places_, [&](const Place& place) { return place.end == wanted; });
        return is_border || wanted > bytes_.size() ? wanted : bytes_.size();
    }
    // Half of the range: a generation is one more than the last, and no world comes near the end.
    std::uint64_t number(bool is_right, std::uint64_t right) { return is_right ? right : input_.any_number() / 2; }

    Input& input_;
    FileTag tag_;
    Bytes bytes_;
    std::vector<Place> places_, indexes_;
    std::vector<AddedBlob> blobs_;
    std::uint64_t generation_ = 0, last_blobs_ = 0, last_mark_ = 0;
};

Disk disk_of(Input& input) {
    const std::uint8_t how = input.byte();
    const auto path = [](std::uint64_t number) { return "world/" + file_name(number); };
    Disk disk;
    if (how % 2 == 0) {
        disk[path(1)] = FileMaker(input, 1).run();
        if (how % 4 == 2) disk[path(2)] = FileMaker(input, 2).run();
        if (how >= 128) disk[path(3) + kReplacementEnding] = copy_of(input.rest());
        return disk;
    }
    const std::size_t cut = how % 4 == 1 ? ~std::size_t{0} : input.number<std::uint16_t>();
    disk[path(1)] = copy_of(input.piece(cut));
    if (how % 4 == 3) disk[path(2)] = copy_of(input.rest());
    return disk;
}

Disk content_of(const FaultFiles& files) {
    Disk disk;
    for (const std::string& path : files.paths()) disk[path] = files.bytes(path);
    return disk;
}

/// The blobs that stand in a file with all their checksums right.
std::set<std::pair<BlobKey, Bytes>> blobs_in(const Disk& disk) {
    std::set<std::pair<BlobKey, Bytes>> blobs;
    for (std::uint64_t number = 1; number <= 2; ++number) {
        const auto file = disk.find("world/" + file_name(number));
        if (file == disk.end()) continue;
        const std::span<const std::byte> bytes = file->second;
        for (std::size_t at = 0; at + kFrameHeaderBytes <= bytes.size(); ++at) {
            if (bytes[at] != kFrameMagic[0]) continue;
            const auto header = decode_frame_header(bytes.subspan(at), {kSalt, number}, at);
            if (!header || header->type != FrameType::Blob || header->bytes() > bytes.size() - at) continue;
            const auto payload = bytes.subspan(at + kFrameHeaderBytes, header->length);
            if (hash_bytes(payload) == header->payload_hash) blobs.emplace(header->key, copy_of(payload));
        }
    }
    return blobs;
}

/// All that can be seen of a store; a damaged blob has no bytes.
struct State {
    std::uint64_t mark = 0;
    std::map<BlobKey, std::optional<Bytes>> blobs;
    std::map<BlobKey, std::optional<std::uint64_t>> marks;
    friend bool operator==(const State&, const State&) = default;
};

State state_of(LogStore& store) {
    State state{.mark = store.mark(), .blobs = {}, .marks = {}};
    std::uint64_t bytes = 0;
    for (int kind = 1; kind <= 255; ++kind) {
        const auto keys = store.keys(static_cast<BlobKind>(kind));
        check(keys.ok() && std::ranges::is_sorted(*keys), "keys are listed, sorted");
        for (const BlobKey& key : *keys) {
            check(static_cast<int>(key.kind) == kind, "keys are of the kind that was asked for");
            Result<std::optional<Bytes>> blob = store.get(key);
            check(blob.ok() || (blob.error().code == ErrorCode::FileFormat &&
                                blob.error().message.find(": at byte ") != std::string::npos),
                  "a blob is got, or damaged, with the place");
            check(!blob.ok() || blob->has_value(), "what is listed is there");
            state.blobs[key] = blob.ok() ? *std::move(blob) : std::nullopt;
            state.marks[key] = store.mark_of(key);
            bytes += state.blobs[key].value_or(Bytes()).size();
        }
    }
    check(bytes <= store.size().live_bytes, "live bytes count what can be got");
    return state;
}

std::unique_ptr<LogStore> reopen(FileSystem& files, LogStoreReport& report) {
    auto store = LogStore::open(files, "world", kSalt, {.most_waste = 0, .least_waste_bytes = 0}, report);
    check(store.ok(), "what was opened once opens again");
    check(report.truncated_bytes == 0, "a tail is cut off once");
    return *std::move(store);
}

void run(Input input) {
    const Disk disk = disk_of(input);
    FaultFiles files;
    check(files.make_folder("world").ok() && files.sync_folder("").ok(), "the disk works");
    std::size_t most = 1u << 16;  // a window of a scan
    for (const auto& [path, content] : disk) files.set_bytes(path, content), most = std::max(most, content.size());

    LogStoreReport report;
    auto opened = LogStore::open(files, "world", kSalt, {}, report);
    check(files.counts().most_read_bytes <= most, "reads are no larger than the file");
    if (!opened) {
        check(opened.error().code == ErrorCode::FileFormat, "the files are to blame");
        check(opened.error().message.find("world/") != std::string::npos, "an error says where");
        check(content_of(files) == disk, "what is refused is not touched");
        return;
    }
    const State found = state_of(**opened);
    const auto written = blobs_in(disk);
    for (const auto& [key, blob] : found.blobs)
        check(!blob || written.contains({key, *blob}), "a blob that is got stands in a file, under its key");
    check(files.counts().most_read_bytes <= most, "reads are no larger than the file");
    opened->reset();
    // A crash right now changes nothing of what was seen.
    const std::unique_ptr<FaultFiles> after = files.crash(input.byte());
    check(state_of(*reopen(*after, report)) == found, "what was seen survives a crash");
    auto store = reopen(files, report);
    check(state_of(*store) == found, "opening again gives the same");

    // It can be worked on, and is in order then.
    const BlobKey key{static_cast<BlobKind>(1 + input.below(5)), static_cast<std::int32_t>(input.below(4)), 0};
    const Bytes bytes(1 + input.below(100));
    State expected = found;
    if (!found.blobs.empty()) {
        const BlobKey gone = found.blobs.begin()->first;
        check(store->erase(gone).ok(), "blobs can be erased");
        expected.blobs.erase(gone), expected.marks.erase(gone);
    }
    check(store->put(key, bytes).ok(), "blobs can be put");
    expected.mark = found.mark + 1;
    check(store->commit(expected.mark).ok(), "and committed");
    expected.blobs[key] = bytes, expected.marks[key] = store->mark_of(key);
    check(state_of(*store) == expected, "what was put is seen");
    store = reopen(files, report);
    check(state_of(*store) == expected, "what was committed is there");
    check(!report.was_scanned && !report.may_miss_blobs, "a commit makes the index good");

    for (int steps = 0;; ++steps) {
        const Result<bool> more = store->compact(1000);
        check(more.ok(), "it can be compacted");
        if (!*more) break;
        check(steps < 10'000, "compaction ends");
    }
    check(state_of(*store) == expected, "compaction changes nothing");
    check(state_of(*reopen(files, report)) == expected, "nor for the one who opens it then");
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
