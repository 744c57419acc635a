// The facade's side of durability: when a snapshot of the world is taken, who writes it, and what became of it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tilth/cache/disk_worker.h"
#include "tilth/coarse_stage.h"
#include "tilth/detail_stage.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/ground/ground.h"
#include "tilth/store/changed_parts.h"
#include "tilth/store/editor.h"
#include "tilth/store/snapshot.h"
#include "tilth/store/world_folder.h"
#include "tilth/terrain.h"

namespace tilth {

/// Keeps a terrain's world folder up to date in the background.
///
/// A snapshot is due when the host asks for one, or when the journal holds `snapshot_edits` edits more than the pages.
/// It is taken at the end of a frame: codes are shared (a page is copied when it is next written), the coarse pages
/// that changed are copied. The disk worker then writes and commits it, and gives disk space back in steps. Thread: the
/// one that owns the context. GL state: the caller holds a `gl::StateGuard` where there is a context.
class WorldStage {
public:
    /// All outlive it. `coarse` and `detail` are nullptr without GL (`detail` also in a world without a detail map):
    /// then all of the map is in `ground`.
    WorldStage(Ground& ground, Editor& editor, const WorldSettings& settings, CoarseStage* coarse, DetailStage* detail);

    /// Without a cache: puts all tiles of the world into the ground, and the stamps that waited for them.
    Result<void> restore_detail(const RecoveredWorld& recovered);
    /// Edits that are about to be applied: notes what they change.
    void note(std::span<const GroundEdit> edits);
    /// At the end of a frame: takes in what the worker finished, and begins a snapshot that is due.
    void update(gl::FrameStats& stats);
    /// Asks for a snapshot of what is there at the end of this frame.
    void begin_save() { asked_ = true; }
    [[nodiscard]] bool is_saving() const { return asked_ || writing_ != nullptr; }
    /// Waits until a snapshot of everything is durable. Nothing is queued or deferred.
    Result<void> save(gl::FrameStats& stats);

    /// Once each, until it went well again.
    [[nodiscard]] std::vector<Error> take_errors();
    void report(std::vector<Error> errors) { errors_.insert(errors_.end(), errors.begin(), errors.end()); }

private:
    [[nodiscard]] WorldFolder& world() const { return *editor_.world(); }
    [[nodiscard]] bool is_due(double now_ms) const;
    bool is_prepared(gl::FrameStats& stats);
    bool begin(gl::FrameStats& stats);
    void submit(std::shared_ptr<DiskRequest> work);
    void poll(gl::StoreStats& stats);
    void finish(const std::shared_ptr<DiskRequest>& done, gl::StoreStats& stats);
    void begin_compaction();

    Ground& ground_;
    Editor& editor_;
    WorldSettings settings_;
    CoarseStage* coarse_;
    DetailStage* detail_;
    std::unique_ptr<DiskWorker> worker_;    ///< where there is no cache, which has one
    ChangedParts changed_;                  ///< with a cache, of the coarse map alone
    std::shared_ptr<Snapshot> snapshot_;    ///< that is being written
    std::shared_ptr<DiskRequest> writing_;  ///< its request
    std::shared_ptr<DiskRequest> compacting_;
    std::shared_ptr<bool> more_to_compact_ = std::make_shared<bool>(false);
    std::vector<Error> errors_;
    Result<void> outcome_;  ///< of the last snapshot
    bool asked_ = false, reported_ = false, compaction_failed_ = false;
    int preparing_ = 0;  ///< frames since read-backs for a snapshot were begun
    double retry_at_ms_ = 0, compact_at_ms_ = 0;
};

}  // namespace tilth
