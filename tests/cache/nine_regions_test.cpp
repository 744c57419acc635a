// Which tiles a viewer needs: by region, by place, and along every walk.
#include "tilth/cache/nine_regions.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Side kSides[] = {Side::Low, Side::Middle, Side::High};

TileGrid grid_of(std::int32_t size, std::int32_t tiles_a_side) {
    return {.size = size, .apron = 2, .map = {{0, 0}, {size * tiles_a_side, size * tiles_a_side}}};
}
bool inside(const TileWindow& inner, const TileWindow& outer) {
    return inner.count() == 0 || (outer.contains(inner.min) && outer.contains(inner.max));
}

// Crause, Flower, Marais 2011, section 4.2, by name.
struct NamedRegion {
    const char* name;
    Region region;
    TileWindow loaded, active;
};
constexpr NamedRegion kRegions[] = {
    {"NW", {Side::Low, Side::Low}, {{-1, -1}, {0, 0}}, {{-1, -1}, {0, 0}}},
    {"N", {Side::Middle, Side::Low}, {{-1, -1}, {1, 0}}, {{0, -1}, {0, 0}}},
    {"NE", {Side::High, Side::Low}, {{0, -1}, {1, 0}}, {{0, -1}, {1, 0}}},
    {"W", {Side::Low, Side::Middle}, {{-1, -1}, {0, 1}}, {{-1, 0}, {0, 0}}},
    {"C", {Side::Middle, Side::Middle}, {{-1, -1}, {1, 1}}, {{0, 0}, {0, 0}}},
    {"E", {Side::High, Side::Middle}, {{0, -1}, {1, 1}}, {{0, 0}, {1, 0}}},
    {"SW", {Side::Low, Side::High}, {{-1, 0}, {0, 1}}, {{-1, 0}, {0, 1}}},
    {"S", {Side::Middle, Side::High}, {{-1, 0}, {1, 1}}, {{0, 0}, {0, 1}}},
    {"SE", {Side::High, Side::High}, {{0, 0}, {1, 1}}, {{0, 0}, {1, 1}}},
};

TEST(NineRegions, WindowsByName) {
    for (const NamedRegion& expected : kRegions) {
        EXPECT_EQ(loaded_window({0, 0}, expected.region), expected.loaded) << expected.name;
        EXPECT_EQ(active_window({0, 0}, expected.region), expected.active) << expected.name;
        const TileWindow far = loaded_window({-7, 40}, expected.region);  // the same, shifted
        EXPECT_EQ(far.min, (TileIndex{expected.loaded.min.x - 7, expected.loaded.min.z + 40})) << expected.name;
        EXPECT_EQ(far.count(), expected.loaded.count()) << expected.name;
    }
}

TEST(NineRegions, NineAndOneSixAndTwoFourAndFour) {
    for (const Side x : kSides)
        for (const Side z : kSides) {
            const int middles = (x == Side::Middle) + (z == Side::Middle);
            const TileWindow loaded = loaded_window({3, 3}, {x, z}), active = active_window({3, 3}, {x, z});
            EXPECT_EQ(loaded.count(), (std::array{4, 6, 9})[static_cast<std::size_t>(middles)]);
            EXPECT_EQ(active.count(), (std::array{4, 2, 1})[static_cast<std::size_t>(middles)]);
            EXPECT_TRUE(loaded.contains({3, 3}) && active.contains({3, 3}));
            EXPECT_TRUE(inside(active, loaded));
        }
    EXPECT_EQ(kept_window({.tile = {3, 3}, .x = 0.5, .z = 0.7}, 0.1).count(), 9);
    EXPECT_EQ(kept_window({.tile = {3, 3}, .x = 0.26, .z = 0.76}, 0.1).count(), 6);
    EXPECT_EQ(kept_window({.tile = {3, 3}, .x = 0.24, .z = 0.76}, 0.1), (TileWindow{{2, 3}, {3, 4}}));
    for (const double band : {0.02, 0.1, 0.5, 0.9}) EXPECT_TRUE(kept_band(band) > band && kept_band(band) < 1);
}

TEST(NineRegions, TheBandCutsATile) {
    const PlaceInTile low{.x = 0.4499, .z = 0.5501}, middle{.x = 0.4501, .z = 0.5499}, edges{.x = 0, .z = 0.9999};
    EXPECT_EQ(region_of(low, 0.1), (Region{Side::Low, Side::High}));
    EXPECT_EQ(region_of(middle, 0.1), (Region{Side::Middle, Side::Middle}));
    EXPECT_EQ(region_of(edges, 0.1), (Region{Side::Low, Side::High}));
    EXPECT_EQ(region_of(low, 0.9), (Region{Side::Middle, Side::Middle}));
    EXPECT_EQ(region_of(edges, 0.9), (Region{Side::Low, Side::High}));
}

// A3: fract(-1e-9f) == 1.0f, and then a texel behind the tile's last is read.
TEST(NineRegions, NoPlaceIsAtAFractionOfOne) {
    std::vector<double> places{0.0,  -0.0,      -1e-9,      -1e-17, -5e-324, 1e-300,
                               kNan, kInfinity, -kInfinity, 1e300,  -1e300,  9e18};
    for (const double border : {-192.0, -64.0, 0.0, 64.0, 128.0, 192.0, 576.0})
        for (const double from : {border, border - 1, border + 1})
            for (const double to : {-kInfinity, kInfinity}) {
                places.push_back(from), places.push_back(std::nextafter(from, to));
                places.push_back(std::nextafter(static_cast<float>(from), static_cast<float>(to)));
            }
    for (const TileGrid& grid :
         {TileGrid{64, 2, {{0, 0}, {640, 640}}}, TileGrid{64, 2, {{-640, -640}, {640, 640}}},
          TileGrid{192, 2, {{-576, 0}, {576, 500}}}, TileGrid{2048, 2, {{0, 0}, {1 << 26, 1 << 26}}}})
        for (const double x : places)
            for (const double z : places) {
                const PlaceInTile place = place_in_tile(grid, {x, z});
                ASSERT_TRUE(place.x >= 0 && place.x < 1 && place.z >= 0 && place.z < 1) << x << " " << z;
                const Texel texel{place.tile.x * grid.size + static_cast<std::int32_t>(place.x * grid.size),
                                  place.tile.z * grid.size + static_cast<std::int32_t>(place.z * grid.size)};
                ASSERT_TRUE(grid.map.contains(texel)) << x << " " << z << ": " << texel.x << " " << texel.z;
                // And where the place is one on the map, it is that place, to a rounding.
                const bool on_map = x >= grid.map.min.x && x <= grid.map.max.x - 1;
                const double found = (place.tile.x + place.x) * grid.size;
                ASSERT_TRUE(!on_map || std::abs(found - x) <= 1e-9 * std::max(1.0, std::abs(x))) << x;
            }
}

TEST(NineRegions, PlacesOffTheMapAreItsNearestTexel) {
    const TileGrid grid = grid_of(64, 3);
    const PlaceInTile before = place_in_tile(grid, {-5, kNan}), behind = place_in_tile(grid, {1e9, kInfinity});
    EXPECT_EQ(before.tile, (TileIndex{0, 0}));
    EXPECT_EQ(before.x, 0);
    EXPECT_EQ(before.z, 0);
    EXPECT_EQ(behind.tile, (TileIndex{2, 2}));
    EXPECT_EQ(behind.x, 63.0 / 64);
    EXPECT_EQ(place_in_tile({64, 2, {{128, 128}, {256, 256}}}, {kNan, kNan}).tile, (TileIndex{2, 2}));
}

// A6: the place's tile is floor(texel / size) in 64 bits, from one end of int32 to the other.
TEST(NineRegions, TilesNeverAlias) {
    constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min(),
                           kMost = std::numeric_limits<std::int32_t>::max();
    SplitMix64 random{4};
    for (const std::int32_t size : {64, 192, 2048}) {
        const TileGrid grid{.size = size, .apron = 0, .map = {{kLeast, kLeast}, {kMost, kMost}}};
        for (int i = 0; i < 30000; ++i) {
            std::int64_t texel = static_cast<std::int32_t>(random.next());
            if (i < 400) texel = kLeast + i;
            if (i >= 400 && i < 800) texel = kMost - 1 - (i - 400);
            const PlaceInTile place = place_in_tile(grid, {static_cast<double>(texel) + 0.5 * (i % 2), 0});
            const std::int64_t from = std::int64_t{place.tile.x} * size;
            ASSERT_TRUE(from <= texel && texel < from + size) << texel;
        }
    }
}

// Every texel and half texel of 3 x 3 tiles against the picture in the header, written down in fractions of a tile.
TEST(NineRegions, EveryPlaceOfASmallMap) {
    constexpr std::int32_t kSize = 64;
    const TileGrid grid = grid_of(kSize, 3);
    for (const double band : {0.1, 0.5})
        for (int half_z = 0; half_z <= 2 * (3 * kSize - 1); ++half_z)
            for (int half_x = 0; half_x <= 2 * (3 * kSize - 1); ++half_x) {
                const PostPos at{half_x / 2.0, half_z / 2.0};
                const ViewerTiles tiles = tiles_of_viewer(grid, at, band);
                ASSERT_EQ(tiles.own, grid.tile_of({half_x / 2, half_z / 2}));
                for (std::int32_t tz = -1; tz <= 3; ++tz)
                    for (std::int32_t tx = -1; tx <= 3; ++tx) {
                        // How far the viewer is from the tile's middle, in tiles.
                        const double dx = std::abs(at.x / kSize - (tx + 0.5)), dz = std::abs(at.z / kSize - (tz + 0.5));
                        const bool exists = tx >= 0 && tz >= 0 && tx < 3 && tz < 3;
                        const bool own_x = tiles.own.x == tx, own_z = tiles.own.z == tz;
                        const bool active = (own_x || dx < 1 - band / 2) && (own_z || dz < 1 - band / 2);
                        const bool loaded = (own_x || dx <= 1 + band / 2) && (own_z || dz <= 1 + band / 2);
                        const double wide = std::min(band + 0.4, (1 + band) / 2);
                        const bool kept = (own_x || dx <= 1 + wide / 2) && (own_z || dz <= 1 + wide / 2);
                        // On the band's very edge both answers are right.
                        const auto on_edge = [&](double d) {
                            return std::abs(std::abs(d - 1) - band / 2) < 1e-12 ||
                                   std::abs(std::abs(d - 1) - wide / 2) < 1e-12;
                        };
                        if (on_edge(dx) || on_edge(dz)) continue;
                        ASSERT_EQ(tiles.active.contains({tx, tz}), exists && active) << at.x << " " << at.z;
                        ASSERT_EQ(tiles.loaded.contains({tx, tz}), exists && loaded) << at.x << " " << at.z;
                        ASSERT_EQ(tiles.kept.contains({tx, tz}), exists && kept) << at.x << " " << at.z;
                    }
                ASSERT_TRUE(inside(tiles.active, tiles.loaded) && inside(tiles.loaded, tiles.kept));
                ASSERT_TRUE(tiles.active.contains(tiles.own));
                ASSERT_LE(tiles.kept.count(), 9);
            }
}

// The promise of the band: an active tile was loaded before, for every walk with steps shorter than the band.
TEST(NineRegions, NothingBecomesActiveThatWasNotLoaded) {
    const TileGrid grid = grid_of(64, 12);
    SplitMix64 random{8};
    for (const double band : {0.02, 0.1, 0.3, 0.9})
        for (const double share : {0.05, 0.5, 0.999})
            for (int walk = 0; walk < 120; ++walk) {
                const double angle = 2 * std::numbers::pi * (walk < 16 ? walk / 16.0 : random.unit());
                const double step = share * band * grid.size;
                PostPos at{random.between(200, 500), random.between(200, 500)};
                ViewerTiles before = tiles_of_viewer(grid, at, band);
                int changes = 0;
                for (int i = 0;
                     i < 4000 && grid.map.contains({static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.z)});
                     ++i) {
                    at = {at.x + step * std::cos(angle), at.z + step * std::sin(angle)};
                    const ViewerTiles now = tiles_of_viewer(grid, at, band);
                    ASSERT_TRUE(inside(now.active, before.loaded)) << "band " << band << " at " << at.x << ", " << at.z;
                    changes += now.active != before.active;
                    before = now;
                }
                ASSERT_GT(changes, 0);  // the walk went somewhere
            }
}

// The band's other promise: pacing across any line loads nothing new once everything about it is loaded. A tile is let
// go only when a wider band would not ask for it either.
TEST(NineRegions, PacingLoadsNothing) {
    const TileGrid grid = grid_of(64, 5);
    for (double line = 64; line < 256; line += 0.5) {
        const PostPos a{line - 1.6, 150}, b{line + 1.6, 150};  // less than the band's width apart
        std::vector<TileIndex> resident;
        int loads_after_warm_up = 0;
        for (int frame = 0; frame < 40; ++frame) {
            const ViewerTiles viewer = tiles_of_viewer(grid, frame % 2 == 0 ? a : b, 0.1);
            std::erase_if(resident, [&](TileIndex tile) { return !viewer.kept.contains(tile); });
            for (std::int32_t z = viewer.loaded.min.z; z <= viewer.loaded.max.z; ++z)
                for (std::int32_t x = viewer.loaded.min.x; x <= viewer.loaded.max.x; ++x)
                    if (std::find(resident.begin(), resident.end(), TileIndex{x, z}) == resident.end()) {
                        resident.push_back({x, z});
                        loads_after_warm_up += frame >= 4;
                    }
            ASSERT_LE(resident.size(), 9u);
        }
        ASSERT_EQ(loads_after_warm_up, 0) << line;
    }
}

// Every point nearer than the reach lies in an active tile (or off the map), and for some viewer no farther one does.
TEST(NineRegions, ActiveReachIsTheGreatestLowerBound) {
    const TileGrid grid = grid_of(64, 5);
    for (const double band : {0.02, 0.1, 0.5, 0.9}) {
        const double reach = active_reach_m(64, band);
        double smallest = 1e9;
        SplitMix64 random{9};
        for (int i = 0; i < 40000; ++i) {
            PostPos at{random.between(128, 192), random.between(128, 192)};
            if (i % 4 == 0) at.x = 160 + (i % 8 == 0 ? 1 : -1) * (32 * band + 1e-6);  // beside the band's edges
            if (i % 4 == 1) at.x = 160 + (i % 8 == 1 ? 1 : -1) * (32 * band - 1e-6);
            const TileWindow active = tiles_of_viewer(grid, at, band).active;
            smallest = std::min({smallest, at.x - 64.0 * active.min.x, at.z - 64.0 * active.min.z,
                                 64.0 * (active.max.x + 1) - at.x, 64.0 * (active.max.z + 1) - at.z});
        }
        EXPECT_GE(smallest, reach - 1e-9) << band;
        EXPECT_NEAR(smallest, reach, 1e-4) << band;
    }
}

TEST(NineRegions, TexelsUntilActiveAgreesWithWalking) {
    const TileGrid grid = grid_of(64, 6);
    constexpr double kStep = 0.25;
    SplitMix64 random{10};
    for (int i = 0; i < 1500; ++i) {
        const double band = random.between(0.02, 0.9);
        const PostPos at{random.between(0, 383), random.between(0, 383)};
        const TileIndex tile{static_cast<std::int32_t>(random.next() % 6),
                             static_cast<std::int32_t>(random.next() % 6)};
        const double told = texels_until_active(grid, at, tile, band);
        const auto is_active = [&](PostPos p) { return tiles_of_viewer(grid, p, band).active.contains(tile); };
        // The quickest walk goes towards the tile's middle along both axes at once, each until it is level with it.
        PostPos walker = at;
        const PostPos goal{tile.x * 64 + 32.0, tile.z * 64 + 32.0};
        double walked = 0;
        for (; !is_active(walker) && walked < 1000; walked += kStep) {
            walker.x += std::clamp(goal.x - walker.x, -kStep, kStep);
            walker.z += std::clamp(goal.z - walker.z, -kStep, kStep);
        }
        ASSERT_LE(told, walked + 1e-9) << at.x << " " << at.z << " " << band;
        ASSERT_GE(told, walked - kStep - 1e-9) << at.x << " " << at.z << " " << band;
        ASSERT_TRUE(!is_active(at) || told == 0);
    }
}

TEST(NineRegions, ClippedAtTheMapsEdge) {
    const TileGrid grid{.size = 64, .apron = 2, .map = {{0, 0}, {130, 65}}};  // 3 x 2 tiles, the last ones slivers
    const ViewerTiles corner = tiles_of_viewer(grid, {0, 0}, 0.1);
    EXPECT_EQ(corner.loaded, (TileWindow{{0, 0}, {0, 0}}));
    EXPECT_EQ(corner.active, (TileWindow{{0, 0}, {0, 0}}));
    EXPECT_EQ(corner.kept, (TileWindow{{0, 0}, {0, 0}}));
    const ViewerTiles middle = tiles_of_viewer(grid, {96, 32}, 0.1);
    EXPECT_EQ(middle.loaded, (TileWindow{{0, 0}, {2, 1}}));
    EXPECT_EQ(middle.active, (TileWindow{{1, 0}, {1, 0}}));
    const ViewerTiles last = tiles_of_viewer(grid, {1e9, 1e9}, 0.1);
    EXPECT_EQ(last.own, (TileIndex{2, 1}));
    EXPECT_EQ(last.active, (TileWindow{{1, 0}, {2, 1}}));
}

TEST(NineRegions, SeveralViewersAreTheUnion) {
    const TileGrid grid = grid_of(64, 8);
    SplitMix64 random{12};
    for (int i = 0; i < 400; ++i) {
        std::vector<ViewerTiles> viewers;
        for (std::uint64_t count = random.next() % 4; count > 0; --count)
            viewers.push_back(tiles_of_viewer(grid, {random.between(-20, 530), random.between(-20, 530)}, 0.1));
        for (std::int32_t z = 0; z < 8; ++z)
            for (std::int32_t x = 0; x < 8; ++x) {
                Interest expected = Interest::None;
                std::int32_t away = std::numeric_limits<std::int32_t>::max();
                for (const ViewerTiles& viewer : viewers) {
                    const bool active = viewer.active.contains({x, z}), loaded = viewer.loaded.contains({x, z});
                    expected = std::max(expected, active                         ? Interest::Active
                                                  : loaded                       ? Interest::Loaded
                                                  : viewer.kept.contains({x, z}) ? Interest::Kept
                                                                                 : Interest::None);
                    away = std::min(away, std::max(std::abs(viewer.own.x - x), std::abs(viewer.own.z - z)));
                }
                ASSERT_EQ(interest_in({x, z}, viewers), expected);
                ASSERT_EQ(tiles_away({x, z}, viewers), away);
            }
    }
}

}  // namespace
}  // namespace tilth
