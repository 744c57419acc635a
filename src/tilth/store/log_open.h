// Which of a folder's `pages-<n>.tlp` is the world's, and what opening makes of the others.
#pragma once

#include <memory>
#include <string>

#include "tilth/store/log_recovery.h"
#include "tilth/store/log_store.h"

namespace tilth {

struct OpenedLog {
    std::unique_ptr<LogFile> log;  ///< it ends where its last commit does
    RecoveredLog found;
};

/// The file with the newest commit, or a new one. There are several only after a crash during compaction: the others
/// are removed; those without any commit that can be found are put aside, and all where the one that counts is damaged.
Result<OpenedLog> open_log(FileSystem& files, const std::string& folder, std::uint64_t salt, LogStoreReport& report);

}  // namespace tilth
