#include "tilth/store/saved_ground.h"

#include <iterator>
#include <utility>

#include "tilth/ground/apply_edit.h"
#include "tilth/ground/before_image.h"
#include "tilth/store/restore_detail.h"

namespace tilth {

SavedGround::SavedGround(std::unique_ptr<Ground> ground, std::shared_ptr<WorldFolder> world, std::uint64_t undo_bytes)
    : ground_(std::move(ground)), world_(std::move(world)), editor_(*ground_, world_, undo_bytes) {}

Result<std::unique_ptr<SavedGround>> SavedGround::open(std::unique_ptr<Ground> ground, const std::string& folder,
                                                       const WorldOptions& options, std::uint64_t undo_bytes) {
    RecoveredWorld recovered;
    auto world = WorldFolder::open(folder, *ground, options, recovered);
    if (!world) return world.error();
    std::unique_ptr<SavedGround> saved(new SavedGround(std::move(ground), std::move(*world), undo_bytes));
    for (const Page& page : recovered.coarse) put_page(saved->ground_->mutable_coarse(), page.index, *page.codes);
    if (const Result<void> ordered = saved->editor_.recover(recovered); !ordered) return ordered.error();
    auto changed = restore_detail(*saved->world_, recovered, saved->editor_.history(), *saved->ground_);
    if (!changed) return changed.error();
    saved->changed_.note(*changed);
    saved->apply_queue();
    saved->reports_ = std::move(recovered.reports);
    std::vector<Error> of_pages = saved->world_->take_errors();
    std::move(of_pages.begin(), of_pages.end(), std::back_inserter(saved->reports_));
    return saved;
}

void SavedGround::apply_queue() {
    for (const GroundEdit& edit : editor_.take_queue()) {
        changed_.note(*ground_, edit);
        apply_edit(*ground_, edit);
    }
    editor_.applied();
}

Result<StampRecord> SavedGround::stamp(const StampRequest& request) {
    Result<StampRecord> record = editor_.stamp(request);
    if (record) apply_queue();
    return record;
}

Result<void> SavedGround::replay(const StampRecord& record) {
    const Result<void> queued = editor_.replay(record);
    if (queued) apply_queue();
    return queued;
}

Result<void> SavedGround::undo() {
    const Result<void> queued = editor_.undo();
    if (queued) apply_queue();
    return queued;
}

Result<void> SavedGround::redo() {
    const Result<void> queued = editor_.redo();
    if (queued) apply_queue();
    return queued;
}

Snapshot SavedGround::snapshot() {
    TILTH_EXPECTS(!std::exchange(is_writing_, true), "finish() the snapshot before, or what it held may be lost");
    Snapshot snapshot = editor_.begin_snapshot();
    changed_.take_coarse(*ground_, snapshot);
    changed_.take_tiles(*ground_, snapshot);
    return snapshot;
}

void SavedGround::finish(const Snapshot& snapshot, const Result<void>& outcome) {
    is_writing_ = false;
    if (outcome) return;
    editor_.snapshot_failed(snapshot);
    changed_.put_back(snapshot);
}

Result<void> SavedGround::save() {
    const Snapshot taken = snapshot();
    const Result<void> outcome = commit(taken);
    finish(taken, outcome);
    return outcome;
}

}  // namespace tilth
