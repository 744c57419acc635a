// Moves what a log is worth into the next file, a little at a time, while the old one goes on being used.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tilth/store/log_recovery.h"
#include "tilth/store/log_state.h"

namespace tilth {

/// Copies the blobs of the last commit. Those that a commit replaces meanwhile are copied again. The new file has no
/// commit until everything in it is durable, so that a crash before leaves the old one valid. Damaged blobs are copied
/// with a checksum that does not fit: they stay damaged, and reported.
class LogCompaction {
public:
    static Result<std::unique_ptr<LogCompaction>> begin(FileSystem& files, const std::string& folder,
                                                        const log_format::FileTag& tag, const LogState& state);

    /// These keys were committed since; to be called before `LogState::settle` or after.
    void committed(const LogState& state);
    /// Copies about `most_bytes`, at least one blob; every 16 MiB are synced, so that nobody else's sync waits for
    /// more. After an error the new file is worthless.
    Result<void> step(LogFile& old, const LogState& state, std::uint64_t most_bytes);
    [[nodiscard]] bool is_caught_up() const { return todo_.empty(); }

    struct Finished {
        std::unique_ptr<LogFile> log;
        LogState state;
        LogRun run;
        log_format::Superblock commit;
    };
    /// Commits the new file, with what is not committed behind that: cost by its bytes. On success it is durable.
    Result<Finished> finish(LogFile& old, const LogState& state, std::uint64_t generation, std::uint64_t mark);

    [[nodiscard]] const LogFile& log() const { return *log_; }

    /// Which superblock `finish` writes.
    static constexpr unsigned kSlot = 0;

private:
    LogCompaction(FileSystem& files, std::string folder, std::unique_ptr<LogFile> log)
        : files_(files), folder_(std::move(folder)), log_(std::move(log)) {}
    Result<log_format::Entry> copy(LogFile& old, const BlobKey& key, const log_format::Entry& entry);
    Result<void> copy_pending(LogFile& old, const LogState& state, LogState& moved);

    struct Copied {
        std::uint64_t from = 0;  ///< its offset in the old file
        log_format::Entry entry;
    };
    FileSystem& files_;
    std::string folder_;
    std::unique_ptr<LogFile> log_;
    std::map<BlobKey, Copied> copied_;
    std::vector<BlobKey> todo_;
};

}  // namespace tilth
