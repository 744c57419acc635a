// A store that is slow and fails as a test wishes, round another that does the work.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/store/memory_store.h"
#include "tilth/store/tile_store.h"

namespace tilth::test {

/// Every load and save first waits (as long as it is held, then its latency), then perhaps fails, then is done by the
/// inner store. All members may be called from any thread. A worker that is to be destroyed while a call waits needs
/// `interrupt` first, or an `InterruptAtEnd` declared after it.
class FaultStore final : public TileStore {
public:
    struct Counts {
        std::uint64_t loads = 0, saves = 0;                ///< calls that came through the wait, failed ones included
        std::uint64_t failed_loads = 0, failed_saves = 0;  ///< of those
        friend bool operator==(const Counts&, const Counts&) = default;
    };

    explicit FaultStore(std::shared_ptr<TileStore> inner = std::make_shared<MemoryStore>())
        : inner_(std::move(inner)) {}

    Result<std::vector<TileIndex>> tiles() override { return inner_->tiles(); }

    Result<std::vector<Page>> load(TileIndex tile, const PageRect& pages) override {
        if (enter(tile, counts_.loads, counts_.failed_loads, failing_loads_)) return refused("read");
        return inner_->load(tile, pages);
    }
    Result<void> save(TileIndex tile, std::span<const Page> pages) override {
        if (enter(tile, counts_.saves, counts_.failed_saves, failing_saves_)) return refused("write");
        return inner_->save(tile, pages);
    }

    /// Calls wait until `release`; `let_through` lets some of them pass before.
    void hold() {
        change([this] { held_ = true, passes_ = 0; });
    }
    void let_through(std::uint64_t calls) {
        change([&] { passes_ += calls; });
    }
    void release() {
        change([this] { held_ = false; });
    }
    /// Each call takes at least this long.
    void set_latency(std::chrono::nanoseconds latency) {
        change([&] { latency_ = latency; });
    }
    /// From now on nothing waits, whatever was or will be set.
    void interrupt() {
        change([this] { interrupted_ = true; });
    }
    /// Until so many calls wait inside `load` and `save` (one, with one worker). False after `patience`.
    bool wait_until_waiting(std::uint64_t calls = 1, std::chrono::seconds patience = std::chrono::seconds(20)) {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, patience, [&] { return waiting_ >= calls; });
    }

    void fail_next_loads(std::uint64_t calls) {
        change([&] { failing_loads_ = calls; });
    }
    void fail_next_saves(std::uint64_t calls) {
        change([&] { failing_saves_ = calls; });
    }
    void fail_all(bool fail) {
        change([&] { fail_all_ = fail; });
    }
    /// Every call for this tile fails; nothing: none.
    void fail_tile(std::optional<TileIndex> tile) {
        change([&] { failing_tile_ = tile; });
    }

    [[nodiscard]] Counts counts() const {
        const std::lock_guard lock(mutex_);
        return counts_;
    }
    /// Tiles in the order in which their calls came through the wait.
    [[nodiscard]] std::vector<TileIndex> order() const {
        const std::lock_guard lock(mutex_);
        return order_;
    }

private:
    template <class Change>
    void change(const Change& set) {
        const std::lock_guard lock(mutex_);
        set();
        changed_.notify_all();
    }

    /// Waits, counts, and tells whether this call is to fail.
    bool enter(TileIndex tile, std::uint64_t& calls, std::uint64_t& failed, std::uint64_t& to_fail) {
        std::unique_lock lock(mutex_);
        ++waiting_;
        changed_.notify_all();
        changed_.wait(lock, [this] { return interrupted_ || !held_ || passes_ > 0; });
        if (!interrupted_ && held_) --passes_;
        const auto end = std::chrono::steady_clock::now() + latency_;
        if (latency_.count() > 0) changed_.wait_until(lock, end, [this] { return interrupted_; });
        --waiting_;
        ++calls;
        order_.push_back(tile);
        const bool fails = fail_all_ || failing_tile_ == tile || to_fail > 0;
        if (to_fail > 0) --to_fail;
        failed += fails ? 1 : 0;
        return fails;
    }
    static Error refused(const char* what) {
        return {ErrorCode::FileWrite, text("the test lets this ", what, " fail")};
    }

    const std::shared_ptr<TileStore> inner_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    bool held_ = false, interrupted_ = false, fail_all_ = false;
    std::uint64_t passes_ = 0, waiting_ = 0, failing_loads_ = 0, failing_saves_ = 0;
    std::chrono::nanoseconds latency_{0};
    std::optional<TileIndex> failing_tile_;
    Counts counts_;
    std::vector<TileIndex> order_;
};

/// Declared after whatever owns the worker: its calls no longer wait when that is destroyed.
class InterruptAtEnd {
public:
    explicit InterruptAtEnd(std::shared_ptr<FaultStore> store) : store_(std::move(store)) {}
    ~InterruptAtEnd() { store_->interrupt(); }
    InterruptAtEnd(const InterruptAtEnd&) = delete;
    InterruptAtEnd& operator=(const InterruptAtEnd&) = delete;

private:
    std::shared_ptr<FaultStore> store_;
};

}  // namespace tilth::test
