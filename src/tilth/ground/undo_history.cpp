#include "tilth/ground/undo_history.h"

#include <algorithm>
#include <utility>

namespace tilth {
namespace {

// What a stroke costs beside records and codes: itself, its places in the lists, and a node of the map an image.
constexpr std::uint64_t kStrokeBytes = 256, kImageBytes = 64;

std::uint64_t bytes_of_image(const std::shared_ptr<const PageCodes>& codes) {
    return kImageBytes + (codes == nullptr ? 0 : sizeof(PageCodes));
}

void count(Stroke& stroke, std::uint64_t bytes) {
    ++stroke.version;
    if (stroke.account == nullptr) return;
    stroke.counted_bytes += bytes;
    *stroke.account += bytes;
}

void enter(Stroke& stroke, const std::shared_ptr<std::uint64_t>& account) {
    stroke.account = account;
    stroke.counted_bytes = stroke.bytes();
    *account += stroke.counted_bytes;
}

void leave(Stroke& stroke) {
    if (stroke.account == nullptr) return;
    *stroke.account -= stroke.counted_bytes;
    stroke.account = nullptr;
    stroke.counted_bytes = 0;
}

void clear(Stroke& stroke) {
    stroke.forgotten = true;
    stroke.records = {};
    stroke.coarse.clear();
    stroke.detail.clear();
}

}  // namespace

std::uint64_t Stroke::bytes() const {
    std::uint64_t sum = kStrokeBytes + records.size() * sizeof(StampRecord);
    for (const Images* images : {&coarse, &detail})
        for (const auto& [page, codes] : *images) sum += bytes_of_image(codes);
    return sum;
}

void Stroke::append(const StampRecord& record) {
    records.push_back(record);
    count(*this, sizeof(StampRecord));
}

void Stroke::keep_image(MapKind map, PageIndex page, const std::shared_ptr<const PageCodes>& codes) {
    if (images(map).try_emplace(page, codes).second) count(*this, bytes_of_image(codes));
}

std::vector<StampRecord> undoing_records(const Stroke& stroke) {
    std::vector<StampRecord> undoing;
    for (auto record = stroke.records.rbegin(); record != stroke.records.rend(); ++record)
        if (record->rule == StampRule::Add) undoing.push_back(negated(*record));
    return undoing;
}

UndoInFlight::UndoInFlight(StrokePtr stroke) : stroke_(std::move(stroke)) { ++stroke_->undos_on_their_way; }

UndoInFlight::~UndoInFlight() {
    if (--stroke_->undos_on_their_way == 0 && stroke_->has_left) clear(*stroke_);
}

GroundEdit undo_edit(const StrokePtr& stroke) {
    TILTH_ASSERT(!stroke->forgotten, "a forgotten stroke cannot be undone");
    return {.kind = GroundEdit::Kind::Undo,
            .record = {},
            .stroke = stroke,
            .in_flight = std::make_shared<const UndoInFlight>(stroke)};
}

std::vector<GroundEdit> redo_edits(const StrokePtr& stroke) {
    std::vector<GroundEdit> edits;
    edits.reserve(stroke->records.size());
    for (const StampRecord& record : stroke->records)
        edits.push_back({.record = record, .stroke = stroke, .position = edits.size()});
    return edits;
}

GroundEdit UndoHistory::add(const StampRecord& record, bool begins_stroke) {
    forget_undone();
    GroundEdit edit{.record = record, .stroke = nullptr};
    if (begins_stroke) {
        if (most_bytes_ == 0 && !replaying_) {
            // What a replay noted ends here: it must not be undone from under this stamp.
            for (const StrokePtr& stroke : done_) forget(stroke);
            done_.clear();
            return edit;
        }
        done_.push_back(std::make_shared<Stroke>());
        done_.back()->number = next_number_++;
        enter(*done_.back(), account_);
    } else if (done_.empty()) {
        return edit;  // the stroke's beginning is forgotten
    }
    edit.stroke = done_.back();
    edit.position = edit.stroke->records.size();
    edit.stroke->append(record);
    return edit;
}

Result<StrokePtr> UndoHistory::undo() {
    if (done_.empty()) {
        if (most_bytes_ == 0)
            return Error{ErrorCode::InvalidArgument,
                         "undo: 0 strokes can be undone; the bound of the history is 0 bytes"};
        if (forgotten_ == 0) return Error{ErrorCode::InvalidArgument, "undo: 0 strokes can be undone"};
        return Error{ErrorCode::InvalidArgument,
                     text("undo: 0 strokes can be undone; ", forgotten_, " older ones were forgotten to keep to ",
                          most_bytes_, " bytes; raise the bound of the history to go further back")};
    }
    undone_.push_back(std::move(done_.back()));
    done_.pop_back();
    return undone_.back();
}

Result<StrokePtr> UndoHistory::redo() {
    if (undone_.empty())
        return Error{ErrorCode::InvalidArgument,
                     "redo: 0 strokes can be redone; none was undone since the last stamp, or it was forgotten"};
    done_.push_back(std::move(undone_.back()));
    undone_.pop_back();
    return done_.back();
}

void UndoHistory::trim() {
    if (replaying_) return;
    for (std::deque<StrokePtr>* list : {&done_, &undone_})
        for (; bytes() > most_bytes_ && !list->empty(); list->pop_front()) {
            forget(list->front());
            if (list == &done_) ++forgotten_;
        }
}

void UndoHistory::restore(std::vector<StrokePtr> done, std::vector<StrokePtr> undone, std::uint64_t next_number) {
    for (const StrokePtr& stroke : done_) forget(stroke);
    forget_undone();
    done_.assign(done.begin(), done.end());
    undone_.assign(undone.begin(), undone.end());
    next_number_ = next_number;
    for (const std::deque<StrokePtr>* list : {&done_, &undone_})
        for (const StrokePtr& stroke : *list) enter(*stroke, account_);
}

StrokePtr UndoHistory::find(std::uint64_t number) const {
    const auto number_of = [](const StrokePtr& stroke) { return stroke->number; };
    const auto done = std::ranges::lower_bound(done_, number, {}, number_of);
    if (done != done_.end() && number_of(*done) == number) return *done;
    const auto undone = std::ranges::lower_bound(undone_, number, std::ranges::greater{}, number_of);
    return undone != undone_.end() && number_of(*undone) == number ? *undone : nullptr;
}

/// Takes its bytes off the account. The caller takes it off the lists.
void UndoHistory::forget(const StrokePtr& stroke) {
    leave(*stroke);
    stroke->has_left = true;
    if (stroke->undos_on_their_way == 0) clear(*stroke);
}

void UndoHistory::forget_undone() {
    for (const StrokePtr& stroke : undone_) forget(stroke);
    undone_.clear();
}

}  // namespace tilth
