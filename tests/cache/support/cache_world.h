// A world behind a tile cache, and the same world as one big map that applies every record at once.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "cache/support/fake_textures.h"
#include "ground/support.h"
#include "support/fault_store.h"
#include "tilth/cache/tile_cache.h"

namespace tilth::test {

struct CacheWorldSettings {
    std::int32_t posts = 214;  ///< a side; 640 texels: ten tiles, the last whole
    std::int32_t tile_size = 64, apron = 2;
    HeightPrecision precision = HeightPrecision::bits32;
    std::shared_ptr<FaultStore> store = std::make_shared<FaultStore>();
    TileCacheSettings cache;
    BudgetSettings budget;
    FakeTrouble trouble;
    std::uint64_t seed = 1;
    std::uint64_t undo_bytes = 0;
};

/// Both executors: with `gpu` the fake textures are the truth.
inline constexpr bool kBothExecutors[] = {false, true};

class CacheWorld {
public:
    explicit CacheWorld(const CacheWorldSettings& settings)
        : store(settings.store),
          truth(make_ground(settings)),
          cached(make_ground(settings)),
          grid{settings.tile_size, settings.apron, truth->map(MapKind::Detail).grid.rect()},
          textures(grid, settings.seed, settings.trouble),
          random{settings.seed},
          budget(settings.budget),
          history(settings.undo_bytes),
          gpu_executor_(settings.cache.gpu_executor) {
        Result<std::unique_ptr<TileCache>> made = TileCache::create(*cached, grid, store, textures, settings.cache);
        EXPECT_TRUE(made.ok());
        cache = *std::move(made);
        interrupt = std::make_unique<InterruptAtEnd>(store);
    }
    ~CacheWorld() { interrupt.reset(); }

    /// Metres a texel.
    [[nodiscard]] double texel_m() const { return truth->map(MapKind::Detail).grid.spacing_m; }
    [[nodiscard]] WorldPos at(double x_texels, double z_texels) const {
        return {x_texels * texel_m(), z_texels * texel_m()};
    }

    /// A frame of 16 ms: the viewers' places in texels, and the stamps that are issued in it.
    void frame(std::span<const PostPos> viewers, std::span<const StampRequest> requests = {}) {
        now_ms += 16;
        textures.begin_frame();
        std::vector<WorldPos> places;
        for (const PostPos& viewer : viewers) places.push_back(at(viewer.x, viewer.z));
        cache->set_viewers(places);
        cache->update(now_ms, stats);
        for (const StampRequest& request : requests) stamp(request);
        const Result<void> stamped = cache->apply(std::exchange(queue_, {}), deform);
        history.trim();
        failed_stamps += stamped.ok() ? 0 : 1;
        budget.begin_frame(5);
        cache->transfer(budget, stats, deform);
        ++frames;
        ASSERT_LE(resident(), 9 * viewers.size()) << "frame " << frames;
        // Textures that the viewers have left wait for nothing but their read-back.
        if (!gpu_executor_) {
            ASSERT_LE(textures.count(), 9 * viewers.size()) << "frame " << frames;
        }
    }
    void frame(PostPos viewer, std::span<const StampRequest> requests = {}) { frame({&viewer, 1}, requests); }

    /// Queued for the next frame; at once on the big map. Each is a stroke of its own unless `begins` is false.
    void stamp(const StampRequest& request, bool begins = true) {
        last_record = issued(*truth, request);
        truth->apply(last_record);
        EXPECT_TRUE(cached->accept(last_record).ok());
        queue_.push_back(history.add(last_record, begins));
    }
    /// Of the last stroke. The big map has nothing to undo with: it becomes what the caller remembers of it.
    void undo(const DetailField& before) {
        const Result<StrokePtr> stroke = history.undo();
        ASSERT_TRUE(stroke.ok()) << stroke.error().message;
        queue_.push_back(undo_edit(*stroke));
        truth->mutable_detail() = before;
    }
    void redo(const DetailField& after) {
        const Result<StrokePtr> stroke = history.redo();
        ASSERT_TRUE(stroke.ok()) << stroke.error().message;
        for (GroundEdit& edit : redo_edits(*stroke)) queue_.push_back(std::move(edit));
        truth->mutable_detail() = after;
    }

    [[nodiscard]] std::size_t resident() const {
        std::size_t count = 0;
        for (const CachedTile& tile : cache->tiles())
            count += tile.state == TileState::Resident && tile.interest != Interest::None;
        return count;
    }
    [[nodiscard]] std::size_t pending() const {
        std::size_t count = 0;
        for (const CachedTile& tile : cache->tiles()) count += tile.pending;
        return count;
    }

    /// A stamp of any shape and rule about a place, `radius` texels; rarely a large one.
    StampRequest random_stamp(PostPos about, double spread_texels, bool smooth = true) {
        StampRequest request;
        request.map = MapChoice::Detail;
        request.shape = builtin(kAllProfiles[random.next() % 6]);
        request.centre = at(about.x + random.between(-spread_texels, spread_texels),
                            about.z + random.between(-spread_texels, spread_texels));
        request.rule = static_cast<StampRule>(random.next() % (smooth ? 5 : 4));
        const double radius_texels = random.next() % 40 == 0 ? random.between(40, 110) : random.between(1, 20);
        request.radius_m = radius_texels * texel_m();
        request.amplitude_m = request.rule == StampRule::Smooth ? random.unit() : random.between(-0.4, 0.4);
        if (random.next() % 50 == 0 && request.rule == StampRule::Add) request.amplitude_m *= 30;  // saturates
        return request;
    }

    /// The hash now: of a world half of which is on its way.
    void expect_equal_hash() {
        const Result<std::uint64_t> hash = cache->hash(stats, deform);
        ASSERT_TRUE(hash.ok()) << hash.error().message;
        ASSERT_EQ(*hash, truth->hash().detail) << "frame " << frames;
    }

    /// Texels of resident textures, aprons included, that are not the truth's. Tiles that may not be drawn do not
    /// count.
    [[nodiscard]] std::int64_t wrong_texels() const {
        std::int64_t wrong = 0;
        for (const CachedTile& tile : cache->tiles())
            if (cache->can_be_drawn(tile.tile)) wrong += textures.differences(tile.tile, truth->detail());
        return wrong;
    }

    /// Lets everything come to rest and compares: nothing deferred, textures and hash those of the big map.
    /// `all_fit`: there are textures for all tiles that the viewer wants.
    void expect_equal_in_the_end(PostPos viewer, bool all_fit = true) {
        store->interrupt();
        store->fail_all(false);
        store->fail_tile(std::nullopt);
        store->fail_next_loads(0), store->fail_next_saves(0);
        textures.behave(true);
        frame(viewer);
        const Result<void> settled = cache->settle(stats, deform);
        ASSERT_TRUE(settled.ok()) << settled.error().message;
        EXPECT_EQ(wrong_texels(), 0);
        for (const CachedTile& tile : cache->tiles())
            EXPECT_TRUE(!all_fit || tile.interest < Interest::Loaded || cache->can_be_drawn(tile.tile));
        expect_equal_hash();
        EXPECT_EQ(wrong_texels(), 0) << "hash() changed something";
    }

    std::shared_ptr<FaultStore> store;
    std::unique_ptr<Ground> truth, cached;
    TileGrid grid;
    FakeTextures textures;
    SplitMix64 random;
    std::unique_ptr<TileCache> cache;
    std::unique_ptr<InterruptAtEnd> interrupt;  // goes first
    gl::CacheStats stats;
    gl::StageStats deform;
    FrameBudget budget;
    UndoHistory history;
    StampRecord last_record;
    double now_ms = 0;
    std::uint64_t frames = 0, failed_stamps = 0;

private:
    const bool gpu_executor_;
    std::vector<GroundEdit> queue_;

    static std::unique_ptr<Ground> make_ground(const CacheWorldSettings& settings) {
        return flat_ground(settings.posts,
                           {.texels_per_post = 3, .tile_size = settings.tile_size, .precision = settings.precision});
    }
};

/// A viewer who walks in a straight line for a while, turns, and never leaves the map.
class Walker {
public:
    Walker(SplitMix64& random, double map_texels, double step_texels)
        : random_(random), size_(map_texels), step_(step_texels), at_{map_texels / 2, map_texels / 2} {}
    PostPos step() {
        if (random_.next() % 60 == 0) angle_ = 2 * std::numbers::pi * random_.unit();
        const PostPos next{at_.x + step_ * std::cos(angle_), at_.z + step_ * std::sin(angle_)};
        if (next.x < 0 || next.z < 0 || next.x > size_ - 1 || next.z > size_ - 1)
            angle_ = 2 * std::numbers::pi * random_.unit();
        else
            at_ = next;
        return at_;
    }

private:
    SplitMix64& random_;
    double size_, step_;
    PostPos at_;
    double angle_ = 0.7;
};

}  // namespace tilth::test
