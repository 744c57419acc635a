// Which arrivals of tiles count as leads of a walk, and what the smallest is: closed forms.
#include <gtest/gtest.h>

#include "demo/stats/walk_leads.h"

namespace tilth::demo {
namespace {

const TileGrid kGrid{.size = 64, .apron = 2, .map = {{0, 0}, {640, 640}}};

TEST(WalkLeads, TheSmallestOfAllWalksInMetresAndAtItsOwnSpeed) {
    WalkStats stats;
    const PostPos at{32, 32};  // the middle of tile (0, 0): the 2 x 2 at the map's corner are wanted
    const LeadWatch slow(kGrid, 0.1, {&at, 1}, 2.0), fast(kGrid, 0.1, {&at, 1}, 100.0);
    const TileArrival arrivals[] = {{{3, 0}, 6.5, 40}, {{4, 0}, 5.0, 40}};
    slow.frame({}, arrivals, stats);
    EXPECT_EQ(stats.smallest_lead_m, 5.0);
    EXPECT_EQ(stats.smallest_lead_ms, 2500.0);
    const TileArrival later[] = {{{5, 0}, 6.0, 40}};
    fast.frame({}, later, stats);
    EXPECT_EQ(stats.smallest_lead_m, 5.0);
    EXPECT_EQ(stats.smallest_lead_ms, 60.0);
    const TileArrival late[] = {{{6, 0}, 0.0, 40}};
    slow.frame({}, late, stats);
    EXPECT_EQ(stats.smallest_lead_m, 0.0) << "a tile that came late counts";
}

TEST(WalkLeads, TilesThatWalkingDidNotAskForHaveNone) {
    WalkStats stats;
    const PostPos at[] = {{32, 32}, {600, 32}};  // another viewer in tile (9, 0)
    const LeadWatch watch(kGrid, 0.1, at, 2.0);
    const TileArrival arrivals[] = {{{1, 1}, 0.0, 40},  // wanted where the walk began
                                    {{8, 0}, 0.0, 40},  // by the other viewer
                                    {{4, 4}, 0.0, 0}};  // dented just now: it did not come from anywhere
    watch.frame({}, arrivals, stats);
    EXPECT_FALSE(stats.smallest_lead_m);
    EXPECT_FALSE(stats.smallest_lead_ms);
}

TEST(WalkLeads, FramesThatMissTilesAreCountedOnce) {
    WalkStats stats;
    const LeadWatch watch(kGrid, 0.1, {}, 2.0);
    gl::CacheStats cache;
    watch.frame(cache, {}, stats);
    cache.missing_active = 3;
    watch.frame(cache, {}, stats);
    watch.frame(cache, {}, stats);
    EXPECT_EQ(stats.missing_frames, 2u);
}

}  // namespace
}  // namespace tilth::demo
