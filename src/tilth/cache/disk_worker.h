// The one thread that talks to the store.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/page.h"
#include "tilth/store/tile_store.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// Part of a tile to load, and what came.
struct LoadPiece {
    TileIndex tile;
    PageRect pages;
    std::uint64_t version = 0;  ///< the caller's: which save of the tile it expects
    std::vector<Page> loaded;   ///< when done
};

/// A request: made by the caller, worked on by the worker, given back with its outcome. Between `submit` and the return
/// only `cancel` may be called.
class DiskRequest {
public:
    enum class Kind : std::uint8_t { Load, Save, Work };

    static std::shared_ptr<DiskRequest> load(TileIndex tile, std::vector<LoadPiece> pieces, std::uint32_t priority);
    /// Shares the codes until the request is given back and released; they must not change meanwhile.
    static std::shared_ptr<DiskRequest> save(TileIndex tile, std::vector<Page> pages, std::uint32_t priority);

    /// Anything else that the store has to do between saves: a commit. It sees every save that was submitted before it
    /// and none that comes later. `work` shares nothing that the owner changes meanwhile; it is released on the owner's
    /// thread.
    static std::shared_ptr<DiskRequest> work(std::function<Result<void>()> work, std::uint32_t priority);

    /// A load that has not begun is given back as cancelled, without touching the store; one that has, before its next
    /// piece. A save and other work is always done.
    void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

    Kind kind = Kind::Load;
    TileIndex tile;
    std::uint32_t priority = 0;            ///< lower goes first; equal ones in the order of submission
    std::vector<LoadPiece> pieces;         ///< of a load
    std::vector<Page> pages;               ///< of a save
    std::function<Result<void>()> action;  ///< of other work
    bool was_cancelled = false;            ///< when given back: nothing was loaded
    Result<void> outcome;                  ///< when given back; the message names the tile, nothing was loaded
    double store_ms = 0;                   ///< when given back: how long the store took

private:
    friend class DiskWorker;
    std::atomic<bool> cancelled_{false};
    std::uint64_t number_ = 0;
};

/// Works through requests by priority, one at a time. Requests and answers travel through lock-free queues
/// (moodycamel::ConcurrentQueue); the thread sleeps while there is nothing to do.
///
/// Of two requests that name one tile, one of them a save, the earlier is done first, whatever the priorities: a load
/// finds the last save that was submitted before it, an older save never replaces a newer one. The earlier one then
/// goes with the urgency of the later. Other work keeps its place among the saves. Threads: all members are for one
/// thread, the owner's. Nothing waits but `wait` and the destructor.
class DiskWorker {
public:
    explicit DiskWorker(std::shared_ptr<TileStore> store);
    /// Does the saves and the work that are still queued, drops the loads, joins.
    ~DiskWorker();
    DiskWorker(const DiskWorker&) = delete;
    DiskWorker& operator=(const DiskWorker&) = delete;

    void submit(std::shared_ptr<DiskRequest> request);
    /// The next request that is done, in the order in which they were done; nullptr if none is. Never waits.
    std::shared_ptr<DiskRequest> poll();
    /// The same, waiting for it: outside frames only. Nullptr if nothing was submitted that has not been given back.
    std::shared_ptr<DiskRequest> wait();
    /// Submitted and not yet given back.
    [[nodiscard]] std::size_t outstanding() const { return outstanding_; }

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
    std::size_t outstanding_ = 0;
    std::uint64_t submitted_ = 0;
};

}  // namespace tilth
