#include "tilth/store/log_recovery.h"

#include <algorithm>
#include <array>

#include "tilth/core/hash.h"

namespace tilth {

using namespace log_format;

namespace {

constexpr std::uint64_t kUnknownCount = ~std::uint64_t{0};
using Slots = std::array<std::optional<Superblock>, 2>;

Result<HeaderState> read_header_state(LogFile& log) {
    HeaderBytes bytes;
    const Result<std::size_t> count = log.read(0, bytes);
    if (!count) return count.error();
    const HeaderState state = check_header(std::span(bytes).first(*count), log.tag());
    if (state == HeaderState::Newer)
        return Error{ErrorCode::FileFormat,
                     text(log.path(), ": is of a newer version than ", kVersion, ": open it with a newer build")};
    if (state == HeaderState::OtherWorld)
        return Error{ErrorCode::FileFormat, text(log.path(),
                                                 ": belongs to another world, or is another of its files: "
                                                 "put the right file there, or take this one away")};
    return state;
}

Result<Slots> read_slots(LogFile& log) {
    Slots slots;
    for (const unsigned slot : {0u, 1u}) {
        SuperblockBytes bytes;
        const Result<std::size_t> count = log.read(superblock_offset(slot), bytes);
        if (!count) return count.error();
        slots[slot] = decode_superblock(std::span(bytes).first(*count), log.tag(), slot);
    }
    return slots;
}

/// A superblock that is not sound was being written, or is damaged now. Either way its commit was durable before: the
/// last sound index counts, also behind damaged bytes, which then are of blobs that are damaged or lost.
Result<void> roll_forward(LogFile& log, RecoveredLog& found) {
    Superblock& commit = found.commit;
    if (commit.end < kFirstFrame || commit.end > log.end()) return {};
    const std::uint64_t tail_begin = commit.end;
    const Result<LogScan> tail = scan_log(log, tail_begin);
    if (!tail) return tail.error();
    std::uint64_t first_damage = tail->gaps.empty() ? log.end() : tail->gaps.front().begin;
    for (const FoundFrame& frame : tail->frames) {
        if (!frame.is_sound) first_damage = std::min(first_damage, frame.offset);
        if (frame.header.type != FrameType::Index || !frame.is_sound) continue;
        const Result<std::optional<Index>> index = read_index(log, frame.offset);
        if (!index) return index.error();
        if (!*index || (*index)->generation <= commit.generation) continue;
        commit = {.generation = (*index)->generation,
                  .mark = (*index)->mark,
                  .index_offset = frame.offset,
                  .end = frame.end(),
                  .blobs = kUnknownCount};
    }
    if (commit.end > tail_begin && first_damage < commit.end) {
        found.is_past_damage = true;
        found.damage.push_back(
            {ErrorCode::FileFormat, text(log.path(), ": at byte ", first_damage, ": bytes of the last save, of mark ",
                                         commit.mark, ", are damaged, and so is its superblock at byte ",
                                         superblock_offset(found.slot ^ 1), "; it was found by its index at byte ",
                                         commit.index_offset, ": what lies elsewhere is as it was saved")});
    }
    return {};
}

void apply_index(const Index& index, std::map<BlobKey, Entry>& blobs) {
    for (const AddedBlob& added : index.added) blobs[added.key] = added.entry;
    for (const BlobKey& key : index.erased) blobs.erase(key);
}

/// Follows the chain of indexes back. False: one of them is damaged.
Result<bool> read_chain(LogFile& log, RecoveredLog& found) {
    if (found.commit.index_offset < kFirstFrame || found.commit.end > log.end()) return false;
    std::vector<Index> indexes;  // their frames do not overlap, so that together they are no larger than the file
    std::uint64_t expected_end = found.commit.end;
    for (std::uint64_t at = found.commit.index_offset; at != 0;) {
        std::uint64_t end = 0;
        Result<std::optional<Index>> index = read_index(log, at, &end);
        if (!index) return index.error();
        if (!*index || end != expected_end) return false;
        LogRun run{at, end, {}};
        run.keys = (*index)->erased;
        for (const AddedBlob& added : (*index)->added) run.keys.push_back(added.key);
        found.runs.push_back(std::move(run));
        at = (*index)->previous, expected_end = (*index)->previous_end;
        indexes.push_back(*std::move(*index));
    }
    std::ranges::reverse(found.runs);
    for (auto index = indexes.rbegin(); index != indexes.rend(); ++index) apply_index(*index, found.blobs);
    if (found.commit.blobs == kUnknownCount) found.commit.blobs = found.blobs.size();
    return found.commit.blobs == found.blobs.size();
}

}  // namespace

Result<std::optional<Index>> read_index(LogFile& log, std::uint64_t offset, std::uint64_t* end) {
    const Result<std::optional<FrameHeader>> header = log.read_frame_header(offset);
    if (!header) return header.error();
    if (!*header || (*header)->type != FrameType::Index || (*header)->bytes() > log.end() - offset)
        return std::optional<Index>{};
    std::vector<std::byte> payload((*header)->length);
    const Result<std::size_t> count = log.read(offset + kFrameHeaderBytes, payload);
    if (!count) return count.error();
    if (*count != payload.size() || hash_bytes(payload) != (*header)->payload_hash) return std::optional<Index>{};
    if (end != nullptr) *end = offset + (*header)->bytes();
    return decode_index(payload, offset);
}

Result<RecoveredLog> recover_log(LogFile& log) {
    const Result<HeaderState> header = read_header_state(log);
    if (!header) return header.error();
    const Result<Slots> slots = read_slots(log);
    if (!slots) return slots.error();

    RecoveredLog found;
    found.is_header_damaged = *header != HeaderState::Good;
    if (found.is_header_damaged)
        found.damage.push_back({ErrorCode::FileFormat, text(log.path(),
                                                            ": at byte 0: the header is damaged; it is "
                                                            "written again with the next save")});
    const auto& [first, second] = *slots;
    if (first && second) {
        const bool is_second = second->generation > first->generation;
        found.commit = is_second ? *second : *first;
        found.slot = is_second ? 1 : 0;
    } else if (first || second) {
        found.commit = first ? *first : *second;
        found.slot = first ? 0 : 1;
        const std::uint64_t before = found.commit.generation;
        if (Result<void> done = roll_forward(log, found); !done) return done.error();
        found.is_other_damaged = found.commit.generation == before;
        if (found.is_other_damaged)
            found.damage.push_back({ErrorCode::FileFormat,
                                    text(log.path(), ": at byte ", superblock_offset(found.slot ^ 1),
                                         ": a superblock is damaged; if it was the newer one, the last save is lost")});
        else
            found.slot ^= 1;
    }
    found.generation = found.commit.generation;

    // As it is born. With a damaged superblock there may have been a commit, and what it had may lie behind.
    if (found.commit.generation == 0 && first && second && log.end() >= kFirstFrame) return found;
    if (found.commit.generation != 0) {
        const Result<bool> is_whole = read_chain(log, found);
        if (!is_whole) return is_whole.error();
        if (*is_whole) return found;
    }
    found.runs.clear();
    found.blobs.clear();
    if (Result<void> done = recover_by_scan(log, found); !done) return done.error();
    if (found.commit.blobs == kUnknownCount) found.commit.blobs = found.blobs.size();
    if (found.is_wreck && *header == HeaderState::Foreign)
        return Error{ErrorCode::FileFormat, text(log.path(),
                                                 ": at byte 0: is no file of ours, or damaged beyond "
                                                 "recognition: take it away, or put a copy of it there")};
    return found;
}

}  // namespace tilth
