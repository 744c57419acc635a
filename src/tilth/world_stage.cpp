#include "tilth/world_stage.h"

#include <utility>

#include "tilth/core/clock.h"
#include "tilth/store/restore_detail.h"

namespace tilth {
namespace {

constexpr std::uint32_t kWritePriority = 600, kCompactPriority = 5000;  // loads for the frame that is drawn have 0..999
constexpr std::uint64_t kCompactStep = 4u << 20;
constexpr int kMostFramesToPrepare = 30;
constexpr std::size_t kFewPages = 128;  // 2 MiB: what a frame may wait for
constexpr double kRetryMs = 1000, kCompactAgainMs = 60000;

}  // namespace

WorldStage::WorldStage(Ground& ground, Editor& editor, const WorldSettings& settings, CoarseStage* coarse,
                       DetailStage* detail)
    : ground_(ground),
      editor_(editor),
      settings_(settings),
      coarse_(coarse),
      detail_(detail),
      changed_(detail == nullptr) {
    if (detail_ == nullptr) worker_ = std::make_unique<DiskWorker>(editor.world());
}

void WorldStage::note(std::span<const GroundEdit> edits) {
    for (const GroundEdit& edit : edits) changed_.note(ground_, edit);
}

Result<void> WorldStage::restore_detail(const RecoveredWorld& recovered) {
    Result<std::set<TileIndex>> changed = tilth::restore_detail(world(), recovered, editor_.history(), ground_);
    if (!changed) return changed.error();
    changed_.note(*changed);
    return {};
}

// ---- a snapshot ----

bool WorldStage::is_due(double now_ms) const {
    if (writing_ != nullptr || now_ms < retry_at_ms_) return false;
    return asked_ || editor_.edits() - world().committed() >= settings_.snapshot_edits;
}

void WorldStage::update(gl::FrameStats& stats) {
    poll(stats.store);
    const double now_ms = clock_ms();
    if (!is_due(now_ms)) return;
    if (is_prepared(stats)) begin(stats);
    stats.store.snapshot_ms += clock_ms() - now_ms;
}

/// What the GPU alone has is asked for first: some frames later less is left to wait for. Where stamping goes on, there
/// is always something.
bool WorldStage::is_prepared(gl::FrameStats& stats) {
    if (detail_ == nullptr || detail_->cache().pages_ahead() == 0 || preparing_ >= kMostFramesToPrepare) return true;
    detail_->prepare_snapshot(stats);
    return ++preparing_ > 2 && detail_->cache().pages_ahead() <= kFewPages;
}

/// False while edits wait for tiles: of no moment are all of them in the codes.
bool WorldStage::begin(gl::FrameStats& stats) {
    if (!editor_.is_empty()) return false;
    std::optional<std::vector<TileSnapshot>> tiles;
    if (detail_ != nullptr) {
        tiles = detail_->snapshot(stats);
        if (!tiles) return false;
    }
    if (coarse_ != nullptr && changed_.has_coarse() && coarse_->is_ahead()) {
        coarse_->read_back(stats);
        ++stats.deform.fallbacks;
    }
    snapshot_ = std::make_shared<Snapshot>(editor_.begin_snapshot());
    changed_.take_coarse(ground_, *snapshot_);
    if (tiles)
        snapshot_->tiles = *std::move(tiles);
    else
        changed_.take_tiles(ground_, *snapshot_);
    asked_ = false;
    preparing_ = 0;
    writing_ = DiskRequest::work([world = editor_.world(), snapshot = snapshot_] { return world->commit(*snapshot); },
                                 kWritePriority);
    submit(writing_);
    return true;
}

void WorldStage::submit(std::shared_ptr<DiskRequest> work) {
    if (detail_ != nullptr)
        detail_->cache().submit(work);
    else
        worker_->submit(std::move(work));
}

void WorldStage::poll(gl::StoreStats& stats) {
    if (detail_ != nullptr) {
        for (const std::shared_ptr<DiskRequest>& done : detail_->cache().take_finished()) finish(done, stats);
    } else {
        while (const std::shared_ptr<DiskRequest> done = worker_->poll()) finish(done, stats);
    }
}

void WorldStage::finish(const std::shared_ptr<DiskRequest>& done, gl::StoreStats& stats) {
    if (done == writing_) {
        outcome_ = done->outcome;
        if (done->outcome) {
            ++stats.snapshots;
            reported_ = false;
            retry_at_ms_ = 0;
        } else {
            ++stats.failures;
            if (!reported_) errors_.push_back(done->outcome.error());
            reported_ = true;
            retry_at_ms_ = clock_ms() + kRetryMs;
            editor_.snapshot_failed(*snapshot_);
            changed_.put_back(*snapshot_);
            if (detail_ != nullptr) detail_->cache().snapshot_failed(snapshot_->tiles);
            asked_ = true;  // again
        }
        writing_ = nullptr;
        snapshot_ = nullptr;
        if (outcome_) begin_compaction();
    } else if (done == compacting_) {
        compacting_ = nullptr;
        ++stats.compactions;
        if (done->outcome) {
            compaction_failed_ = false;
            if (*more_to_compact_) begin_compaction();
        } else {
            if (!compaction_failed_) errors_.push_back(done->outcome.error());
            compaction_failed_ = true;
            compact_at_ms_ = clock_ms() + kCompactAgainMs;
        }
    }
    done->action = nullptr;  // with its shares of codes, on this thread
}

void WorldStage::begin_compaction() {
    if (compacting_ != nullptr || clock_ms() < compact_at_ms_) return;
    compacting_ = DiskRequest::work(
        [world = editor_.world(), more = more_to_compact_]() -> Result<void> {
            const Result<bool> left = world->compact(kCompactStep);
            *more = left.ok() && *left;
            return left.ok() ? Result<void>() : Result<void>(left.error());
        },
        kCompactPriority);
    submit(compacting_);
}

Result<void> WorldStage::save(gl::FrameStats& stats) {
    const auto wait = [&](const std::shared_ptr<DiskRequest>& work) {
        if (detail_ != nullptr) {
            detail_->cache().wait_for(work, stats.cache);
            poll(stats.store);
        } else {
            while (const std::shared_ptr<DiskRequest> done = worker_->wait()) {
                finish(done, stats.store);
                if (done == work) break;
            }
        }
    };
    if (writing_ != nullptr) wait(std::shared_ptr<DiskRequest>(writing_));
    retry_at_ms_ = 0;
    if (!begin(stats))
        return Error{ErrorCode::FileRead,
                     "save: edits wait for detail tiles that the store cannot give; see take_errors"};
    wait(std::shared_ptr<DiskRequest>(writing_));
    return outcome_;
}

std::vector<Error> WorldStage::take_errors() {
    std::vector<Error> errors = std::exchange(errors_, {});
    for (Error& error : world().take_errors()) errors.push_back(std::move(error));
    return errors;
}

}  // namespace tilth
