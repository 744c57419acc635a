// The store without a disk: copies, whole replacement, and nothing kept for zero pages.
#include "tilth/store/memory_store.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tilth/world/height_codec.h"

namespace tilth {
namespace {

constexpr PageRect kEverything{{-1000, -1000}, {1000, 1000}};
constexpr std::uint64_t kPageBytes = 16 * 1024;

Page filled(PageIndex index, std::uint32_t code) {
    Page page{index, std::make_shared<PageCodes>()};
    page.codes->fill(code);
    return page;
}
std::vector<Page> loaded(TileStore& store, TileIndex tile, const PageRect& pages = kEverything) {
    Result<std::vector<Page>> pages_of_tile = store.load(tile, pages);
    EXPECT_TRUE(pages_of_tile.ok());
    return *std::move(pages_of_tile);
}
void save(TileStore& store, TileIndex tile, const std::vector<Page>& pages) {
    EXPECT_TRUE(store.save(tile, pages).ok());
}

TEST(MemoryStore, ATileThatWasNeverSavedHasNoPages) {
    MemoryStore store;
    EXPECT_TRUE(loaded(store, {3, 4}).empty());
    EXPECT_TRUE(store.tiles()->empty());  // asking does not make it
    EXPECT_EQ(store.bytes(), 0u);
}

TEST(MemoryStore, GivesBackWhatWasSaved) {
    MemoryStore store;
    Page marked = filled({-2, 5}, 7);
    for (std::size_t i = 0; i < marked.codes->size(); ++i)
        (*marked.codes)[i] = static_cast<std::uint32_t>(i * 2654435761u);
    save(store, {0, 1}, {filled({0, 32}, 1), marked});
    save(store, {1, 0}, {filled({32, 0}, 2)});

    const std::vector<Page> pages = loaded(store, {0, 1});
    ASSERT_EQ(pages.size(), 2u);
    const auto found = std::find_if(pages.begin(), pages.end(), [](const Page& page) {
        return page.index == PageIndex{-2, 5};
    });
    ASSERT_NE(found, pages.end());
    EXPECT_EQ(*found->codes, *marked.codes);
    EXPECT_EQ(loaded(store, {1, 0})[0].codes->front(), 2u);

    std::vector<TileIndex> tiles = *store.tiles();
    std::sort(tiles.begin(), tiles.end());
    EXPECT_EQ(tiles, (std::vector<TileIndex>{{0, 1}, {1, 0}}));
}

TEST(MemoryStore, LoadsTheAskedPagesAlone) {
    MemoryStore store;
    std::vector<Page> pages;
    for (std::int32_t x = 0; x < 4; ++x)
        for (std::int32_t z = 0; z < 4; ++z) pages.push_back(filled({x, z}, static_cast<std::uint32_t>(10 * x + z)));
    save(store, {0, 0}, pages);
    std::vector<std::uint32_t> codes;
    for (const Page& page : loaded(store, {0, 0}, {{1, 2}, {3, 3}})) codes.push_back(page.codes->front());
    std::sort(codes.begin(), codes.end());
    EXPECT_EQ(codes, (std::vector<std::uint32_t>{12, 22}));  // the far corner is not included
    EXPECT_TRUE(loaded(store, {0, 0}, {}).empty());
}

TEST(MemoryStore, KeepsNoShareOfWhatItTakesOrGives) {
    MemoryStore store;
    Page page = filled({0, 0}, 5);
    save(store, {0, 0}, {page});
    EXPECT_EQ(page.codes.use_count(), 1);
    page.codes->fill(6);
    std::vector<Page> first = loaded(store, {0, 0});
    EXPECT_EQ(first[0].codes->back(), 5u);
    EXPECT_EQ(first[0].codes.use_count(), 1);  // the caller owns it: a field need not copy it before writing
    first[0].codes->fill(7);
    EXPECT_EQ(loaded(store, {0, 0})[0].codes->back(), 5u);
}

TEST(MemoryStore, ReplacesATileAsAWhole) {
    MemoryStore store;
    save(store, {0, 0}, {filled({0, 0}, 1), filled({1, 1}, 2)});
    save(store, {0, 1}, {filled({0, 2}, 9)});
    save(store, {0, 0}, {filled({1, 0}, 3)});
    const std::vector<Page> pages = loaded(store, {0, 0});
    ASSERT_EQ(pages.size(), 1u);
    EXPECT_EQ(pages[0].index, (PageIndex{1, 0}));
    EXPECT_EQ(loaded(store, {0, 1}).size(), 1u);
    EXPECT_EQ(store.bytes(), 2 * kPageBytes);
}

// P10: a tile that is level at zero is an index and no texels, whether it was always so or was levelled.
TEST(MemoryStore, ZeroPagesCostNothing) {
    MemoryStore store;
    std::vector<Page> level;
    for (std::int32_t x = 0; x < 32; ++x)
        for (std::int32_t z = 0; z < 32; ++z) level.push_back(filled({x, z}, kMidCode));
    save(store, {0, 0}, level);
    EXPECT_EQ(store.bytes(), 0u);
    EXPECT_EQ(store.tiles()->size(), 1u);
    EXPECT_TRUE(loaded(store, {0, 0}).empty());

    level[40].codes->back() ^= 1;  // one quantum in one texel is an edit
    save(store, {0, 0}, level);
    EXPECT_EQ(store.bytes(), kPageBytes);
    EXPECT_EQ(loaded(store, {0, 0}).size(), 1u);

    level[40].codes->back() ^= 1;
    save(store, {0, 0}, level);
    EXPECT_EQ(store.bytes(), 0u);
    save(store, {5, 5}, {});
    EXPECT_EQ(store.tiles()->size(), 2u);  // saved tiles are known, pages or not
}

TEST(MemoryStore, CountsItsBytes) {
    MemoryStore store;
    save(store, {0, 0}, {filled({0, 0}, 1), filled({0, 1}, 1), filled({0, 2}, 1)});
    save(store, {1, 0}, {filled({1, 0}, 1)});
    EXPECT_EQ(store.bytes(), 4 * kPageBytes);
    save(store, {0, 0}, {filled({0, 0}, 1), filled({0, 0}, 2)});  // named twice: the last holds
    EXPECT_EQ(store.bytes(), 2 * kPageBytes);
    EXPECT_EQ(loaded(store, {0, 0})[0].codes->front(), 2u);
}

}  // namespace
}  // namespace tilth
