// The order of truth: every edit of a world, appended to files of fixed-size entries.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/edit.h"
#include "tilth/store/file_system.h"

namespace tilth {

/// When an edit becomes durable.
struct FlushPolicy {
    enum class When : std::uint8_t {
        Each,    ///< `append` returns when the disk has it: costs the caller one sync (0.2 to 10 ms) an edit
        Every,   ///< a thread of the journal's own syncs what is new, `interval_ms` after the first of it
        Manual,  ///< on `flush` alone
    };
    When when = When::Every;
    double interval_ms = 5;  ///< 0.1..60 000
};

/// What opening found.
struct JournalReport {
    std::uint64_t truncated_bytes = 0;  ///< of a torn tail: entries that were not durable yet when the power went
    std::vector<Error> damage;          ///< with file and offset
};

/// The journal of one world: files `journal-<number of the first edit>.tlj` in its folder.
///
/// An edit is durable once it was flushed. What cannot be written (a full disk) stays in memory and is tried again with
/// every flush: nothing is lost, the order is kept, and nothing half-written is ever read back. Opening cuts the torn
/// tail off at the last valid entry.
/// Memory: 64 bytes an edit that is not durable yet. Disk: 64 bytes an edit.
/// Threads: `append` on one; the others on any. `append` waits for the disk with `Each` alone.
class Journal {
public:
    /// `from`: edits above this one are wanted back (they are not in the pages yet). `folder` exists. `salt`: the
    /// world's. Fails when the files cannot be read or written, belong to another world or are of a newer version.
    /// Damage among the wanted entries, or wanted entries that are missing, end the tail there, and are reported: the
    /// entries behind are moved aside, to files `*.damaged`, not deleted, and the next edit gets the number of the
    /// first that was lost. Entries up to `from` are not looked at. What is handed out is durable: it is synced first.
    static Result<std::unique_ptr<Journal>> open(FileSystem& files, std::string folder, std::uint64_t salt,
                                                 std::uint64_t from, const FlushPolicy& policy, JournalReport& report,
                                                 std::vector<Edit>& tail);
    /// Flushes, unless `abandon` was called. What cannot be written even now is lost, and logged as an error.
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    /// Returns the edit's number. With `Each` it waits for the disk; an error there is reported by `take_errors`.
    std::uint64_t append(const Edit& edit);
    /// Waits until everything appended so far is durable. On an error nothing is lost, see above.
    Result<void> flush();
    /// Number of the last edit appended, and of the last one that is durable.
    [[nodiscard]] std::uint64_t appended() const;
    [[nodiscard]] std::uint64_t durable() const;
    /// Trouble in the background (with `Each`: in `append`) since the last call: reported once, here or by `flush`,
    /// until it went well again.
    [[nodiscard]] std::vector<Error> take_errors();

    /// Edits up to `number` are in the pages. The next edit begins a new file, unless this one has less than a 16th of
    /// `keep_bytes`; old files whose edits are all up to `number` go, the oldest first, while together they exceed
    /// `keep_bytes`. Those that stay can rebuild damaged pages. On an error some may have stayed that should have gone.
    Result<void> release(std::uint64_t number, std::uint64_t keep_bytes);
    /// Number of the first edit from which on the files have every one; one more than the last that is durable where
    /// they have none.
    [[nodiscard]] std::uint64_t first() const;
    /// Reads edits `first..last` back, for repairs and replay, also those that are not durable yet. Fails where they
    /// are gone (NotFound) or damaged (FileFormat).
    Result<std::vector<Edit>> read(std::uint64_t first, std::uint64_t last);
    /// Of its files, those moved aside not counted.
    [[nodiscard]] std::uint64_t disk_bytes() const;

    /// As a crash would: what is not flushed now never will be. Edits appended later get numbers and go nowhere;
    /// `flush` fails.
    void abandon();

private:
    struct Impl;
    explicit Journal(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace tilth
