// The thread that talks to the store: order, priority, cancellation, errors, and its end. Run under ThreadSanitizer.
#include "tilth/cache/disk_worker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>
#include <vector>

#include "support/fault_store.h"
#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

using Request = std::shared_ptr<DiskRequest>;
using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

PageRect page_of_tile(TileIndex tile) { return {{tile.x, tile.z}, {tile.x + 1, tile.z + 1}}; }

/// A load of one page of each of `tiles`: as if a tile were one page.
Request load_of(const std::vector<TileIndex>& tiles, std::uint32_t priority = 0) {
    std::vector<LoadPiece> pieces;
    for (const TileIndex tile : tiles) pieces.push_back({.tile = tile, .pages = page_of_tile(tile)});
    return DiskRequest::load(tiles[0], std::move(pieces), priority);
}
Request save_of(TileIndex tile, std::uint32_t code, std::uint32_t priority = 0) {
    Page page{{tile.x, tile.z}, std::make_shared<PageCodes>()};
    page.codes->fill(code);
    return DiskRequest::save(tile, {page}, priority);
}
/// What a piece found; 0: no page.
std::uint32_t code_in(const Request& request, std::size_t piece = 0) {
    const std::vector<Page>& pages = request->pieces[piece].loaded;
    return pages.empty() ? 0 : pages[0].codes->at(100);
}

class DiskWorkerTest : public testing::Test {
protected:
    std::shared_ptr<test::FaultStore> store = std::make_shared<test::FaultStore>();
    DiskWorker worker{store};
    test::InterruptAtEnd interrupt{store};

    /// Puts the worker to work on a request that waits, so that what is submitted next meets in its queue.
    void occupy() {
        store->hold();
        worker.submit(load_of({{1000, 1000}}));
        ASSERT_TRUE(store->wait_until_waiting());
    }
    /// Lets it go on; what comes back, without the request that occupied it.
    std::vector<Request> finish() {
        store->release();
        std::vector<Request> done;
        while (Request request = worker.wait())
            if (request->tile != TileIndex{1000, 1000}) done.push_back(std::move(request));
        return done;
    }
};

TEST_F(DiskWorkerTest, SavesAndLoads) {
    worker.submit(save_of({2, 3}, 77));
    worker.submit(load_of({{2, 3}, {4, 4}}));
    EXPECT_EQ(worker.outstanding(), 2u);
    const Request saved = worker.wait(), loaded = worker.wait();
    EXPECT_EQ(worker.outstanding(), 0u);
    EXPECT_EQ(worker.wait(), nullptr);
    EXPECT_EQ(worker.poll(), nullptr);
    ASSERT_TRUE(saved->outcome.ok() && loaded->outcome.ok());
    EXPECT_FALSE(saved->was_cancelled || loaded->was_cancelled);
    EXPECT_EQ(code_in(loaded, 0), 77u);
    EXPECT_EQ(code_in(loaded, 1), 0u);
}

TEST_F(DiskWorkerTest, OtherWorkKeepsItsPlaceAmongTheSaves) {
    SplitMix64 random{4};
    for (int round = 0; round < 50; ++round) {
        occupy();
        std::map<TileIndex, std::uint32_t> expected;
        struct Seen {
            std::map<TileIndex, std::uint32_t> wanted, found;
        };
        std::vector<std::shared_ptr<Seen>> commits;
        for (std::uint32_t i = 1; i <= 30; ++i) {
            const auto priority = static_cast<std::uint32_t>(random.next() % 4);
            const TileIndex tile{static_cast<std::int32_t>(random.next() % 3), 0};
            if (random.next() % 3 != 0) {
                worker.submit(save_of(tile, i, priority));
                expected[tile] = i;
                continue;
            }
            const auto seen = std::make_shared<Seen>();
            seen->wanted = expected;
            commits.push_back(seen);
            worker.submit(DiskRequest::work(
                [seen, inner = store]() -> Result<void> {
                    for (const auto& [at, code] : seen->wanted) {
                        Result<std::vector<Page>> pages = inner->load(at, page_of_tile(at));
                        if (!pages) return pages.error();
                        seen->found[at] = pages->empty() ? 0 : pages->front().codes->at(0);
                    }
                    return Error{ErrorCode::FileWrite, "the test's own"};
                },
                priority));
        }
        for (const Request& done : finish()) {
            EXPECT_EQ(done->outcome.ok(), done->kind != DiskRequest::Kind::Work);
        }
        for (const std::shared_ptr<Seen>& commit : commits)
            EXPECT_EQ(commit->found, commit->wanted) << "all saves before it and none behind it";
        for (std::int32_t x = 0; x < 3; ++x) {  // the next round begins empty
            worker.submit(DiskRequest::save({x, 0}, {}, 0));
            worker.wait();
        }
    }
}

TEST_F(DiskWorkerTest, PollNeverWaits) {
    EXPECT_EQ(worker.poll(), nullptr);
    occupy();
    EXPECT_EQ(worker.poll(), nullptr);  // would hang here
    EXPECT_EQ(worker.outstanding(), 1u);
    store->release();
    Request done;
    while (done == nullptr) done = worker.poll(), std::this_thread::yield();
    EXPECT_EQ(worker.outstanding(), 0u);
}

TEST_F(DiskWorkerTest, GoesByPriorityThenByOrder) {
    occupy();
    const std::uint32_t priorities[] = {5, 1, 3, 1, 0, 5, 3, 0};
    for (std::int32_t i = 0; i < 8; ++i) worker.submit(load_of({{i, 0}}, priorities[i]));
    std::vector<std::int32_t> order;
    for (const Request& request : finish()) order.push_back(request->tile.x);
    EXPECT_EQ(order, (std::vector<std::int32_t>{4, 7, 1, 3, 2, 6, 0, 5}));
}

TEST_F(DiskWorkerTest, ALoadNeverOvertakesASaveOfItsTiles) {
    occupy();
    worker.submit(save_of({1, 1}, 11, 9));
    worker.submit(save_of({2, 2}, 22, 8));
    worker.submit(save_of({3, 3}, 33, 9));
    worker.submit(load_of({{0, 0}, {1, 1}, {3, 3}}, 0));  // names them as its second and third piece
    worker.submit(load_of({{5, 5}}, 4));
    std::vector<std::int32_t> order;
    for (const Request& request : finish()) {
        order.push_back(request->tile.x);
        if (request->tile.x == 0) {
            EXPECT_EQ(code_in(request, 1), 11u);
            EXPECT_EQ(code_in(request, 2), 33u);
        }
    }
    // The saves that the urgent load waits for go with its urgency, before what is more urgent than they are.
    EXPECT_EQ(order, (std::vector<std::int32_t>{1, 3, 0, 5, 2}));
}

TEST_F(DiskWorkerTest, AnOlderSaveNeverReplacesANewerOne) {
    occupy();
    worker.submit(save_of({1, 1}, 10, 7));
    worker.submit(load_of({{1, 1}}, 9));
    worker.submit(save_of({1, 1}, 20, 0));
    worker.submit(save_of({1, 1}, 30, 3));
    worker.submit(load_of({{1, 1}}, 0));
    std::vector<std::uint32_t> found;
    for (const Request& request : finish())
        if (request->kind == DiskRequest::Kind::Load) found.push_back(code_in(request));
    EXPECT_EQ(found, (std::vector<std::uint32_t>{10, 30}));
}

TEST_F(DiskWorkerTest, ACancelledLoadDoesNotTouchTheStore) {
    occupy();
    const Request load = load_of({{1, 1}}), save = save_of({2, 2}, 5);
    worker.submit(load);
    worker.submit(save);
    load->cancel();
    save->cancel();
    const std::vector<Request> done = finish();
    ASSERT_EQ(done.size(), 2u);
    EXPECT_TRUE(load->was_cancelled && load->outcome.ok());
    EXPECT_FALSE(save->was_cancelled);
    EXPECT_EQ(store->counts(),
              (test::FaultStore::Counts{.loads = 1, .saves = 1}));  // of the loads the one that occupied
    worker.submit(load_of({{2, 2}}));
    EXPECT_EQ(code_in(worker.wait()), 5u);
}

TEST_F(DiskWorkerTest, ACancelledLoadStopsBeforeItsNextPiece) {
    store->hold();
    const Request load = load_of({{1, 1}, {2, 2}, {3, 3}});
    worker.submit(load);
    ASSERT_TRUE(store->wait_until_waiting());
    load->cancel();
    EXPECT_EQ(finish().size(), 1u);
    EXPECT_TRUE(load->was_cancelled);
    EXPECT_EQ(store->counts().loads, 1u);
}

TEST_F(DiskWorkerTest, ErrorsComeBackWithTheirRequest) {
    worker.submit(save_of({7, 8}, 1));
    worker.submit(save_of({1, 2}, 1));
    ASSERT_NE(worker.wait(), nullptr);
    ASSERT_NE(worker.wait(), nullptr);
    store->fail_tile(TileIndex{7, 8});
    worker.submit(load_of({{1, 2}, {7, 8}, {3, 3}}));
    worker.submit(load_of({{1, 2}}));
    worker.submit(save_of({7, 8}, 2));
    const Request loads = worker.wait(), load = worker.wait(), save = worker.wait();
    ASSERT_FALSE(loads->outcome.ok());
    EXPECT_EQ(loads->outcome.error().code, ErrorCode::FileWrite);
    EXPECT_NE(loads->outcome.error().message.find("tile (7, 8)"), std::string::npos) << loads->outcome.error().message;
    EXPECT_NE(loads->outcome.error().message.find("the test lets this read fail"), std::string::npos);
    EXPECT_EQ(code_in(loads), 0u) << "part of a load that failed";
    EXPECT_FALSE(loads->was_cancelled);
    EXPECT_TRUE(load->outcome.ok());
    ASSERT_FALSE(save->outcome.ok());
    EXPECT_NE(save->outcome.error().message.find("tile (7, 8)"), std::string::npos);
    EXPECT_EQ(store->counts().loads, 3u);  // the piece behind the failing one was not tried
}

TEST_F(DiskWorkerTest, TellsHowLongTheStoreTook) {
    store->set_latency(20ms);
    worker.submit(load_of({{1, 1}, {2, 2}}));
    EXPECT_GE(worker.wait()->store_ms, 40);
}

TEST_F(DiskWorkerTest, PagesAreGivenBackWithTheRequest) {
    Page page{{0, 0}, std::make_shared<PageCodes>()};
    for (int i = 0; i < 200; ++i) {
        worker.submit(DiskRequest::save({0, 0}, {page}, 0));
        worker.wait();
        // The field copies a page that is shared before it writes: nothing but the request may have held it.
        ASSERT_EQ(page.codes.use_count(), 1);
        page.codes->fill(static_cast<std::uint32_t>(i));  // a race if the worker still read it
    }
}

TEST(DiskWorkerEnd, DoesTheSavesAndDropsTheLoads) {
    auto memory = std::make_shared<MemoryStore>();
    auto store = std::make_shared<test::FaultStore>(memory);
    {
        DiskWorker worker(store);
        const test::InterruptAtEnd interrupt(store);
        store->hold();
        worker.submit(load_of({{0, 0}, {0, 1}, {0, 2}}));
        ASSERT_TRUE(store->wait_until_waiting());
        for (std::int32_t i = 0; i < 50; ++i) {
            worker.submit(save_of({i, 1}, 1, static_cast<std::uint32_t>(i % 7)));
            worker.submit(load_of({{i, 1}}));
            worker.submit(save_of({i, 1}, 2, static_cast<std::uint32_t>(6 - i % 7)));
        }
        EXPECT_EQ(worker.outstanding(), 151u);
    }
    EXPECT_EQ(store->counts().saves, 100u);
    // The load in the store's hands may have begun with its next piece before the end was known.
    EXPECT_LE(store->counts().loads, 60u);
    EXPECT_EQ(store.use_count(), 1);
    for (std::int32_t i = 0; i < 50; ++i) {
        const std::vector<Page> pages = *memory->load({i, 1}, page_of_tile({i, 1}));
        ASSERT_EQ(pages.size(), 1u);
        EXPECT_EQ(pages[0].codes->front(), 2u);
    }
}

TEST(DiskWorkerEnd, EndsIdleAndAtOnce) {
    for (int i = 0; i < 50; ++i) DiskWorker worker(std::make_shared<MemoryStore>());
}

// Random requests of both kinds, cancellations and failures, against what one thread doing them in the order of
// submission would have found. Different tiles may be exchanged; of one tile each load sees the last save before it.
TEST(DiskWorkerModel, TenThousandRequests) {
    auto store = std::make_shared<test::FaultStore>();
    DiskWorker worker(store);
    const test::InterruptAtEnd interrupt(store);
    SplitMix64 random{31};
    std::map<TileIndex, std::uint32_t> model;
    std::map<const DiskRequest*, std::vector<std::uint32_t>> expected;
    std::size_t done = 0, cancelled = 0, compared = 0;

    const auto check = [&](const Request& request) {
        ASSERT_TRUE(request->outcome.ok());
        ++done;
        if (request->kind == DiskRequest::Kind::Save) return;
        const auto wanted = expected.extract(request.get());
        ASSERT_FALSE(wanted.empty());
        if (request->was_cancelled) {
            ++cancelled;
            return;
        }
        for (std::size_t i = 0; i < request->pieces.size(); ++i) {
            ASSERT_EQ(code_in(request, i), wanted.mapped()[i]);
            ++compared;
        }
    };
    std::vector<Request> recent;
    for (std::uint32_t i = 1; i <= 10000; ++i) {
        const auto tile = [&] {
            return TileIndex{static_cast<std::int32_t>(random.next() % 4),
                             static_cast<std::int32_t>(random.next() % 4)};
        };
        const auto priority = static_cast<std::uint32_t>(random.next() % 5);
        Request request;
        if (random.next() % 2 == 0) {
            const TileIndex to = tile();
            request = save_of(to, i, priority);
            model[to] = i;
        } else {
            std::vector<TileIndex> tiles;
            for (std::uint64_t count = 1 + random.next() % 3; count > 0; --count) tiles.push_back(tile());
            request = load_of(tiles, priority);
            for (const TileIndex t : tiles) expected[request.get()].push_back(model[t]);
        }
        recent.push_back(request);
        worker.submit(std::move(request));
        if (random.next() % 10 == 0) recent[random.next() % recent.size()]->cancel();
        if (recent.size() > 30) recent.erase(recent.begin());
        if (random.next() % 100 == 0) store->set_latency(random.next() % 2 == 0 ? 0ms : std::chrono::microseconds(50));
        while (worker.outstanding() > 300 || random.next() % 3 == 0) {
            const Request back = worker.outstanding() > 300 ? worker.wait() : worker.poll();
            if (back == nullptr) break;
            check(back);
            if (HasFatalFailure()) return;
        }
    }
    while (const Request back = worker.wait()) {
        check(back);
        if (HasFatalFailure()) return;
    }
    EXPECT_EQ(done, 10000u);
    EXPECT_TRUE(expected.empty());
    EXPECT_GT(cancelled, 10u);
    EXPECT_GT(compared, 5000u);
}

}  // namespace
}  // namespace tilth
