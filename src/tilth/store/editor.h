// Issues a world's edits: checks them, numbers them, notes them for undo, and journals them before they are applied.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/edit.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/undo_history.h"
#include "tilth/store/snapshot.h"
#include "tilth/store/world_folder.h"

namespace tilth {

/// The one way in for edits, with or without a world on disk. What it issued waits in a queue until the owner of the
/// maps takes it and applies it, in order.
///
/// Strokes: each stamp is one of its own, except between `begin_stroke` and `end_stroke`. An undo or redo in between
/// ends the part before it: what follows is another stroke.
/// Threads: one, the ground's.
class Editor {
public:
    /// `ground` outlives it. `world` may be nullptr: nothing is journaled then. `undo_bytes`: bound of the history.
    Editor(Ground& ground, std::shared_ptr<WorldFolder> world, std::uint64_t undo_bytes);

    /// Checks, numbers, journals and queues a stamp. Fails with the field's name, or because its shape cannot be kept
    /// on disk; nothing changes then (but in the second case a sequence number is left out, which harms nobody).
    Result<StampRecord> stamp(const StampRequest& request);
    /// The same with a record made elsewhere, which keeps its own number.
    Result<void> replay(const StampRecord& record);
    void begin_stroke() { in_stroke_ = true, stroke_begun_ = false; }
    void end_stroke() { in_stroke_ = false; }
    /// Queues the undoing of the last stroke, or of its redoing. Fails where there is none.
    Result<void> undo();
    Result<void> redo();

    /// Puts what opening found in order: history and sequence numbers at once; the tail into the queue, edit by edit.
    /// Before anything else. Fails on an edit that does not fit this world (a shape is missing, say), having queued
    /// those before it; the message has its number. Until `applied` nothing is forgotten, whatever the bound.
    Result<void> recover(RecoveredWorld& recovered);

    [[nodiscard]] bool is_empty() const { return queue_.empty(); }
    std::vector<GroundEdit> take_queue() { return std::exchange(queue_, {}); }
    /// After edits were applied: the history keeps to its bound. Does nothing while edits are in the queue.
    void applied();

    [[nodiscard]] UndoHistory& history() { return history_; }
    [[nodiscard]] const UndoHistory& history() const { return history_; }
    [[nodiscard]] const std::shared_ptr<WorldFolder>& world() const { return world_; }
    /// Number of the last edit that was issued.
    [[nodiscard]] std::uint64_t edits() const { return edits_; }

    /// Begins a snapshot with what is known here: edits, numbers, history. The queue is empty, and everything that was
    /// taken from it is applied. What is `changed` in it is not in the next one, unless `snapshot_failed`. Images in it
    /// are shares of pages: given back on this thread.
    Snapshot begin_snapshot();
    /// Cost of both: a look at each stroke of the history.
    void snapshot_failed(const Snapshot& snapshot);

private:
    Result<void> add(const StampRecord& record);
    Result<void> recover(const Edit& edit);
    Result<void> turn(EditKind kind);
    void append(const Edit& edit);
    void queue_turn(EditKind kind, const StrokePtr& stroke);
    Ground& ground_;
    std::shared_ptr<WorldFolder> world_;
    UndoHistory history_;
    std::vector<GroundEdit> queue_;
    std::uint64_t edits_ = 0;
    bool in_stroke_ = false, stroke_begun_ = false;
};

}  // namespace tilth
