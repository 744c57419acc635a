#include "tilth/store/editor.h"

#include <iterator>

namespace tilth {
namespace {

/// A stroke that came from a disk: undoing it must be possible.
Result<void> check_restored(Ground& ground, const Stroke& stroke) {
    const auto refuse = [&](const std::string& why) {
        return Error{ErrorCode::FileFormat, text("stroke ", stroke.number, " of the undo history: ", why)};
    };
    if (stroke.records.empty()) return refuse("it has no stamps");
    for (const StampRecord& record : stroke.records)
        if (const Result<void> accepted = ground.accept(record); !accepted)
            return refuse(text("stamp ", record.sequence, ": ", accepted.error().message));
    for (const auto& [page, codes] : stroke.coarse)
        if (codes == nullptr) return refuse(text("coarse page (", page.x, ", ", page.z, ") has no codes"));
    return {};
}

}  // namespace

Editor::Editor(Ground& ground, std::shared_ptr<WorldFolder> world, std::uint64_t undo_bytes)
    : ground_(ground), world_(std::move(world)), history_(undo_bytes) {
    if (world_ != nullptr) edits_ = world_->appended();
}

Result<StampRecord> Editor::stamp(const StampRequest& request) {
    Result<StampRecord> record = ground_.issue(request);
    if (!record) return record;
    if (const Result<void> added = add(*record); !added) return added.error();
    return record;
}

Result<void> Editor::replay(const StampRecord& record) {
    if (const Result<void> accepted = ground_.accept(record); !accepted) return accepted;
    return add(record);
}

Result<void> Editor::add(const StampRecord& record) {
    if (world_ != nullptr && record.shape >= kBuiltinProfiles) {
        const ShapeId shape{record.shape};
        if (const Result<void> kept = world_->keep_shape(shape, ground_.shapes().shape(shape)); !kept) return kept;
    }
    const bool begins = !in_stroke_ || !std::exchange(stroke_begun_, true);
    GroundEdit edit = history_.add(record, begins);
    append({.kind = EditKind::Stamp, .begins_stroke = begins, .record = record});
    queue_.push_back(std::move(edit));
    return {};
}

Result<void> Editor::undo() { return turn(EditKind::Undo); }
Result<void> Editor::redo() { return turn(EditKind::Redo); }

/// Undoes or redoes.
Result<void> Editor::turn(EditKind kind) {
    const Result<StrokePtr> stroke = kind == EditKind::Undo ? history_.undo() : history_.redo();
    if (!stroke) return stroke.error();
    stroke_begun_ = false;
    append({.kind = kind, .record = {.sequence = (*stroke)->records.front().sequence}});
    queue_turn(kind, *stroke);
    return {};
}

void Editor::queue_turn(EditKind kind, const StrokePtr& stroke) {
    if (kind == EditKind::Undo) {
        queue_.push_back(undo_edit(stroke));
    } else {
        std::vector<GroundEdit> stamps = redo_edits(stroke);
        std::move(stamps.begin(), stamps.end(), std::back_inserter(queue_));
    }
}

void Editor::append(const Edit& edit) { edits_ = world_ != nullptr ? world_->append(edit) : edits_ + 1; }

Result<void> Editor::recover(RecoveredWorld& recovered) {
    for (const std::vector<StrokePtr>* list : {&recovered.done, &recovered.undone})
        for (const StrokePtr& stroke : *list)
            if (const Result<void> checked = check_restored(ground_, *stroke); !checked) return checked;
    history_.set_replaying(true);
    history_.restore(std::move(recovered.done), std::move(recovered.undone), recovered.next_stroke);
    for (const std::deque<StrokePtr>* list : {&history_.done(), &history_.undone()})
        for (const StrokePtr& stroke : *list) stroke->saved_version = stroke->version;
    ground_.continue_from(recovered.next_sequence);
    edits_ = world_ != nullptr ? world_->appended() : edits_ + recovered.tail.size();
    std::uint64_t number = edits_ - recovered.tail.size();
    for (const Edit& edit : recovered.tail) {
        ++number;
        if (const Result<void> done = recover(edit); !done)
            return Error{done.error().code, text("edit ", number, " of the journal: ", done.error().message)};
    }
    return {};
}

Result<void> Editor::recover(const Edit& edit) {
    if (edit.kind == EditKind::Stamp) {
        if (const Result<void> accepted = ground_.accept(edit.record); !accepted) return accepted;
        queue_.push_back(history_.add(edit.record, edit.begins_stroke));
        return {};
    }
    // Looked at before it is moved, so that an edit that does not fit changes nothing.
    const bool undoes = edit.kind == EditKind::Undo;
    const std::deque<StrokePtr>& from = undoes ? history_.done() : history_.undone();
    if (!from.empty() && from.back()->records.front().sequence != edit.record.sequence)
        return Error{ErrorCode::FileFormat,
                     text(undoes ? "undoes" : "redoes", " the stroke that begins with stamp ", edit.record.sequence,
                          ", but the last one begins with stamp ", from.back()->records.front().sequence,
                          "; pages and journal are not of the same world, take both from one backup")};
    const Result<StrokePtr> stroke = undoes ? history_.undo() : history_.redo();
    if (!stroke) return Error{ErrorCode::FileFormat, stroke.error().message};
    queue_turn(edit.kind, *stroke);
    return {};
}

void Editor::applied() {
    if (!queue_.empty()) return;
    history_.set_replaying(false);
    history_.trim();
}

Snapshot Editor::begin_snapshot() {
    TILTH_EXPECTS(queue_.empty(), "a snapshot is of a moment at which every edit is applied");
    Snapshot snapshot;
    snapshot.edits = edits_;
    snapshot.next_sequence = ground_.next_sequence();
    snapshot.history.next_number = history_.next_number();
    const auto note = [&](const std::deque<StrokePtr>& strokes, std::vector<std::uint64_t>& numbers) {
        numbers.reserve(strokes.size());
        for (const StrokePtr& stroke : strokes) {
            numbers.push_back(stroke->number);
            if (std::exchange(stroke->saved_version, stroke->version) == stroke->version) continue;
            snapshot.history.changed.push_back({.number = stroke->number,
                                                .records = stroke->records,
                                                .coarse = stroke->coarse,
                                                .detail = stroke->detail,
                                                .version = stroke->version});
        }
    };
    note(history_.done(), snapshot.history.done);
    note(history_.undone(), snapshot.history.undone);
    return snapshot;
}

void Editor::snapshot_failed(const Snapshot& snapshot) {
    for (const Stroke& copy : snapshot.history.changed)
        if (const StrokePtr stroke = history_.find(copy.number)) stroke->saved_version = Stroke::kNeverSaved;
}

}  // namespace tilth
