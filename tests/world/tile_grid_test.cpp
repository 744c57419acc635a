// Tiles of a map: integer division of negatives, indices that never alias, windows of a rectangle.
#include "tilth/world/tile_grid.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <vector>

#include "tilth/ground/page.h"
#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();

// A2. C++ rounds -1 / 2048 to 0 and gives -1 % 2048 == -1.
static_assert(floor_divide(-1, 2048) == -1 && floor_modulo(-1, 2048) == 2047);
static_assert(floor_divide(-2048, 2048) == -1 && floor_modulo(-2048, 2048) == 0);
static_assert(floor_divide(-2049, 2048) == -2 && floor_modulo(-2049, 2048) == 2047);
static_assert(floor_divide(kLeast, 2048) == -1048576 && floor_modulo(kLeast, 2048) == 0);
static_assert(floor_divide(kMost, 2048) == 1048575 && floor_modulo(kMost, 2048) == 2047);

TEST(TileGrid, QuotientAndRemainderMakeTheNumber) {
    SplitMix64 random{5};
    std::vector<std::int32_t> numbers{kLeast, kLeast + 1, -2049, -2048, -2047, -1, 0, 1, 2047, 2048, kMost - 1, kMost};
    for (int i = 0; i < 20000; ++i) numbers.push_back(static_cast<std::int32_t>(random.next()));
    for (const std::int32_t size : {1, 3, 64, 192, 2048, 8192, kMost})
        for (const std::int32_t number : numbers) {
            const std::int64_t quotient = floor_divide(number, size), remainder = floor_modulo(number, size);
            ASSERT_EQ(quotient * size + remainder, number) << size;
            ASSERT_TRUE(remainder >= 0 && remainder < size) << number << " " << size;
        }
}

// A6: two texels share a tile exactly if floor(x / size) says so, over all of int32.
TEST(TileGrid, IndicesNeverAlias) {
    SplitMix64 random{6};
    for (const std::int32_t size : {64, 192, 2048, 8192}) {
        const TileGrid grid{.size = size, .apron = 2, .map = {{kLeast, kLeast}, {kMost, kMost}}};
        std::vector<std::int32_t> texels;
        for (std::int64_t near : {std::int64_t{kLeast} + 3 * size, std::int64_t{0}, std::int64_t{kMost} - 3 * size})
            for (std::int64_t t = near - 3 * size; t <= near + 3 * size; t += 7)
                texels.push_back(static_cast<std::int32_t>(t));
        for (int i = 0; i < 3000; ++i) texels.push_back(static_cast<std::int32_t>(random.next()));
        for (const std::int32_t x : texels) {
            const std::int32_t tile = grid.tile_of({x, 0}).x;
            const std::int64_t from = std::int64_t{tile} * size;  // in 64 bits: nothing wraps
            ASSERT_TRUE(from <= x && x < from + size) << x;
            ASSERT_EQ(grid.tile_of({0, x}).z, tile);
        }
    }
}

TEST(TileGrid, EveryTexelLiesInOneInteriorAndInNeighboursAprons) {
    const TileGrid grid{.size = 64, .apron = 3, .map = {{0, 0}, {150, 200}}};
    for (std::int32_t z = 0; z < 200; ++z)
        for (std::int32_t x = 0; x < 150; ++x) {
            int interiors = 0;
            std::set<TileIndex> storing;
            for (std::int32_t tz = 0; tz < 4; ++tz)
                for (std::int32_t tx = 0; tx < 3; ++tx) {
                    if (grid.interior({tx, tz}).contains({x, z})) {
                        ++interiors;
                        ASSERT_EQ(grid.tile_of({x, z}), (TileIndex{tx, tz}));
                    }
                    if (grid.stored({tx, tz}).contains({x, z})) storing.insert({tx, tz});
                }
            ASSERT_EQ(interiors, 1);
            const TileWindow window = tiles_storing(grid, {{x, z}, {x + 1, z + 1}});
            ASSERT_EQ(window.count(), static_cast<std::int64_t>(storing.size())) << x << " " << z;
            for (const TileIndex tile : storing) ASSERT_TRUE(window.contains(tile));
        }
}

TEST(TileGrid, TilesOfARectangleAreThoseThatMeetIt) {
    const TileGrid grid{.size = 64, .apron = 2, .map = {{0, 0}, {200, 200}}};
    SplitMix64 random{7};
    for (int i = 0; i < 5000; ++i) {
        const auto number = [&](int low, int high) {
            return low + static_cast<std::int32_t>(random.next() % (high - low));
        };
        const Texel min{number(-90, 260), number(-90, 260)};
        const TexelRect rect{min, {min.x + number(0, 150), min.z + number(0, 150)}};
        std::int64_t own = 0, storing = 0;
        for (std::int32_t tz = 0; tz < 4; ++tz)
            for (std::int32_t tx = 0; tx < 4; ++tx) {
                const TexelRect inside = intersection(rect, grid.map);
                const bool meets = !intersection(inside, grid.interior({tx, tz})).empty();
                const bool stored = !intersection(inside, grid.stored({tx, tz})).empty();
                own += meets, storing += stored;
                ASSERT_TRUE(!meets || tiles_of(grid, rect).contains({tx, tz}));
                ASSERT_TRUE(!stored || tiles_storing(grid, rect).contains({tx, tz}));
            }
        ASSERT_EQ(tiles_of(grid, rect).count(), own);
        ASSERT_EQ(tiles_storing(grid, rect).count(), storing);
    }
}

TEST(TileGrid, ExistsAtTheMapsEdges) {
    const TileGrid grid{.size = 64, .apron = 2, .map = {{0, 0}, {129, 128}}};
    for (std::int32_t z = -2; z < 5; ++z)
        for (std::int32_t x = -2; x < 5; ++x)
            EXPECT_EQ(grid.exists({x, z}), !intersection(grid.interior({x, z}), grid.map).empty()) << x << " " << z;
}

TEST(TileGrid, PagesOfARectangle) {
    EXPECT_EQ(page_of({-1, 63}), (PageIndex{-1, 0}));
    EXPECT_EQ(page_of({kLeast, kMost}), (PageIndex{kLeast / 64, kMost / 64}));
    EXPECT_EQ(pages_of({{-1, 0}, {64, 65}}), (PageRect{{-1, 0}, {1, 2}}));
    EXPECT_TRUE(pages_of({{5, 5}, {5, 9}}).empty());
}

}  // namespace
}  // namespace tilth
