// Opening a world: what its store holds as of the last commit, and what becomes of damage there.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/store/blob_store.h"
#include "tilth/store/world_blobs.h"
#include "tilth/store/world_folder.h"
#include "tilth/store/world_pages.h"
#include "tilth/store/world_repair.h"

namespace tilth {

/// Reads everything but detail pages. What is damaged is made again where the journal reaches, and put back into the
/// store; else it is left out. Both is reported. Where a part of the history is lost, edits of the tail that undo or
/// redo what is not there any more are dropped from the tail, and reported.
class WorldRecovery {
public:
    WorldRecovery(BlobStore& blobs, WorldPages& pages, WorldRepair& repair, std::string name, HeightPrecision precision)
        : blobs_(blobs), pages_(pages), repair_(repair), name_(std::move(name)), precision_(precision) {}

    /// `recovered.tail` is there. `lost_blobs`: what the store reports where blobs may be missing or old ones, and
    /// nobody knows which; then every page is compared with what the journal says. Fails where the store cannot be read
    /// or written, and where something is damaged and what it is made of cannot be read now.
    Result<void> run(const std::vector<Error>& lost_blobs, RecoveredWorld& recovered);

    /// Strokes that the store has, with the number of their parts.
    [[nodiscard]] const std::map<std::uint64_t, std::uint32_t>& stroke_parts() const { return stroke_parts_; }

private:
    Result<void> read_counters(bool may_be_old);
    Result<void> read_waiting();
    Result<void> read_coarse();
    Result<void> read_strokes();
    Result<void> restore_list(const std::vector<std::uint64_t>& numbers, bool are_done, std::vector<StrokePtr>& out);
    Result<void> restore_counters();
    Result<StrokePtr> made_again(std::uint64_t number, bool is_done, std::size_t from_last);
    Result<void> put_stroke(const Stroke& stroke);
    Result<void> rebuild_tile(TileIndex tile);
    Result<void> check_everything(const std::vector<Error>& lost_blobs);
    Result<void> check_pages(MapKind map, const std::set<PageIndex>& pages);
    void drop_lost_turns();
    void report(const Error& damage, const std::string& outcome);

    BlobStore& blobs_;
    WorldPages& pages_;
    WorldRepair& repair_;
    std::string name_;
    HeightPrecision precision_;
    RecoveredWorld* out_ = nullptr;
    WorldCounters counters_;
    std::uint64_t mark_ = 0;
    std::set<TileIndex> rebuilt_tiles_;  ///< with stamps that strokes in the store have no images of
    bool has_counters_ = true, history_is_cut_ = false;
    std::map<std::uint64_t, std::uint32_t> stroke_parts_;
};

/// Parts of one stroke from the store, decoded. Fails (`is_damage`) where they are damaged or incomplete.
Result<StrokePtr> read_stroke(BlobStore& blobs, std::uint64_t number, const std::string& name);

}  // namespace tilth
