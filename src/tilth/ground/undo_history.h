// Undo, last in first out, by stroke: what was stamped together is taken back together, bit for bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/page.h"
#include "tilth/ground/stamp.h"

namespace tilth {

/// Stamps that are undone together, and what has to be put back.
///
/// `add` is undone by the same records with their signs turned round. Where another rule, or an `add` that may have
/// saturated, wrote, the page's codes from before the stroke are kept (an *image*), and put back as they were. Both in
/// one stroke: first the records (`undoing_records`), then the images over them.
///
/// Records and images come in by `append` and `keep_image` alone, so that the history knows its size; whoever makes a
/// stroke from a file fills the members and gives it to `UndoHistory::restore`.
struct Stroke {
    using Images = std::map<PageIndex, std::shared_ptr<const PageCodes>>;

    std::uint64_t number = 0;
    std::vector<StampRecord> records;
    Images coarse, detail;      ///< nullptr: an untouched page of the detail map
    bool forgotten = false;     ///< can no longer be undone: nothing is kept for it
    std::uint64_t version = 0;  ///< counts changes, so that a snapshot knows what is new

    [[nodiscard]] Images& images(MapKind map) { return map == MapKind::Coarse ? coarse : detail; }
    [[nodiscard]] const Images& images(MapKind map) const { return map == MapKind::Coarse ? coarse : detail; }
    /// Of records and images. Counts them: cost of a walk over the images.
    [[nodiscard]] std::uint64_t bytes() const;

    void append(const StampRecord& record);
    /// Does nothing where the stroke has an image of that page: the first is the one from before the stroke.
    void keep_image(MapKind map, PageIndex page, const std::shared_ptr<const PageCodes>& codes);

    static constexpr std::uint64_t kNeverSaved = ~std::uint64_t{0};
    std::uint64_t saved_version = kNeverSaved;  ///< that the last snapshot had

    // The history's own.
    std::uint32_t undos_on_their_way = 0;    ///< see `UndoInFlight`
    bool has_left = false;                   ///< the history: forgotten as soon as no undo needs it any more
    std::uint64_t counted_bytes = 0;         ///< of it in `account`
    std::shared_ptr<std::uint64_t> account;  ///< bytes of all strokes of its history; nullptr: it is in none
};

using StrokePtr = std::shared_ptr<Stroke>;

/// The records whose ordinary application undoes the stroke's `add`s: the last first, signs turned round.
std::vector<StampRecord> undoing_records(const Stroke& stroke);

/// Lives as long as an undo of the stroke is on its way to the maps, however many frames that takes. The stroke keeps
/// its images until then, and gets those of its own stamps that still wait, even if the history forgets it meanwhile.
class UndoInFlight {
public:
    explicit UndoInFlight(StrokePtr stroke);
    ~UndoInFlight();
    UndoInFlight(const UndoInFlight&) = delete;
    UndoInFlight& operator=(const UndoInFlight&) = delete;

private:
    StrokePtr stroke_;
};

/// An edit on its way to the maps: one stamp of a stroke, or a stroke to be undone. (Redo is its stamps again.)
struct GroundEdit {
    enum class Kind : std::uint8_t { Stamp, Undo };
    Kind kind = Kind::Stamp;
    StampRecord record;                                       ///< of a stamp
    StrokePtr stroke;                                         ///< nullptr: a stamp that cannot be undone
    std::size_t position = 0;                                 ///< of the stamp among the stroke's records
    std::shared_ptr<const UndoInFlight> in_flight = nullptr;  ///< of an undo; copies of the edit share it
};

/// The edit that undoes `stroke`, which must not be forgotten.
GroundEdit undo_edit(const StrokePtr& stroke);
/// The edits that do it again: its stamps, in order.
std::vector<GroundEdit> redo_edits(const StrokePtr& stroke);

/// The strokes of a world, in memory of a stated bound.
///
/// Strokes are noted when they are issued; their images come in while the executors work. `trim` forgets the oldest
/// strokes while together they exceed the bound: undo then ends there, it is refused and never approximated. A stroke
/// counts 256 bytes, 64 for each record, 64 for each image and 16 KiB for the codes of one. What leaves the history
/// while an undo of it is on its way is not counted, and goes when that arrives.
/// Threads: one.
class UndoHistory {
public:
    /// 0: nothing can be undone, nothing is kept.
    explicit UndoHistory(std::uint64_t most_bytes) : most_bytes_(most_bytes) {}

    /// Notes a stamp that was issued, as part of the last stroke unless it begins one. What was undone before can then
    /// not be redone any more. The edit's stroke is nullptr where it cannot be undone: the bound is 0 (and nothing is
    /// being replayed), or its stroke is forgotten already.
    GroundEdit add(const StampRecord& record, bool begins_stroke);
    /// The last stroke that is not undone, which then is. Fails (InvalidArgument) where there is none, or it was
    /// forgotten; the message says how many can be undone. Make the edit (`undo_edit`) before anything else is done.
    Result<StrokePtr> undo();
    /// The last stroke that was undone, which then is not. Fails as `undo`.
    Result<StrokePtr> redo();
    [[nodiscard]] std::size_t undoable() const { return done_.size(); }
    [[nodiscard]] std::size_t redoable() const { return undone_.size(); }

    /// Forgets what exceeds the bound: the oldest strokes first, and last those that would be redone last. Once a
    /// frame, after the edits were applied. Cost: constant, and of what it forgets.
    void trim();
    /// While edits are replayed nothing is forgotten, and with a bound of 0 strokes are noted too: what could be undone
    /// then can be undone again.
    void set_replaying(bool replaying) { replaying_ = replaying; }
    [[nodiscard]] std::uint64_t bytes() const { return *account_; }
    [[nodiscard]] std::uint64_t most_bytes() const { return most_bytes_; }

    // For saving: both lists as they are, and the number that the next stroke gets.

    /// By rising number: the one to undo first is last.
    [[nodiscard]] const std::deque<StrokePtr>& done() const { return done_; }
    /// By falling number: the one to redo first is last.
    [[nodiscard]] const std::deque<StrokePtr>& undone() const { return undone_; }
    [[nodiscard]] std::uint64_t next_number() const { return next_number_; }
    /// In place of what there was; both lists in the order above.
    void restore(std::vector<StrokePtr> done, std::vector<StrokePtr> undone, std::uint64_t next_number);
    /// Nullptr where it is forgotten.
    [[nodiscard]] StrokePtr find(std::uint64_t number) const;

private:
    void forget(const StrokePtr& stroke);
    void forget_undone();
    std::uint64_t most_bytes_;
    bool replaying_ = false;
    std::uint64_t next_number_ = 1;
    std::uint64_t forgotten_ = 0;  ///< strokes that could be undone no more, for messages
    std::deque<StrokePtr> done_, undone_;
    std::shared_ptr<std::uint64_t> account_ = std::make_shared<std::uint64_t>(0);
};

}  // namespace tilth
