// Reading a log from end to end: what is done where its index is damaged.
#include <algorithm>

#include "tilth/core/hash.h"
#include "tilth/store/log_recovery.h"

namespace tilth {

using namespace log_format;

namespace {

constexpr std::size_t kWindowBytes = 64u << 10;

/// The next place from `at` on where a frame's header is sound; the file's end where there is none.
Result<std::uint64_t> find_frame(LogFile& log, std::uint64_t at) {
    std::vector<std::byte> window(kWindowBytes);
    while (at < log.end()) {
        const Result<std::size_t> count = log.read(at, window);
        if (!count) return count.error();
        const std::span<const std::byte> bytes = std::span(window).first(*count);
        if (bytes.size() < kFrameHeaderBytes) break;
        const std::size_t starts = bytes.size() - kFrameHeaderBytes + 1;
        for (std::size_t i = 0; i < starts; ++i)
            if (bytes[i] == kFrameMagic[0] && decode_frame_header(bytes.subspan(i), log.tag(), at + i)) return at + i;
        at += starts;
    }
    return log.end();
}

Result<bool> is_payload_sound(LogFile& log, const FrameHeader& header, std::uint64_t offset) {
    std::vector<std::byte> payload(header.length);
    const Result<std::size_t> count = log.read(offset + kFrameHeaderBytes, payload);
    if (!count) return count.error();
    return *count == payload.size() && hash_bytes(payload) == header.payload_hash;
}

/// Where frames lie that sound indexes know of, beginning to end.
using Known = std::map<std::uint64_t, std::uint64_t>;

/// Are the bytes of `gap` nothing but frames that are known, one behind the other?
bool is_explained(const Gap& gap, const Known& known) {
    std::uint64_t at = gap.begin;
    while (at < gap.end) {
        const auto frame = known.find(at);
        if (frame == known.end() || frame->second <= at) return false;
        at = frame->second;
    }
    return true;
}

/// The state of the log at `limit`, from what is left of its frames and indexes.
Result<Known> replay(LogFile& log, const LogScan& scan, std::uint64_t limit, RecoveredLog& found) {
    Known known;
    for (const FoundFrame& frame : scan.frames) {
        if (frame.offset >= limit) break;
        const BlobKey& key = frame.header.key;
        if (frame.header.type == FrameType::Blob) {
            found.blobs[key] = {frame.offset, kUnknownMark, frame.header.length};
        } else if (frame.header.type == FrameType::Erase) {
            found.blobs.erase(key);
        } else if (frame.is_sound) {
            const Result<std::optional<Index>> index = read_index(log, frame.offset);
            if (!index) return index.error();
            if (!*index) continue;
            found.generation = std::max(found.generation, (*index)->generation);
            if ((*index)->previous != 0) known[(*index)->previous] = (*index)->previous_end;
            // It names the newest blobs, also those whose frames are damaged, and with their marks.
            for (const AddedBlob& added : (*index)->added) {
                known[added.entry.offset] = added.entry.offset + added.entry.frame_bytes();
                found.blobs[added.key] = added.entry;
            }
            for (const BlobKey& erased : (*index)->erased) found.blobs.erase(erased);
        }
    }
    return known;
}

void report_damaged_blobs(LogFile& log, const LogScan& scan, RecoveredLog& found) {
    for (const auto& [key, entry] : found.blobs) {
        const auto frame = std::ranges::lower_bound(scan.frames, entry.offset, {}, &FoundFrame::offset);
        if (frame == scan.frames.end() || frame->offset != entry.offset || !frame->is_sound)
            found.damage.push_back(
                {ErrorCode::FileFormat, text(log.path(), ": at byte ", entry.offset, ": the blob ",
                                             static_cast<int>(key.kind), " (", key.x, ", ", key.z, ") is damaged")});
    }
}

}  // namespace

Result<LogScan> scan_log(LogFile& log, std::uint64_t begin) {
    LogScan scan;
    for (std::uint64_t at = begin; at < log.end();) {
        const Result<std::optional<FrameHeader>> header = log.read_frame_header(at);
        if (!header) return header.error();
        if (*header && (*header)->bytes() <= log.end() - at) {
            const Result<bool> is_sound = is_payload_sound(log, **header, at);
            if (!is_sound) return is_sound.error();
            scan.frames.push_back({**header, at, *is_sound});
            at = scan.frames.back().end();
        } else {
            const Result<std::uint64_t> next = find_frame(log, at + 1);
            if (!next) return next.error();
            scan.gaps.push_back({at, *next});
            at = *next;
        }
    }
    return scan;
}

Result<void> recover_by_scan(LogFile& log, RecoveredLog& found) {
    found.was_scanned = true;
    const Result<LogScan> scan = scan_log(log, kFirstFrame);
    if (!scan) return scan.error();

    const Superblock wanted = found.commit;
    const bool is_all_there = wanted.generation != 0 && wanted.end <= log.end();
    if (is_all_there) {
        found.damage.push_back({ErrorCode::FileFormat, text(log.path(), ": at byte ", wanted.index_offset,
                                                            ": the index, or one that it builds "
                                                            "on, is damaged; it was made again "
                                                            "from the blobs")});
    } else {
        found.commit = {};
        for (auto frame = scan->frames.rbegin(); frame != scan->frames.rend() && found.commit.generation == 0;
             ++frame) {
            if (frame->header.type != FrameType::Index || !frame->is_sound) continue;
            const Result<std::optional<Index>> index = read_index(log, frame->offset);
            if (!index) return index.error();
            if (*index) found.commit = {(*index)->generation, (*index)->mark, frame->offset, frame->end(), 0};
        }
        found.damage.push_back(
            {ErrorCode::FileFormat,
             text(log.path(), ": at byte ", std::min(log.end(), superblock_offset(0)),
                  ": the last commit is lost: the file ends at byte ", log.end(),
                  ", the superblocks are damaged or want more; what is left is as of mark ", found.commit.mark)});
        found.is_wreck = found.commit.generation == 0;
        found.is_restored = true;
    }
    const std::uint64_t limit = found.commit.end;
    Result<Known> known = replay(log, *scan, limit, found);
    if (!known) return known.error();
    if (is_all_there) (*known)[wanted.index_offset] = wanted.end;

    found.may_miss_blobs = found.is_wreck;
    for (Gap gap : scan->gaps) {
        gap.end = std::min(gap.end, limit);
        if (gap.begin >= limit || is_explained(gap, *known)) continue;
        found.may_miss_blobs = true;
        found.damage.push_back(
            {ErrorCode::FileFormat, text(log.path(), ": at byte ", gap.begin, ": ", gap.end - gap.begin,
                                         " bytes are damaged, and with them "
                                         "blobs that are not known: older ones may be in their place")});
    }
    report_damaged_blobs(log, *scan, found);
    if (!is_all_there) found.commit.blobs = found.blobs.size();
    return {};
}

}  // namespace tilth
