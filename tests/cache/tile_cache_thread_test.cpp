// The cache over long walks: no stamp is lost, no tile thrashes, and in the end the ground is what one big map is.
// Run under ThreadSanitizer.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cache/support/cache_world.h"

namespace tilth {
namespace {

using test::CacheWorld;
using test::CacheWorldSettings;

#if defined(__SANITIZE_THREAD__)
constexpr int kFrames = 3000;  // ten times slower there
#else
constexpr int kFrames = 10000;
#endif

constexpr test::FakeTrouble kSomeTrouble{.acquire_refused = 10,
                                         .fill_refused = 10,
                                         .read_back_refused = 5,
                                         .read_back_lost = 20,
                                         .most_read_back_frames = 4};

class TileCacheWalks : public testing::TestWithParam<bool> {
protected:
    [[nodiscard]] CacheWorldSettings settings(std::uint64_t seed) const {
        return {.cache = {.gpu_executor = GetParam(), .least_retry_ms = 16, .most_retry_ms = 64},
                .trouble = kSomeTrouble,
                .seed = seed};
    }
    /// Stamps of some frames: by the viewer's feet, or anywhere on the map.
    static std::vector<StampRequest> some_stamps(CacheWorld& world, PostPos viewer, bool smooth) {
        std::vector<StampRequest> requests;
        if (world.random.next() % 4 == 0) requests.push_back(world.random_stamp(viewer, 20, smooth));
        if (world.random.next() % 8 == 0) requests.push_back(world.random_stamp({320, 320}, 340, smooth));
        return requests;
    }
};
INSTANTIATE_TEST_SUITE_P(Executors, TileCacheWalks, testing::ValuesIn(test::kBothExecutors),
                         [](const auto& tested) { return std::string(tested.param ? "gpu" : "cpu"); });

TEST_P(TileCacheWalks, RandomWalk) {
    CacheWorld world(settings(101));
    test::Walker walker(world.random, 640, 1.5);
    PostPos at;
    for (int i = 0; i < kFrames; ++i) {
        at = walker.step();
        world.frame(at, some_stamps(world, at, true));
        if (i % 1000 == 999) world.expect_equal_hash();
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(world.stats.loads, 20u);
    EXPECT_GT(world.stats.saves, 20u);
    EXPECT_GT(world.stats.late_stamps, 20u);
    world.expect_equal_in_the_end(at);
}

// Without smooth nothing is ever put off, so what may be drawn is right in every frame, aprons included.
TEST_P(TileCacheWalks, WhatIsDrawnIsRightInEveryFrame) {
    CacheWorld world(settings(102));
    test::Walker walker(world.random, 640, 3);
    PostPos at;
    for (int i = 0; i < kFrames / 4; ++i) {
        at = walker.step();
        if (i % 300 == 299) at = {world.random.between(0, 640), world.random.between(0, 640)};
        world.frame(at, some_stamps(world, at, false));
        if (HasFatalFailure()) return;
        ASSERT_EQ(world.wrong_texels(), 0) << "frame " << i;
    }
    world.expect_equal_in_the_end(at);
}

// P6: as many frames under ThreadSanitizer.
TEST_P(TileCacheWalks, TeleportsEveryFrame) {
    CacheWorld world(settings(103));
    PostPos at;
    for (int i = 0; i < 10000; ++i) {
        at = {world.random.between(-50, 700), world.random.between(-50, 700)};
        world.frame(at, some_stamps(world, at, true));
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(world.stats.cancelled + world.stats.rescues, 20u);
    world.expect_equal_in_the_end(at);
}

// Between two places, and with time to load between the jumps: S11, tiles on their way out and in are stamped.
TEST_P(TileCacheWalks, TeleportsToAndFro) {
    CacheWorld world(settings(104));
    const PostPos places[] = {{100, 100}, {500, 500}, {160, 130}, {64, 64}};
    PostPos at = places[0];
    for (int i = 0; i < kFrames; ++i) {
        if (world.random.next() % 6 == 0) at = places[world.random.next() % 4];
        std::vector<StampRequest> requests;
        for (const PostPos& place : places)
            if (world.random.next() % 12 == 0) requests.push_back(world.random_stamp(place, 60));
        world.frame(at, requests);
        if (i % 1000 == 999) world.expect_equal_hash();
        if (HasFatalFailure()) return;
    }
    world.expect_equal_in_the_end(at);
}

// Other tiles, aprons and precisions; the last tile of the map is a part of one.
TEST_P(TileCacheWalks, OtherShapes) {
    struct Case {
        std::int32_t posts, tile_size, apron;
        HeightPrecision precision;
    };
    const Case cases[] = {{150, 128, 16, HeightPrecision::bits32},
                          {161, 64, 1, HeightPrecision::bits16},
                          {129, 64, 64, HeightPrecision::bits32},
                          {130, 192, 5, HeightPrecision::bits16}};
    for (const Case& shape : cases) {
        CacheWorldSettings other = settings(111);
        other.posts = shape.posts, other.tile_size = shape.tile_size, other.apron = shape.apron;
        other.precision = shape.precision;
        CacheWorld world(other);
        const double size = world.grid.map.max.x;
        test::Walker walker(world.random, size, 3);
        PostPos at;
        for (int i = 0; i < kFrames / 8; ++i) {
            at = walker.step();
            if (i % 200 == 199) at = {world.random.between(0, size), world.random.between(0, size)};
            std::vector<StampRequest> requests;
            if (i % 4 == 0) requests.push_back(world.random_stamp(at, 30));
            if (i % 8 == 0) requests.push_back(world.random_stamp({size / 2, size / 2}, size / 2 + 20));
            world.frame(at, requests);
            if (HasFatalFailure()) return;
        }
        world.expect_equal_in_the_end(at);
        EXPECT_FALSE(HasFailure()) << "tiles of " << shape.tile_size << ", apron " << shape.apron;
    }
}

// A4: pacing across a tile's border, the band's edges and a corner.
TEST_P(TileCacheWalks, PacingDoesNotThrash) {
    struct Pace {
        PostPos a, b;
    };
    const Pace paces[] = {{{319, 300}, {321, 300}},      // a border
                          {{317.5, 317.5}, {322, 322}},  // a corner of four
                          {{348, 352}, {349.5, 352}},    // the band's low edge: 320 + 28.8
                          {{354.5, 300}, {356, 305}},    // its high edge: 320 + 35.2
                          {{348, 348}, {356, 356}}};     // across the band
    for (const Pace& pace : paces) {
        CacheWorld world(settings(105));
        std::vector<StampRequest> all_over;
        for (int i = 0; i < 150; ++i) all_over.push_back(world.random_stamp({320, 320}, 320, false));
        world.frame({10, 10}, all_over);
        std::uint64_t warm = 0;
        for (int i = 0; i < kFrames; ++i) {
            std::vector<StampRequest> requests;
            if (i % 5 == 0) requests.push_back(world.random_stamp(pace.a, 10, false));
            world.frame(i % 2 == 0 ? pace.a : pace.b, requests);
            if (HasFatalFailure()) return;
            if (i == kFrames / 2) warm = world.stats.loads + world.stats.saves;
        }
        EXPECT_LT((world.stats.loads + world.stats.saves - warm) * 60, static_cast<std::uint64_t>(kFrames / 2))
            << pace.a.x << " " << pace.a.z;
        world.expect_equal_in_the_end(pace.a);
    }
}

TEST_P(TileCacheWalks, AStoreThatOftenFails) {
    CacheWorld world(settings(106));
    test::Walker walker(world.random, 640, 4);
    PostPos at;
    std::uint64_t failures_before = 0;
    for (int i = 0; i < kFrames / 2; ++i) {
        at = walker.step();
        if (i % 7 == 0) world.store->fail_next_loads(world.random.next() % 3);
        if (i % 11 == 0) world.store->fail_next_saves(world.random.next() % 4);
        if (i % 100 == 0)
            world.store->fail_tile(
                world.grid.tile_of({static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.z)}));
        world.frame(at, some_stamps(world, at, true));
        if (HasFatalFailure()) return;
        const std::size_t reported = world.cache->take_errors().size();
        ASSERT_LE(reported, world.stats.failures - failures_before);
        failures_before = world.stats.failures;
    }
    EXPECT_GT(world.stats.failures, 20u);
    world.expect_equal_in_the_end(at);
}

TEST_P(TileCacheWalks, ASlowStore) {
    CacheWorld world(settings(107));
    world.store->set_latency(std::chrono::microseconds(300));
    test::Walker walker(world.random, 640, 4);
    PostPos at;
    for (int i = 0; i < kFrames / 2; ++i) {
        at = walker.step();
        if (i % 400 == 0) at = {world.random.between(0, 640), world.random.between(0, 640)};
        world.frame(at, some_stamps(world, at, true));
        if (HasFatalFailure()) return;
    }
    world.expect_equal_in_the_end(at);
}

// A tile takes many frames to fill, while it and its neighbours are stamped, read back and let go.
TEST_P(TileCacheWalks, SmallSlices) {
    CacheWorldSettings slow = settings(112);
    slow.budget.slice_bytes = 24 << 10;  // one page
    slow.budget.most_bytes = 24 << 10;
    CacheWorld world(slow);
    const PostPos places[] = {{100, 300}, {150, 300}, {230, 300}, {300, 300}};
    PostPos at = places[0];
    for (int i = 0; i < kFrames / 2; ++i) {
        if (world.random.next() % 12 == 0) at = places[world.random.next() % 4];
        std::vector<StampRequest> requests;
        if (world.random.next() % 3 == 0) requests.push_back(world.random_stamp(at, 60, false));
        world.frame(at, requests);
        if (HasFatalFailure()) return;
        ASSERT_TRUE(i % 8 != 0 || world.wrong_texels() == 0) << "frame " << i;
    }
    world.expect_equal_in_the_end(at);
}

TEST_P(TileCacheWalks, SeveralViewers) {
    CacheWorld world(settings(108));
    std::vector<test::Walker> walkers(3, test::Walker(world.random, 640, 2));
    std::vector<PostPos> places(3);
    for (int i = 0; i < kFrames / 4; ++i) {
        std::vector<StampRequest> requests;
        for (std::size_t w = 0; w < 3; ++w) {
            places[w] = walkers[w].step();
            if (world.random.next() % 8 == 0) requests.push_back(world.random_stamp(places[w], 20));
        }
        if (i % 500 == 499) places[2] = {world.random.between(0, 640), world.random.between(0, 640)};
        world.frame(std::span(places).first(1 + static_cast<std::size_t>(i / 200) % 3), requests);
        if (HasFatalFailure()) return;
    }
    world.expect_equal_in_the_end(places[0]);
}

// P8: fewer textures than the viewer's tiles.
TEST_P(TileCacheWalks, FewTextures) {
    CacheWorldSettings few = settings(109);
    few.cache.most_tiles = 4;
    CacheWorld world(few);
    world.textures.set_most_tiles(4);
    test::Walker walker(world.random, 640, 2);
    PostPos at;
    for (int i = 0; i < kFrames / 4; ++i) {
        at = walker.step();
        world.frame(at, some_stamps(world, at, true));
        if (HasFatalFailure()) return;
        ASSERT_LE(world.cache->textured_tiles(), 4u);
        ASSERT_EQ(world.cache->textured_tiles(), world.textures.count());
    }
    world.expect_equal_in_the_end(at, false);
}

// The GPU's passes fail now and then: the CPU applies the records.
TEST_P(TileCacheWalks, PassesThatFail) {
    CacheWorldSettings failing = settings(110);
    failing.trouble.stamp_fails = 15;
    CacheWorld world(failing);
    test::Walker walker(world.random, 640, 2);
    PostPos at;
    for (int i = 0; i < kFrames / 4; ++i) {
        at = walker.step();
        world.frame(at, some_stamps(world, at, true));
        if (HasFatalFailure()) return;
    }
    EXPECT_EQ(world.failed_stamps > 5, GetParam());
    EXPECT_EQ(world.deform.fallbacks > 5, GetParam());
    world.expect_equal_in_the_end(at);
}

}  // namespace
}  // namespace tilth
