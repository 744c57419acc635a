// What a `pages-<n>.tlp` holds, found from its superblocks and indexes, or from its frames where those are damaged.
#pragma once

#include <map>
#include <vector>

#include "tilth/store/log_file.h"

namespace tilth {

/// An index in the file, and the keys that it has changes of.
struct LogRun {
    std::uint64_t offset = 0, end = 0;
    std::vector<BlobKey> keys;
};

struct RecoveredLog {
    log_format::Superblock commit;  ///< generation 0: there is none
    unsigned slot = 1;              ///< where its superblock is, or belongs
    bool is_restored = false;       ///< both superblocks are worthless: the commit was found by its index
    bool is_other_damaged = false;  ///< the superblock in the other slot
    bool is_past_damage = false;    ///< the commit was found by its index, behind bytes that are damaged
    std::uint64_t generation = 0;   ///< the highest that was seen
    std::map<BlobKey, log_format::Entry> blobs;
    std::vector<LogRun> runs;  ///< the chain of indexes, the oldest first; empty after a scan
    bool is_header_damaged = false;
    bool is_wreck = false;  ///< no commit was found, and this is not how a file is born
    bool was_scanned = false, may_miss_blobs = false;
    std::vector<Error> damage;
};

/// Reads, changes nothing. Fails with FileFormat (no file of ours, of a newer version, of another world) and FileRead.
Result<RecoveredLog> recover_log(LogFile& log);

struct FoundFrame {
    log_format::FrameHeader header;
    std::uint64_t offset = 0;
    bool is_sound = false;  ///< its payload is what its checksum says
    [[nodiscard]] std::uint64_t end() const { return offset + header.bytes(); }
};
struct Gap {
    std::uint64_t begin = 0, end = 0;
};
/// All frames whose headers are sound, in order, and what lies between them.
struct LogScan {
    std::vector<FoundFrame> frames;
    std::vector<Gap> gaps;
};
/// From `begin`, where a frame is, to the end of the file.
Result<LogScan> scan_log(LogFile& log, std::uint64_t begin);

/// Empty: there is no sound index at that place.
Result<std::optional<log_format::Index>> read_index(LogFile& log, std::uint64_t offset, std::uint64_t* end = nullptr);

/// Makes `found.blobs` again from the frames of the whole file, as of `found.commit` or, where that is not known or the
/// file is shorter, of the newest commit whose index is there.
Result<void> recover_by_scan(LogFile& log, RecoveredLog& found);

}  // namespace tilth
