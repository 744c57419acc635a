// A ground that is wholly in memory and durable on disk: what a dedicated server runs.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/ground.h"
#include "tilth/store/changed_parts.h"
#include "tilth/store/editor.h"
#include "tilth/store/snapshot.h"
#include "tilth/store/world_folder.h"

namespace tilth {

/// Stamps are journaled, then applied at once. `save` writes what changed as a snapshot, so that opening again does not
/// replay it; without it nothing is lost, opening only takes longer.
/// Threads: one; `commit` and `compact` may run on another meanwhile.
class SavedGround {
public:
    /// Opens or makes the world in `folder` on `ground`, which no stamp has touched. Errors as `WorldFolder::open`.
    static Result<std::unique_ptr<SavedGround>> open(std::unique_ptr<Ground> ground, const std::string& folder,
                                                     const WorldOptions& options, std::uint64_t undo_bytes);

    [[nodiscard]] const Ground& ground() const { return *ground_; }
    [[nodiscard]] ShapeLibrary& shapes() { return ground_->shapes(); }
    [[nodiscard]] WorldFolder& world() { return *world_; }
    /// What opening found and repaired.
    [[nodiscard]] const std::vector<Error>& reports() const { return reports_; }

    Result<StampRecord> stamp(const StampRequest& request);
    Result<void> replay(const StampRecord& record);
    void begin_stroke() { editor_.begin_stroke(); }
    void end_stroke() { editor_.end_stroke(); }
    Result<void> undo();
    Result<void> redo();
    [[nodiscard]] const UndoHistory& history() { return editor_.history(); }

    /// Waits until every stamp so far is durable.
    Result<void> flush() { return world_->flush(); }
    /// What changed since the last snapshot, which is finished; cheap (pages of the detail map are shared, of the
    /// coarse map copied).
    Snapshot snapshot();
    /// Writes it, on any thread; then `finish` on the ground's own thread, with the outcome.
    Result<void> commit(const Snapshot& snapshot) { return world_->commit(snapshot); }
    void finish(const Snapshot& snapshot, const Result<void>& outcome);
    /// The three in one, waiting.
    Result<void> save();

private:
    SavedGround(std::unique_ptr<Ground> ground, std::shared_ptr<WorldFolder> world, std::uint64_t undo_bytes);
    void apply_queue();
    std::unique_ptr<Ground> ground_;
    std::shared_ptr<WorldFolder> world_;
    Editor editor_;
    std::vector<Error> reports_;
    ChangedParts changed_{true};
    bool is_writing_ = false;  ///< a snapshot is taken and not finished
};

}  // namespace tilth
