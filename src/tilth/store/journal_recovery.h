// Opening a journal: finding its end, cutting a torn tail off, moving aside what damage makes unusable.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/store/journal.h"
#include "tilth/store/journal_files.h"

namespace tilth {

struct RecoveredJournal {
    std::vector<JournalSegment> segments;
    std::unique_ptr<File> tail;  ///< the last segment, where the next edit goes into it
    std::uint64_t last = 0;      ///< number of the last edit; all up to it are durable
};

/// See `Journal::open`. Reads the entries above `from`, and of other segments the header alone.
///
///     found:   [ 1 ... 40 ][ 41 ... 52 ### 60 ... 77 ][ 78 ... 90 ]      ### does not check
///     nothing behind ### checks:    a torn tail: cut off, counted
///     something does, or a later
///     file has a good header:       damage: reported; what lies behind is moved aside, to files `*.damaged`
///
/// A new segment is begun only when the one before is durable to its end, so a good header is evidence as well.
Result<RecoveredJournal> recover_journal(const JournalPlace& place, std::uint64_t from, JournalReport& report,
                                         std::vector<Edit>& tail);

}  // namespace tilth
