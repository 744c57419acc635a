#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "cache/support/cache_world.h"

namespace tilth::test {
namespace {

constexpr std::uint64_t kPlenty = 1u << 30;

CacheWorldSettings undoable(bool gpu, std::uint64_t seed) {
    CacheWorldSettings settings{.seed = seed, .undo_bytes = kPlenty};
    settings.cache.gpu_executor = gpu;
    settings.trouble = {
        .acquire_refused = 7, .fill_refused = 5, .read_back_refused = 4, .read_back_lost = 6, .stamp_fails = 9};
    return settings;
}

/// Strokes, undone and done again at random, beside the codes that the big map had before and after each.
class Strokes {
public:
    explicit Strokes(CacheWorld& world) : world_(world) {}

    void stroke(PostPos about, std::size_t stamps, double spread) {
        const DetailField before = world_.truth->detail();
        for (std::size_t i = 0; i < stamps; ++i) world_.stamp(world_.random_stamp(about, spread), i == 0);
        states_.resize(done_);
        states_.push_back({before, world_.truth->detail()});
        ++done_;
    }
    void undo() {
        if (done_ == 0) return;
        world_.undo(states_[--done_].before);
        ++undone;
    }
    void redo() {
        if (done_ == states_.size()) return;
        world_.redo(states_[done_++].after);
        ++redone;
    }
    void anything(PostPos about) {
        switch (world_.random.next() % 8) {
            case 0:
            case 1:
            case 2:
                undo();
                break;
            case 3:
                redo();
                break;
            default:
                stroke(about, 1 + world_.random.next() % 6, world_.random.next() % 4 == 0 ? 200 : 40);
        }
    }
    [[nodiscard]] bool any_left() const { return done_ > 0; }
    std::size_t undone = 0, redone = 0;

private:
    struct State {
        DetailField before, after;
    };
    CacheWorld& world_;
    std::vector<State> states_;
    std::size_t done_ = 0;
};

/// Frames until the disk worker has saved a tile that the viewer left.
void leave(CacheWorld& world, TileIndex tile, PostPos viewer) {
    for (int i = 0; i < 1000000 && world.cache->state(tile) != TileState::Absent; ++i) {
        world.frame(viewer);
        std::this_thread::yield();
    }
}

TEST(TileCacheUndo, WhateverIsInMemoryUndoAndRedoGiveTheBitsBack) {
    for (const bool gpu : kBothExecutors)
        for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16})
            for (const std::uint64_t seed : {1u, 2u, 3u}) {
                SCOPED_TRACE(testing::Message() << "gpu " << gpu << " seed " << seed);
                CacheWorldSettings settings = undoable(gpu, seed);
                settings.precision = precision;
                CacheWorld world(settings);
                Walker walker(world.random, 640, 9);
                Strokes strokes(world);
                for (int i = 0; i < 400; ++i) {
                    const PostPos viewer = walker.step();
                    const int edits = static_cast<int>(world.random.next() % 4);
                    // Near the viewer, or somewhere in the dark.
                    for (int k = 0; k < edits; ++k)
                        strokes.anything(world.random.next() % 3 == 0
                                             ? PostPos{world.random.between(0, 640), world.random.between(0, 640)}
                                             : viewer);
                    world.frame(viewer);
                    if (HasFatalFailure()) return;
                    if (i % 100 != 99) continue;
                    world.textures.behave(true);  // a pass that fails while somebody waits is his to hear of
                    world.expect_equal_hash();
                    world.textures.behave(false);
                    if (HasFatalFailure()) return;
                }
                EXPECT_GT(strokes.undone, 50u);
                EXPECT_GT(strokes.redone, 10u);
                world.expect_equal_in_the_end(walker.step());
                while (strokes.any_left()) strokes.undo();
                world.frame(walker.step());
                world.expect_equal_in_the_end(walker.step());
                EXPECT_EQ(world.truth->hash().detail, CacheWorld(settings).truth->hash().detail) << "nothing is left";
            }
}

TEST(TileCacheUndo, AStrokeThatWaitsEverywhereIsCancelledWithoutALoad) {
    CacheWorldSettings settings = undoable(false, 5);
    settings.trouble = {};
    CacheWorld world(settings);
    const PostPos here{32, 32}, far{600, 600};
    world.stamp({.centre = world.at(600, 600), .radius_m = 10 * world.texel_m(), .amplitude_m = 0.1});
    world.frame(far);
    leave(world, {9, 9}, here);
    ASSERT_EQ(world.cache->state({9, 9}), TileState::Absent);
    const std::uint64_t loads = world.stats.loads;
    const DetailField before = world.truth->detail();
    for (int i = 0; i < 3; ++i)  // saturates: its opposite would not undo it
        world.stamp({.centre = world.at(600 + i, 600), .radius_m = 10 * world.texel_m(), .amplitude_m = 15}, i == 0);
    world.frame(here);
    ASSERT_EQ(world.pending(), 3u);
    world.undo(before);
    world.frame(here);
    EXPECT_EQ(world.pending(), 0u);
    EXPECT_EQ(world.stats.loads, loads);
    world.expect_equal_hash();
}

TEST(TileCacheUndo, AFailingStoreDelaysUndoAndLosesNothing) {
    CacheWorldSettings settings = undoable(false, 6);
    settings.trouble = {};
    CacheWorld world(settings);
    const PostPos here{32, 32}, far{600, 600};
    const DetailField untouched = world.truth->detail();
    world.stamp(
        {.centre = world.at(600, 600), .radius_m = 10 * world.texel_m(), .amplitude_m = 0.1, .rule = StampRule::Max});
    world.frame(far);
    leave(world, {9, 9}, here);
    ASSERT_EQ(world.cache->state({9, 9}), TileState::Absent);
    world.store->fail_all(true);
    world.undo(untouched);
    for (int i = 0; i < 20; ++i) world.frame(here);
    EXPECT_TRUE(world.cache->has_waiting_edits());
    world.stamp({.centre = world.at(602, 600), .radius_m = 5 * world.texel_m(), .amplitude_m = 0.2});  // behind it
    world.frame(here);
    world.store->fail_all(false);
    for (int i = 0; i < 1000000 && world.cache->has_waiting_edits(); ++i) {
        world.frame(here);
        std::this_thread::yield();
    }
    EXPECT_FALSE(world.cache->has_waiting_edits());
    world.expect_equal_in_the_end(far);
}

TEST(TileCacheUndo, WithTheGpuExecutorPlainStampsKeepNoImagesAndReadNothingBack) {
    CacheWorldSettings settings = undoable(true, 7);
    settings.trouble = {};
    CacheWorld world(settings);
    const PostPos here{100, 100};
    world.frame(here);
    const DetailField before = world.truth->detail();
    for (int i = 0; i < 200; ++i)
        world.stamp({.centre = world.at(100 + i % 20, 100), .radius_m = 8 * world.texel_m(), .amplitude_m = -0.01},
                    i == 0);
    world.frame(here);
    EXPECT_EQ(world.deform.fallbacks, 0u);
    EXPECT_EQ(world.textures.passes(), 1u) << "one batch";
    EXPECT_TRUE(world.history.done().front()->detail.empty());
    world.undo(before);
    world.frame(here);
    world.expect_equal_in_the_end(here);
}

}  // namespace
}  // namespace tilth::test
