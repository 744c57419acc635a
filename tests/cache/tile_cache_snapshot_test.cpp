#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

#include "cache/support/cache_world.h"

namespace tilth::test {
namespace {

/// A disk: the tiles of the last commit alone, and the stamps that waited then.
struct Disk {
    std::shared_ptr<MemoryStore> pages = std::make_shared<MemoryStore>();
    std::map<TileIndex, std::vector<WaitingStamp>> waiting;
    std::size_t records = 0;  ///< of the world, that the commit holds
};

/// What a world that commits does on the worker: writes the snapshot into the live store, then copies all of it.
void commit(TileStore& live, const std::vector<TileSnapshot>& tiles, const TileGrid& grid, Disk& disk) {
    for (const TileSnapshot& tile : tiles) {
        if (tile.has_codes) {
            ASSERT_TRUE(live.save(tile.tile, tile.pages));
        }
        disk.waiting[tile.tile] = tile.waiting;
    }
    disk.pages = std::make_shared<MemoryStore>();
    const Result<std::vector<TileIndex>> all = live.tiles();
    ASSERT_TRUE(all.ok());
    for (const TileIndex tile : *all) {
        const Result<std::vector<Page>> pages = live.load(tile, pages_of(grid.interior(tile)));
        ASSERT_TRUE(pages.ok());
        ASSERT_TRUE(disk.pages->save(tile, *pages));
    }
}

/// The world walks, stamps and commits; then it is gone, and another opens what the last commit left and does the rest
/// of the records again.
void crash_and_reopen(bool gpu, HeightPrecision precision, std::uint64_t seed) {
    CacheWorldSettings settings{.precision = precision, .seed = seed};
    settings.cache.gpu_executor = gpu;
    settings.cache.most_pending = 40;
    settings.trouble = {.acquire_refused = 9, .fill_refused = 6, .read_back_refused = 4, .read_back_lost = 7};
    std::vector<StampRecord> records;
    Disk disk;
    std::uint64_t hash = 0;
    int commits = 0, due = 10;
    {
        CacheWorld world(settings);
        Walker walker(world.random, 640, 7);
        std::shared_ptr<DiskRequest> writing;
        std::shared_ptr<std::vector<TileSnapshot>> tiles;
        for (int i = 0; i < 500; ++i) {
            const PostPos viewer = walker.step();
            for (int k = 0; k < 3; ++k) {
                const bool dark = world.random.next() % 2 == 0;
                const PostPos about{world.random.between(0, 640), world.random.between(0, 640)};
                world.stamp(world.random_stamp(dark ? about : viewer, 40));
                records.push_back(world.last_record);
            }
            world.frame(viewer);
            for (const std::shared_ptr<DiskRequest>& done : world.cache->take_finished())
                if (done == writing) writing = nullptr;
            if (writing == nullptr && i >= due && i < 450) {  // something is left to be done again
                world.cache->prepare_snapshot();
                if (std::optional<std::vector<TileSnapshot>> taken = world.cache->snapshot(world.deform)) {
                    if (world.random.next() % 4 == 0) {  // a disk that refuses: the next one has these tiles, too
                        world.cache->snapshot_failed(*taken);
                        continue;
                    }
                    tiles = std::make_shared<std::vector<TileSnapshot>>(*std::move(taken));
                    const std::size_t count = records.size();
                    writing = DiskRequest::work(
                        [&disk, &world, tiles, count]() -> Result<void> {
                            commit(*world.store, *tiles, world.grid, disk);
                            disk.records = count;
                            return {};
                        },
                        600);
                    world.cache->submit(writing);
                    ++commits;
                    due = i + 15;
                }
            }
            if (testing::Test::HasFatalFailure()) return;
        }
        if (writing) world.cache->wait_for(writing, world.stats);
        world.expect_equal_in_the_end({320, 320});
        hash = world.truth->hash().detail;
    }
    ASSERT_GT(commits, 1);
    ASSERT_GT(disk.records, 0u);
    ASSERT_LT(disk.records, records.size()) << "there is something to do again";

    settings.store = std::make_shared<FaultStore>(disk.pages);
    CacheWorld reopened(settings);
    for (const StampRecord& record : records) {
        ASSERT_TRUE(reopened.truth->accept(record));
        reopened.truth->apply(record);
    }
    reopened.cache->restore_waiting(disk.waiting, reopened.history);
    std::vector<GroundEdit> tail;
    for (std::size_t i = disk.records; i < records.size(); ++i) {
        ASSERT_TRUE(reopened.cached->accept(records[i]));
        tail.push_back({.record = records[i], .stroke = nullptr});
    }
    ASSERT_TRUE(reopened.cache->apply(tail, reopened.deform));
    EXPECT_EQ(reopened.truth->hash().detail, hash);
    reopened.expect_equal_in_the_end({320, 320});
}

TEST(TileCacheSnapshot, OfOneMomentWhateverComesAndGoes) {
    for (const bool gpu : kBothExecutors)
        for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16})
            for (const std::uint64_t seed : {11u, 12u, 13u}) {
                SCOPED_TRACE(testing::Message() << "gpu " << gpu << " seed " << seed);
                crash_and_reopen(gpu, precision, seed);
                if (testing::Test::HasFatalFailure()) return;
            }
}

TEST(TileCacheSnapshot, HasNothingWhereNothingChanged) {
    CacheWorld world({});
    world.stamp({.centre = world.at(100, 100), .radius_m = 5 * world.texel_m(), .amplitude_m = -0.1});
    world.frame({100, 100});
    std::optional<std::vector<TileSnapshot>> first = world.cache->snapshot(world.deform);
    ASSERT_TRUE(first.has_value());
    ASSERT_FALSE(first->empty());
    for (int i = 0; i < 10; ++i) world.frame({100, 100});
    EXPECT_TRUE(world.cache->snapshot(world.deform)->empty());
    world.cache->snapshot_failed(*first);
    EXPECT_EQ(world.cache->snapshot(world.deform)->size(), first->size());
}

TEST(TileCacheSnapshot, SharesCodesThatDoNotChangeAfterwards) {
    CacheWorld world({});
    world.stamp({.centre = world.at(100, 100), .radius_m = 5 * world.texel_m(), .amplitude_m = -0.1});
    world.frame({100, 100});
    const DetailField before = world.truth->detail();
    const std::optional<std::vector<TileSnapshot>> taken = world.cache->snapshot(world.deform);
    world.stamp({.centre = world.at(100, 100), .radius_m = 9 * world.texel_m(), .amplitude_m = -0.2});
    world.frame({100, 100});
    std::size_t pages = 0;
    for (const TileSnapshot& tile : *taken)
        for (const Page& page : tile.pages) {
            ASSERT_NE(before.find(page.index), nullptr);
            EXPECT_EQ(*page.codes, *before.find(page.index));
            ++pages;
        }
    EXPECT_GT(pages, 0u);
}

TEST(TileCacheSnapshot, WaitsWhileAnEditWaits) {
    CacheWorldSettings settings;
    CacheWorld world(settings);
    const PostPos here{32, 32};
    world.stamp({.centre = world.at(600, 600), .radius_m = 10 * world.texel_m(), .amplitude_m = 0.1});
    world.frame({600, 600});
    for (int i = 0; i < 1000000 && world.cache->state({9, 9}) != TileState::Absent; ++i) world.frame(here);
    world.store->hold();
    world.stamp({.centre = world.at(600, 600),
                 .radius_m = 10 * world.texel_m(),
                 .amplitude_m = 0.5,
                 .rule = StampRule::Smooth});
    world.frame(here);
    EXPECT_FALSE(world.cache->snapshot(world.deform).has_value()) << "no moment has the codes of all edits";
    world.store->release();
    world.expect_equal_in_the_end(here);
    EXPECT_TRUE(world.cache->snapshot(world.deform).has_value());
}

}  // namespace
}  // namespace tilth::test
