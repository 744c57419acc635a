// The cache, case by case: what one stamp, one walk, one slow or failing request does.
#include "tilth/cache/tile_cache.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include "cache/support/cache_world.h"

namespace tilth {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;
using test::CacheWorld;
using test::CacheWorldSettings;

class TileCacheTest : public testing::TestWithParam<bool> {
protected:
    [[nodiscard]] CacheWorldSettings settings(std::uint64_t seed = 1) const {
        return {.cache = {.gpu_executor = GetParam()}, .seed = seed};
    }
    static StampRequest dent(const CacheWorld& world, double x_texels, double z_texels, double radius_texels = 5,
                             StampRule rule = StampRule::Add) {
        return {.shape = test::builtin(BuiltinProfile::Cosine),
                .centre = world.at(x_texels, z_texels),
                .radius_m = radius_texels * world.texel_m(),
                .amplitude_m = rule == StampRule::Smooth ? 0.8 : -0.25,
                .map = MapChoice::Detail,
                .rule = rule};
    }
    static CachedTile tile(const CacheWorld& world, TileIndex index) {
        for (const CachedTile& cached : world.cache->tiles())
            if (cached.tile == index) return cached;
        return {.tile = {-1, -1}};
    }
    static TileState state(const CacheWorld& world, TileIndex index) { return world.cache->state(index); }

    /// Frames until `reached`; the worker gets time to work. False after 10 s.
    static bool frames_until(CacheWorld& world, PostPos viewer, const std::function<bool()>& reached) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
        while (!reached()) {
            if (std::chrono::steady_clock::now() > end) return false;
            world.frame(viewer);
            std::this_thread::sleep_for(1ms);
        }
        return true;
    }
    /// Every tile has been brought into memory, with what waited for it, and saved again; nothing is in memory.
    static bool store_everything(CacheWorld& world) {
        std::vector<TileIndex> every;
        for (const CachedTile& cached : world.cache->tiles()) every.push_back(cached.tile);
        return world.cache->require(every, world.stats, world.deform).ok() && leave(world);
    }
    /// What was in memory is in the store.
    static bool leave(CacheWorld& world) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
        while (!world.cache->is_idle()) {
            if (std::chrono::steady_clock::now() > end) return false;
            world.frame(std::span<const PostPos>{});
            std::this_thread::sleep_for(1ms);
        }
        return true;
    }
};
INSTANTIATE_TEST_SUITE_P(Executors, TileCacheTest, testing::ValuesIn(test::kBothExecutors),
                         [](const auto& tested) { return std::string(tested.param ? "gpu" : "cpu"); });

constexpr PostPos kMiddle{320, 320};  // the corner of tiles (4, 4) to (5, 5)

TEST_P(TileCacheTest, UntouchedGroundCostsNothing) {
    CacheWorld world(settings());
    test::Walker walker(world.random, 640, 5);
    for (int i = 0; i < 2000; ++i) world.frame(walker.step());
    EXPECT_EQ(world.textures.acquired(), 0u);
    EXPECT_EQ(world.textures.passes(), 0u);
    EXPECT_EQ(world.store->counts(), test::FaultStore::Counts{});
    EXPECT_TRUE(world.cache->tiles().empty());
    EXPECT_TRUE(world.cached->detail().pages().empty());
    EXPECT_EQ(world.stats.missing_active, 0u);
    EXPECT_TRUE(world.cache->is_idle());
    world.expect_equal_hash();
}

// Smooth and stamps off the map on untouched ground change nothing, and make nothing.
TEST_P(TileCacheTest, SmoothOfNothingCostsNothing) {
    CacheWorld world(settings());
    const StampRequest requests[] = {dent(world, 320, 320, 30, StampRule::Smooth), dent(world, -500, 300)};
    world.frame(kMiddle, requests);
    EXPECT_TRUE(world.cache->tiles().empty());
    EXPECT_EQ(world.textures.acquired(), 0u);
    world.expect_equal_hash();
}

TEST_P(TileCacheTest, TheFirstStampIsThereInItsFrame) {
    CacheWorld world(settings());
    world.frame(kMiddle);
    const StampRequest request = dent(world, 300, 300);
    world.frame(kMiddle, {&request, 1});
    EXPECT_EQ(world.textures.count(), 1u);  // one tile un-shared, not its neighbours
    EXPECT_TRUE(world.cache->can_be_drawn({4, 4}));
    EXPECT_NE(world.textures.code({4, 4}, {300, 300}), kMidCode);
    EXPECT_EQ(world.wrong_texels(), 0);
    EXPECT_EQ(world.store->counts(), test::FaultStore::Counts{});  // nothing is asked for what was never saved
    EXPECT_TRUE(world.cache->take_arrivals().empty());
    world.expect_equal_in_the_end(kMiddle);
}

// The first stamp of all lies on the border of a tile that no viewer is near and of one that is kept for him.
TEST_P(TileCacheTest, AFirstStampAcrossTheEdgeOfWhatIsKept) {
    for (const auto& [x, z] : {std::pair{290, 192}, std::pair{192, 290}, std::pair{384, 290}, std::pair{290, 384},
                               std::pair{192, 192}, std::pair{384, 192}, std::pair{192, 384}, std::pair{384, 384}}) {
        CacheWorld world(settings());
        const PostPos viewer{288, 288};  // tile (4, 4); (3, 3) to (5, 5) are kept
        const StampRequest request = dent(world, x, z);
        world.frame(viewer, {&request, 1});
        EXPECT_EQ(world.wrong_texels(), 0) << x << ", " << z;
        // And with textures that are filled from memory, for whichever executor.
        world.expect_equal_in_the_end({20, 600});
        world.expect_equal_in_the_end(viewer);
    }
}

// S8.
TEST_P(TileCacheTest, AFourTileCornerAfterManyStamps) {
    CacheWorldSettings many = settings(7);
    many.posts = 43;  // 127 texels: four tiles, the last ones cut
    CacheWorld world(many);
    const PostPos corner{64, 64};
    for (int frame = 0; frame < 1000; ++frame) {
        std::vector<StampRequest> requests;
        for (int i = 0; i < 10; ++i) requests.push_back(world.random_stamp(corner, i == 0 ? 0 : 12));
        world.frame(corner, requests);
        if (HasFatalFailure()) return;
        ASSERT_TRUE(frame % 50 != 0 || world.wrong_texels() == 0) << frame;
    }
    EXPECT_EQ(world.textures.count(), 4u);
    const TexelRect shared{{62, 62}, {66, 66}};  // in all four
    for (std::int32_t z = shared.min.z; z < shared.max.z; ++z)
        for (std::int32_t x = shared.min.x; x < shared.max.x; ++x)
            for (const TileIndex index : {TileIndex{1, 0}, TileIndex{0, 1}, TileIndex{1, 1}})
                ASSERT_EQ(world.textures.code(index, {x, z}), world.textures.code({0, 0}, {x, z})) << x << " " << z;
    world.expect_equal_in_the_end(corner);
}

// S3.
TEST_P(TileCacheTest, AStampLargerThanNineTiles) {
    for (const StampRule rule : {StampRule::Add, StampRule::Set, StampRule::Smooth}) {
        CacheWorld world(settings());
        std::vector<StampRequest> requests;
        for (int i = 0; i < 30; ++i) requests.push_back(world.random_stamp(kMiddle, 320, false));
        requests.push_back(dent(world, 330, 310, 290, rule));
        requests.push_back(dent(world, 300, 340, 60));
        world.frame(kMiddle, requests);
        EXPECT_LE(world.textures.count(), 9u);
        world.expect_equal_in_the_end(kMiddle);
        for (const PostPos corner : {PostPos{20, 20}, PostPos{600, 20}, PostPos{100, 620}})
            world.expect_equal_in_the_end(corner);
    }
}

// P7: the store takes as long as it likes, the frames go on without it.
TEST_P(TileCacheTest, FramesGoOnWhileTheStoreIsSlow) {
    CacheWorld world(settings());
    const StampRequest first = dent(world, 300, 300);
    world.frame(kMiddle, {&first, 1});
    ASSERT_TRUE(leave(world));
    world.store->hold();  // as a disk of two seconds a tile would
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 125; ++i) {  // two seconds of frames
        const StampRequest more = dent(world, 280 + i % 40, 300, 3);
        world.frame(kMiddle, {&more, 1});
        ASSERT_EQ(state(world, {4, 4}), TileState::Loading);
        ASSERT_FALSE(world.cache->can_be_drawn({4, 4}));
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, 5s);  // a frame that waited would wait for ever
    EXPECT_GE(world.stats.missing_active, 125u);
    EXPECT_EQ(world.wrong_texels(), 0);
    EXPECT_TRUE(world.cache->take_errors().empty());
    world.store->release();
    ASSERT_TRUE(frames_until(world, kMiddle, [&] { return world.cache->can_be_drawn({4, 4}); }));
    EXPECT_GE(world.stats.late_stamps, 100u);
    EXPECT_EQ(world.wrong_texels(), 0);
    const std::vector<CachedArrival> arrivals = world.cache->take_arrivals();
    ASSERT_FALSE(arrivals.empty());
    EXPECT_EQ(arrivals[0].lead_texels, 0);  // late
    EXPECT_GE(arrivals[0].loading_ms, 125 * 16.0);
    world.expect_equal_in_the_end(kMiddle);
}

TEST_P(TileCacheTest, AFailingLoadIsReportedOnceAndTriedAgain) {
    CacheWorld world(settings());
    const StampRequest request = dent(world, 300, 300);
    world.frame(kMiddle, {&request, 1});
    ASSERT_TRUE(leave(world));
    for (int trouble = 0; trouble < 2; ++trouble) {
        world.store->fail_tile(TileIndex{4, 4});
        ASSERT_TRUE(frames_until(world, kMiddle, [&] { return world.stats.failures >= 3; }));
        const std::vector<Error> errors = world.cache->take_errors();
        ASSERT_EQ(errors.size(), 1u);
        EXPECT_NE(errors[0].message.find("tile (4, 4)"), std::string::npos) << errors[0].message;
        const StampRequest meanwhile = dent(world, 296, 304);
        world.frame(kMiddle, {&meanwhile, 1});
        EXPECT_EQ(tile(world, {4, 4}).pending, 1u);
        world.store->fail_tile(std::nullopt);
        ASSERT_TRUE(frames_until(world, kMiddle, [&] { return world.cache->can_be_drawn({4, 4}); }));
        EXPECT_TRUE(world.cache->take_errors().empty());
        EXPECT_EQ(world.wrong_texels(), 0);
        ASSERT_TRUE(leave(world));
        world.stats = {};  // and once more: news again, since it went well between
    }
    world.expect_equal_in_the_end(kMiddle);
}

TEST_P(TileCacheTest, PausesGrowWhileTheStoreFails) {
    CacheWorldSettings slow = settings();
    slow.cache.least_retry_ms = 100, slow.cache.most_retry_ms = 800;
    CacheWorld world(slow);
    const StampRequest request = dent(world, 300, 300);
    world.frame(kMiddle, {&request, 1});
    ASSERT_TRUE(leave(world));
    world.store->fail_all(true);
    for (int i = 0; i < 625; ++i) {  // ten seconds of frames
        world.frame(kMiddle);
        if (state(world, {4, 4}) == TileState::Loading) std::this_thread::sleep_for(1ms);
    }
    // 100, 200, 400, then 800 ms apart: about 15 in 10 s; never more than that, whatever the threads did.
    EXPECT_LE(world.stats.failures, 18u);
    EXPECT_GE(world.stats.failures, 5u);
}

TEST_P(TileCacheTest, AFailingSaveKeepsTheEdit) {
    CacheWorld world(settings());
    const StampRequest request = dent(world, 300, 300);
    world.frame(kMiddle, {&request, 1});
    world.store->fail_all(true);
    const PostPos away{20, 20};
    ASSERT_TRUE(frames_until(world, away, [&] { return world.stats.failures >= 3; }));
    EXPECT_EQ(world.cache->take_errors().size(), 1u);
    EXPECT_TRUE(tile(world, {4, 4}).modified);
    EXPECT_EQ(state(world, {4, 4}), TileState::Saving);
    const StampRequest meanwhile = dent(world, 296, 304);
    world.frame(away, {&meanwhile, 1});
    world.store->fail_all(false);
    ASSERT_TRUE(frames_until(world, away, [&] { return state(world, {4, 4}) == TileState::Absent; }));
    EXPECT_FALSE(tile(world, {4, 4}).modified);
    EXPECT_TRUE(world.cache->take_errors().empty());
    EXPECT_EQ(world.textures.count(), 0u);
    world.expect_equal_in_the_end(away);
}

TEST_P(TileCacheTest, ATileOnItsWayOutIsRescued) {
    CacheWorld world(settings());
    const StampRequest first = dent(world, 300, 300), second = dent(world, 310, 300), third = dent(world, 290, 290);
    world.frame(kMiddle, {&first, 1});
    world.store->hold();
    ASSERT_TRUE(frames_until(world, {20, 20}, [&] { return state(world, {4, 4}) == TileState::Saving; }));
    world.frame({20, 20}, {&second, 1});  // stamped while it is written
    world.frame(kMiddle, {&third, 1});
    EXPECT_EQ(world.stats.rescues, 1u);
    ASSERT_TRUE(frames_until(world, kMiddle, [&] { return world.cache->can_be_drawn({4, 4}); }));
    EXPECT_EQ(world.stats.loads, 0u);
    EXPECT_EQ(world.wrong_texels(), 0);
    world.store->release();
    ASSERT_TRUE(leave(world));  // what came while it was written is written too
    EXPECT_FALSE(tile(world, {4, 4}).modified);
    world.expect_equal_in_the_end(kMiddle);
}

// Rescued and left again while the first save is still being written: its textures need not wait for that.
TEST_P(TileCacheTest, ATileThatIsLeftTwiceKeepsNoTextures) {
    CacheWorld world(settings());
    const StampRequest first = dent(world, 300, 300), second = dent(world, 310, 300);
    const PostPos away{20, 20};
    world.frame(kMiddle, {&first, 1});
    world.store->hold();
    ASSERT_TRUE(frames_until(world, away, [&] { return world.textures.count() == 0; }));  // read back, handed over
    ASSERT_EQ(state(world, {4, 4}), TileState::Saving);
    ASSERT_TRUE(world.store->wait_until_waiting());
    ASSERT_TRUE(frames_until(world, kMiddle, [&] { return world.cache->can_be_drawn({4, 4}); }));
    world.frame(kMiddle, {&second, 1});
    for (int i = 0; i < 10; ++i) world.frame(away);  // time enough for read-backs
    EXPECT_EQ(world.textures.count(), 0u);
    world.store->release();
    ASSERT_TRUE(leave(world));
    world.expect_equal_in_the_end(kMiddle);
}

TEST_P(TileCacheTest, ALoadThatNobodyWantsAnyMoreIsCancelled) {
    CacheWorld world(settings());
    const StampRequest requests[] = {dent(world, 300, 300), dent(world, 340, 300), dent(world, 300, 340),
                                     dent(world, 340, 340)};
    world.frame(kMiddle, requests);
    ASSERT_TRUE(leave(world));
    world.store->hold();
    const auto loads = world.store->counts().loads;
    world.frame(kMiddle);
    world.frame(std::span<const PostPos>{});
    world.store->release();
    ASSERT_TRUE(leave(world));
    EXPECT_GE(world.stats.cancelled, 3u);
    EXPECT_LE(world.store->counts().loads, loads + 1);  // the one that was in the store's hands
    world.expect_equal_in_the_end(kMiddle);
}

// Smooth reads neighbours: it waits for tiles that are not in memory, later stamps on its tiles wait behind it, those
// on other tiles do not.
TEST_P(TileCacheTest, SmoothWaitsForItsTilesAndHoldsWhatComesBehind) {
    CacheWorld world(settings());
    // Resident: (4, 4). In the store: (2, 4) and (3, 4), beyond the kept tiles of a viewer in the middle of (5, 4).
    const StampRequest before[] = {dent(world, 190, 300, 10), dent(world, 258, 300, 10)};
    world.frame({160, 290}, before);
    ASSERT_TRUE(leave(world));
    const PostPos viewer{352, 290};
    ASSERT_TRUE(frames_until(world, viewer, [&] { return world.cache->can_be_drawn({4, 4}); }));
    ASSERT_EQ(state(world, {3, 4}), TileState::Absent);
    world.store->hold();
    const StampRequest smooth = dent(world, 256, 300, 12, StampRule::Smooth);  // mixed: (3, 4) and (4, 4)
    const StampRequest behind = dent(world, 262, 300, 6), elsewhere = dent(world, 360, 300, 6);
    world.frame(viewer, {&smooth, 1});
    world.frame(viewer, {&behind, 1});
    world.frame(viewer, {&elsewhere, 1});
    EXPECT_EQ(world.textures.code({5, 4}, {360, 300}), world.truth->detail().code({360, 300}));
    EXPECT_NE(world.textures.code({4, 4}, {262, 300}), world.truth->detail().code({262, 300})) << "out of order";
    world.store->release();
    ASSERT_TRUE(frames_until(world, viewer, [&] { return world.wrong_texels() == 0; }));
    world.expect_equal_in_the_end(viewer);
}

TEST_P(TileCacheTest, SmoothOnAbsentTilesAlone) {
    CacheWorld world(settings());
    std::vector<StampRequest> before;
    for (int i = 0; i < 20; ++i) before.push_back(world.random_stamp({128, 128}, 60, false));
    world.frame({600, 600}, before);  // nobody is near
    const StampRequest smooth = dent(world, 128, 128, 15, StampRule::Smooth), behind = dent(world, 130, 126, 9);
    world.frame({600, 600}, {&smooth, 1});
    world.frame({600, 600}, {&behind, 1});
    EXPECT_EQ(world.textures.count(), 0u);  // what is brought in for it gets no textures
    ASSERT_TRUE(frames_until(world, {600, 600}, [&] { return world.cache->is_idle(); }));
    for (const TileIndex index : {TileIndex{1, 1}, TileIndex{2, 1}, TileIndex{1, 2}, TileIndex{2, 2}})
        EXPECT_EQ(tile(world, index).pending, 0u);
    EXPECT_EQ(world.textures.count(), 0u);
    world.expect_equal_in_the_end({600, 600});
}

// "at most nine tiles resident per viewer", also while smooth waits for tiles that the viewer has left.
TEST_P(TileCacheTest, TilesThatAreHeldForSmoothKeepNoTextures) {
    CacheWorld world(settings());
    const StampRequest cold = dent(world, 100, 300, 10);
    world.frame({100, 300}, {&cold, 1});
    ASSERT_TRUE(leave(world));  // (1, 4) is in the store
    const PostPos viewer{224, 300};
    std::vector<StampRequest> fresh;
    for (int i = 0; i < 60; ++i) fresh.push_back(world.random_stamp(viewer, 50, false));
    world.frame(viewer, fresh);
    world.store->hold();
    const StampRequest smooth = dent(world, 160, 300, 70, StampRule::Smooth);
    world.frame(viewer, {&smooth, 1});  // waits for (1, 4)
    const PostPos away{576, 300};
    for (int i = 0; i < 40; ++i) {
        world.frame(away);
        std::this_thread::sleep_for(1ms);
    }
    std::size_t unwanted = 0;
    for (const CachedTile& cached : world.cache->tiles())
        unwanted += cached.interest == Interest::None && world.textures.has(cached.tile);
    EXPECT_EQ(unwanted, 0u);
    world.expect_equal_in_the_end(away);
}

TEST_P(TileCacheTest, WaitingStampsAreBounded) {
    CacheWorldSettings few = settings();
    few.cache.most_pending = 50;
    CacheWorld world(few);
    std::size_t most = 0;
    for (int i = 0; i < 600; ++i) {
        const StampRequest request = dent(world, 100 + i % 7, 100, 4);
        world.frame({600, 600}, {&request, 1});
        most = std::max(most, world.pending());
        if (world.pending() >= 50) std::this_thread::sleep_for(1ms);
    }
    EXPECT_LT(most, 150u);
    EXPECT_EQ(world.textures.count(), 0u);
    ASSERT_TRUE(leave(world));
    EXPECT_GT(world.stats.saves, 0u);
    world.expect_equal_in_the_end({600, 600});
}

// Memory is that of the tiles about the viewer, on the CPU too: what is left goes, its guests with it.
TEST_P(TileCacheTest, WhatIsLeftLeavesMemory) {
    CacheWorld world(settings());
    std::vector<StampRequest> requests;
    for (int i = 0; i < 200; ++i) requests.push_back(world.random_stamp({320, 320}, 300, false));
    world.frame({100, 100}, requests);
    for (const PostPos viewer : {PostPos{100, 100}, PostPos{500, 100}, PostPos{320, 320}}) {
        world.frame(viewer);
        ASSERT_TRUE(world.cache->settle(world.stats, world.deform).ok());
        EXPECT_FALSE(world.cached->detail().pages().empty());
    }
    ASSERT_TRUE(leave(world));
    EXPECT_TRUE(world.cached->detail().pages().empty());
    world.expect_equal_in_the_end({320, 320});
}

TEST_P(TileCacheTest, RequireBringsCodesIntoTheField) {
    CacheWorld world(settings());
    for (int i = 0; i < 60; ++i) {
        const StampRequest request = world.random_stamp(kMiddle, 320);
        world.frame(kMiddle, {&request, 1});
    }
    const TileIndex wanted[] = {{4, 4}, {1, 1}, {8, 2}, {9, 9}};
    ASSERT_TRUE(world.cache->require(wanted, world.stats, world.deform).ok());
    for (const TileIndex index : wanted) {
        EXPECT_TRUE(world.cache->is_in_field(index));
        const TexelRect rect = intersection(world.grid.interior(index), world.grid.map);
        for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
            for (std::int32_t x = rect.min.x; x < rect.max.x; ++x)
                ASSERT_EQ(world.cached->detail().code({x, z}), world.truth->detail().code({x, z})) << x << " " << z;
    }
    world.expect_equal_in_the_end(kMiddle);
}

TEST_P(TileCacheTest, RequireFailsWithTheStoresError) {
    CacheWorld world(settings());
    const StampRequest request = dent(world, 300, 300);
    world.frame(kMiddle, {&request, 1});
    ASSERT_TRUE(leave(world));
    world.store->fail_all(true);
    const TileIndex wanted[] = {{4, 4}};
    const Result<void> required = world.cache->require(wanted, world.stats, world.deform);
    ASSERT_FALSE(required.ok());
    EXPECT_NE(required.error().message.find("tile (4, 4)"), std::string::npos) << required.error().message;
    world.frame(kMiddle);
    EXPECT_FALSE(world.cache->settle(world.stats, world.deform).ok());
    EXPECT_FALSE(world.cache->hash(world.stats, world.deform).ok());
    world.expect_equal_in_the_end(kMiddle);  // nothing was lost
}

TEST_P(TileCacheTest, AnotherCacheFindsWhatWasSaved) {
    CacheWorldSettings shared = settings();
    std::uint64_t hash = 0;
    {
        CacheWorld world(shared);
        for (int i = 0; i < 200; ++i) {
            const StampRequest request = world.random_stamp(kMiddle, 330);
            world.frame(kMiddle, {&request, 1});
        }
        ASSERT_TRUE(world.cache->settle(world.stats, world.deform).ok());
        ASSERT_TRUE(store_everything(world));
        hash = world.truth->hash().detail;
    }
    shared.store = std::make_shared<test::FaultStore>(shared.store);
    CacheWorld again(shared);
    const Result<std::uint64_t> found = again.cache->hash(again.stats, again.deform);
    ASSERT_TRUE(found.ok());
    EXPECT_EQ(*found, hash);
}

// The band's purpose: at walking pace a tile is there before it is sampled. A frame may sleep, as real ones do.
TEST_P(TileCacheTest, AWalkMissesNoActiveTile) {
    CacheWorld world(settings());
    std::vector<StampRequest> all_over;
    for (int i = 0; i < 400; ++i) all_over.push_back(world.random_stamp(kMiddle, 320, false));
    world.frame(std::span<const PostPos>{}, all_over);
    ASSERT_TRUE(store_everything(world));
    world.frame({100, 100});
    ASSERT_TRUE(world.cache->settle(world.stats, world.deform).ok());
    (void)world.cache->take_arrivals();
    world.stats = {};
    for (int i = 0; i < 4000; ++i) {
        const PostPos at{100 + 0.1 * i, 100 + 0.07 * i};
        world.frame(at);
        bool loading = false;
        for (const CachedTile& cached : world.cache->tiles()) loading |= cached.state == TileState::Loading;
        if (loading) std::this_thread::sleep_for(1ms);
    }
    EXPECT_EQ(world.stats.missing_active, 0u);
    EXPECT_GE(world.stats.loads, 15u);
    for (const CachedArrival& arrival : world.cache->take_arrivals()) EXPECT_GT(arrival.lead_texels, 0);
    world.expect_equal_in_the_end({500, 380});
}

// Only modified tiles are written, and walking alone modifies nothing.
TEST_P(TileCacheTest, LookingAtTilesWritesNothing) {
    CacheWorld world(settings());
    std::vector<StampRequest> all_over;
    for (int i = 0; i < 200; ++i) all_over.push_back(world.random_stamp(kMiddle, 320, false));
    world.frame(kMiddle, all_over);
    ASSERT_TRUE(store_everything(world));
    world.stats = {};
    const auto saves = world.store->counts().saves;
    for (const PostPos at : {PostPos{100, 100}, PostPos{500, 500}, PostPos{320, 100}}) {
        world.frame(at);
        ASSERT_TRUE(world.cache->settle(world.stats, world.deform).ok());
    }
    ASSERT_TRUE(leave(world));
    EXPECT_EQ(world.store->counts().saves, saves);
    EXPECT_EQ(world.stats.loads, 12u);  // each place is in a corner region: four tiles
}

}  // namespace
}  // namespace tilth
