// GCC says of the lock-free queue that ThreadSanitizer does not follow its fences; the queues below do without them
// (see Impl). Before the headers: that is where it says so.
#if defined(__SANITIZE_THREAD__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wtsan"
#endif

#include "tilth/cache/disk_worker.h"

#include <concurrentqueue/blockingconcurrentqueue.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>
#include <utility>

#include "tilth/core/checks.h"

namespace tilth {
namespace {

using RequestPtr = std::shared_ptr<DiskRequest>;

/// The tiles of a request, each once.
std::vector<TileIndex> tiles_of_request(const DiskRequest& request) {
    if (request.kind == DiskRequest::Kind::Work) return {};
    if (request.kind == DiskRequest::Kind::Save) return {request.tile};
    std::vector<TileIndex> tiles;
    for (const LoadPiece& piece : request.pieces)
        if (std::find(tiles.begin(), tiles.end(), piece.tile) == tiles.end()) tiles.push_back(piece.tile);
    return tiles;
}

/// Which request is next. By priority, then by number; but of two that name one tile, one of them a save, the earlier
/// goes first, and with the urgency of the later (or a save of no urgency would hold up an urgent load behind
/// everything). Other work and saves go in the order of their numbers, saves among themselves as above.
class RequestOrder {
public:
    [[nodiscard]] bool empty() const { return waiting_.empty(); }

    void add(std::uint64_t number, RequestPtr request) {
        for (const TileIndex tile : tiles_of_request(*request)) by_tile_[tile].emplace(number, request->kind);
        if (request->kind == DiskRequest::Kind::Save) saves_.insert(number);
        if (request->kind == DiskRequest::Kind::Work) works_.insert(number);
        by_priority_.emplace(request->priority, number);
        waiting_.emplace(number, std::move(request));
    }

    RequestPtr take_next() {
        std::uint64_t number = by_priority_.begin()->second;
        for (std::uint64_t earlier = blocker_of(number); earlier != number; earlier = blocker_of(number))
            number = earlier;
        return take(number);
    }

    RequestPtr take_oldest() { return take(waiting_.begin()->first); }

private:
    /// The first of the earlier requests that must be done before this one, or its own number.
    [[nodiscard]] std::uint64_t blocker_of(std::uint64_t number) const {
        const DiskRequest& request = *waiting_.at(number);
        std::uint64_t first = number;
        if (request.kind != DiskRequest::Kind::Load && !works_.empty()) first = std::min(first, *works_.begin());
        if (request.kind == DiskRequest::Kind::Work && !saves_.empty()) first = std::min(first, *saves_.begin());
        for (const TileIndex tile : tiles_of_request(request))
            for (const auto& [earlier, kind] : by_tile_.at(tile)) {
                if (earlier >= first) break;
                if (kind == DiskRequest::Kind::Save || request.kind == DiskRequest::Kind::Save) first = earlier;
            }
        return first;
    }

    RequestPtr take(std::uint64_t number) {
        const auto found = waiting_.find(number);
        RequestPtr request = std::move(found->second);
        waiting_.erase(found);
        by_priority_.erase({request->priority, number});
        saves_.erase(number);
        works_.erase(number);
        for (const TileIndex tile : tiles_of_request(*request)) {
            const auto queue = by_tile_.find(tile);
            queue->second.erase(number);
            if (queue->second.empty()) by_tile_.erase(queue);
        }
        return request;
    }

    std::map<std::uint64_t, RequestPtr> waiting_;
    std::set<std::pair<std::uint32_t, std::uint64_t>> by_priority_;
    std::map<TileIndex, std::map<std::uint64_t, DiskRequest::Kind>> by_tile_;
    std::set<std::uint64_t> saves_, works_;
};

RequestPtr made(DiskRequest::Kind kind, TileIndex tile, std::uint32_t priority) {
    auto request = std::make_shared<DiskRequest>();
    request->kind = kind;
    request->tile = tile;
    request->priority = priority;
    return request;
}

Error about(TileIndex tile, const char* what, const Error& error) {
    return {error.code, text(what, " detail tile (", tile.x, ", ", tile.z, "): ", error.message)};
}

}  // namespace

std::shared_ptr<DiskRequest> DiskRequest::load(TileIndex tile, std::vector<LoadPiece> pieces, std::uint32_t priority) {
    auto request = made(Kind::Load, tile, priority);
    request->pieces = std::move(pieces);
    return request;
}

std::shared_ptr<DiskRequest> DiskRequest::save(TileIndex tile, std::vector<Page> pages, std::uint32_t priority) {
    auto request = made(Kind::Save, tile, priority);
    request->pages = std::move(pages);
    return request;
}

std::shared_ptr<DiskRequest> DiskRequest::work(std::function<Result<void>()> work, std::uint32_t priority) {
    auto request = made(Kind::Work, {}, priority);
    request->action = std::move(work);
    return request;
}

/// What both threads see. A request belongs to the thread that took it from a queue last; an empty pointer tells the
/// worker to finish.
///
/// No producer tokens: without them the queues order the reuse of their blocks by plain acquire and release, which
/// ThreadSanitizer can follow (it knows no fences).
struct DiskWorker::Impl {
    explicit Impl(std::shared_ptr<TileStore> to) : store(std::move(to)) {}

    void run() {
        RequestOrder order;
        for (RequestPtr request;;) {
            if (order.empty())
                to_worker.wait_dequeue(request);
            else if (!to_worker.try_dequeue(request)) {
                finish(order.take_next());
                continue;
            }
            if (request == nullptr) break;
            const std::uint64_t number = request->number_;
            order.add(number, std::move(request));
        }
        while (!order.empty()) finish(order.take_oldest());
    }

    /// Does the request and gives it back. Its last share goes with it: pages are released on the owner's thread.
    void finish(RequestPtr request) {
        const auto start = std::chrono::steady_clock::now();
        switch (request->kind) {
            case DiskRequest::Kind::Load:
                load(*request);
                break;
            case DiskRequest::Kind::Save:
                save(*request);
                break;
            case DiskRequest::Kind::Work:
                request->outcome = request->action();
                break;
        }
        request->store_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        to_owner.enqueue(std::move(request));
    }

    void save(DiskRequest& request) {
        if (const Result<void> saved = store->save(request.tile, request.pages); !saved.ok())
            request.outcome = about(request.tile, "save", saved.error());
    }

    void load(DiskRequest& request) {
        for (LoadPiece& piece : request.pieces) {
            request.was_cancelled = given_up(request);
            if (request.was_cancelled) break;
            Result<std::vector<Page>> loaded = store->load(piece.tile, piece.pages);
            if (!loaded.ok()) {
                request.outcome = about(piece.tile, "load", loaded.error());
                break;
            }
            piece.loaded = *std::move(loaded);
        }
        if (request.was_cancelled || !request.outcome.ok())
            for (LoadPiece& piece : request.pieces) piece.loaded.clear();
    }
    [[nodiscard]] bool given_up(const DiskRequest& request) const {
        return stopping.load(std::memory_order_relaxed) || request.cancelled_.load(std::memory_order_relaxed);
    }

    std::shared_ptr<TileStore> store;
    moodycamel::BlockingConcurrentQueue<RequestPtr> to_worker, to_owner;
    std::atomic<bool> stopping{false};
    std::thread thread;
};

DiskWorker::DiskWorker(std::shared_ptr<TileStore> store) : impl_(std::make_unique<Impl>(std::move(store))) {
    impl_->thread = std::thread([impl = impl_.get()] { impl->run(); });
}

DiskWorker::~DiskWorker() {
    impl_->stopping.store(true, std::memory_order_relaxed);
    impl_->to_worker.enqueue(nullptr);
    impl_->thread.join();
}

void DiskWorker::submit(std::shared_ptr<DiskRequest> request) {
    TILTH_ASSERT(request != nullptr, "a disk request that is not there");
    request->number_ = ++submitted_;
    ++outstanding_;
    impl_->to_worker.enqueue(std::move(request));
}

std::shared_ptr<DiskRequest> DiskWorker::poll() {
    RequestPtr request;
    if (impl_->to_owner.try_dequeue(request)) --outstanding_;
    return request;
}

std::shared_ptr<DiskRequest> DiskWorker::wait() {
    if (outstanding_ == 0) return nullptr;
    RequestPtr request;
    impl_->to_owner.wait_dequeue(request);
    --outstanding_;
    return request;
}

}  // namespace tilth
