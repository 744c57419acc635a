// The residency map: every kind of tile has its own look, and cells lie where their tiles do.
#include <gtest/gtest.h>

#include <cmath>

#include "demo/overlay/residency_map.h"

namespace tilth::demo {
namespace {

constexpr TileState kStates[] = {TileState::Absent, TileState::Loading, TileState::Uploading, TileState::Resident,
                                 TileState::Saving};

/// The colours of a cell, each far enough from the others to be told apart by eye: a tenth of full scale in a channel.
bool told_apart(const Vec3f& a, const Vec3f& b) {
    return std::abs(a.x - b.x) >= 0.1f || std::abs(a.y - b.y) >= 0.1f || std::abs(a.z - b.z) >= 0.1f;
}

TEST(CellLook, EveryStateHasAColourOfItsOwn) {
    std::vector<Vec3f> fills{look_of(nullptr).fill};
    for (const TileState state : kStates) {
        const TileReport tile{.tile = {}, .state = state};
        fills.push_back(look_of(&tile).fill);
    }
    for (std::size_t a = 0; a < fills.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) EXPECT_TRUE(told_apart(fills[a], fills[b])) << a << " " << b;
}

TEST(CellLook, ActiveIsFramedAndDirtyIsDottedInEveryState) {
    for (const TileState state : kStates)
        for (const bool modified : {false, true})
            for (const Interest interest : {Interest::None, Interest::Kept, Interest::Loaded, Interest::Active}) {
                const TileReport tile{.tile = {}, .state = state, .interest = interest, .modified = modified};
                const CellLook look = look_of(&tile);
                EXPECT_EQ(look.frame.has_value(), interest == Interest::Active);
                EXPECT_EQ(look.dot.has_value(), modified);
                EXPECT_TRUE(told_apart(look.frame.value_or(Vec3f{9, 9, 9}), look.fill));
                EXPECT_TRUE(told_apart(look.dot.value_or(Vec3f{9, 9, 9}), look.fill));
            }
    EXPECT_EQ(look_of(nullptr).frame, std::nullopt);
    EXPECT_EQ(look_of(nullptr).dot, std::nullopt);
}

TileGrid grid_of(std::int32_t columns, std::int32_t rows) {
    return {.size = 64, .apron = 2, .map = {{0, 0}, {columns * 64 - 3, rows * 64}}};  // the last column is not full
}

TEST(ShownTiles, AllOfASmallGridAndAWindowOfALargeOne) {
    EXPECT_EQ(shown_tiles(grid_of(6, 4), {2, 2}, 15), (TileWindow{{0, 0}, {5, 3}}));
    EXPECT_EQ(shown_tiles(grid_of(15, 15), {14, 0}, 15), (TileWindow{{0, 0}, {14, 14}}));
    EXPECT_EQ(shown_tiles(grid_of(100, 4), {50, 1}, 15), (TileWindow{{43, 0}, {57, 3}}));
    EXPECT_EQ(shown_tiles(grid_of(100, 100), {0, 99}, 15), (TileWindow{{0, 85}, {14, 99}})) << "moved inside the grid";
}

/// What a pixel of the picture shows: the last rectangle over it.
Vec3f at(const std::vector<ColouredRect>& map, int x, int y) {
    Vec3f colour{-1, -1, -1};
    for (const ColouredRect& r : map)
        if (x >= r.rect.x0 && x < r.rect.x1 && y >= r.rect.y0 && y < r.rect.y1) colour = r.colour;
    return colour;
}

TEST(ResidencyMap, CellsLieWhereTheirTilesDo) {
    // 4 x 4 tiles of 64 texels at 0.5 m, 32 m a tile, the map's corner at (100, 200). 8 pixels of margin, cells of 24.
    const TileGrid grid = grid_of(4, 4);
    const GridSpec texels{.origin = {100, 200}, .spacing_m = 0.5, .width = grid.map.max.x, .depth = grid.map.max.z};
    const std::vector<TileReport> tiles{{.tile = {0, 3}, .state = TileState::Saving},
                                        {.tile = {1, 2}, .state = TileState::Resident, .modified = true},
                                        {.tile = {3, 1}, .state = TileState::Resident, .interest = Interest::Active}};
    const WorldPos viewers[] = {{100 + 3.25 * 32, 200 + 1.75 * 32}, {100 + 16, 200 + 16}};
    const auto map = residency_map({grid, texels, tiles, viewers}, 400, 300);
    const int left = 400 - 8 - 4 * 24, top = 8;
    const auto middle_of = [&](int x, int z) { return at(map, left + x * 24 + 12, top + z * 24 + 12); };
    EXPECT_EQ(middle_of(3, 1), look_of(&tiles[2]).fill);
    EXPECT_EQ(middle_of(0, 3), look_of(&tiles[0]).fill) << "+z is down";
    EXPECT_EQ(middle_of(3, 3), look_of(nullptr).fill);
    EXPECT_EQ(at(map, left + 3 * 24 + 2, top + 24 + 12), *look_of(&tiles[2]).frame) << "at the cell's edge";
    EXPECT_EQ(middle_of(1, 2), *look_of(&tiles[1]).dot);
    EXPECT_EQ(at(map, left + 24 + 5, top + 2 * 24 + 12), look_of(&tiles[1]).fill) << "the dot leaves room";
    EXPECT_EQ(at(map, left + 2, top + 3 * 24 + 12), look_of(&tiles[0]).fill) << "no frame where none is active";
    EXPECT_EQ(at(map, left + 3 * 24 + 6, top + 24 + 18), (Vec3f{1, 1, 1})) << "the viewer";
    EXPECT_TRUE(told_apart(middle_of(0, 0), look_of(nullptr).fill)) << "the further viewer";
    EXPECT_TRUE(told_apart(middle_of(0, 0), {1, 1, 1}));
    EXPECT_EQ(at(map, left - 3, top), (Vec3f{-1, -1, -1})) << "nothing is painted beside the map";
}

TEST(ResidencyMap, ItStaysInsideThePictureWhateverTheGrid) {
    const WorldPos viewer{-1e9, 1e9};  // off the map
    for (const std::int32_t side : {1, 7, 16, 5000})
        for (const int pixels : {64, 90, 1000}) {
            const TileGrid grid = grid_of(side, side);
            const GridSpec texels{.origin = {}, .spacing_m = 1, .width = grid.map.max.x, .depth = grid.map.max.z};
            const auto map = residency_map({grid, texels, {}, {&viewer, 1}}, pixels, pixels);
            ASSERT_FALSE(map.empty());
            for (const ColouredRect& r : map) {
                EXPECT_TRUE(r.rect.x0 >= 0 && r.rect.y0 >= 0 && r.rect.x1 <= pixels && r.rect.y1 <= pixels)
                    << side << " tiles, " << pixels << " pixels";
            }
        }
    EXPECT_TRUE(residency_map({grid_of(4, 4), {}, {}, {&viewer, 1}}, 63, 1000).empty());
}

}  // namespace
}  // namespace tilth::demo
