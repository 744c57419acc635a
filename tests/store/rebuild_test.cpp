// Pages made again from the journal are those of the world that did it all.
#include "tilth/store/rebuild.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "ground/random_edits.h"
#include "ground/reference.h"
#include "tilth/ground/before_image.h"
#include "tilth/store/editor.h"

namespace tilth {
namespace {

using test::kPlenty;
using test::RandomRequests;
using test::Undoable;

std::uint32_t untouched(Texel) { return kMidCode; }

/// A world that stamped, undid and redid, and all its edits.
struct Lived {
    Undoable world;
    std::vector<Edit> edits;

    Lived(std::uint32_t seed, HeightPrecision precision, int steps) : world(test::small_world(precision), kPlenty) {
        RandomRequests random(seed);
        for (int i = 0; i < steps; ++i) {
            const double what = random.real(0, 1);
            if (what < 0.2 && world.history.undoable() > 0) {
                turn(EditKind::Undo, world.history.done().back());
                EXPECT_TRUE(world.undo());
            } else if (what < 0.3 && world.history.redoable() > 0) {
                turn(EditKind::Redo, world.history.undone().back());
                EXPECT_TRUE(world.redo());
            } else {
                const std::int32_t count = random.whole(1, 6);
                for (std::int32_t k = 0; k < count; ++k) {
                    StampRequest request = random.next(*world.ground);
                    if (request.rule != StampRule::Smooth && random.chance(0.3)) {  // many of them
                        request.rule = StampRule::Smooth;
                        request.amplitude_m = random.real(0.2, 1);
                    }
                    const StampRecord record = test::issued(*world.ground, request);
                    edits.push_back({.begins_stroke = k == 0, .record = record});
                    apply_edit(*world.ground, world.history.add(record, k == 0));
                }
            }
        }
    }
    void turn(EditKind kind, const StrokePtr& stroke) {
        edits.push_back({.kind = kind, .record = {.sequence = stroke->records.front().sequence}});
    }
    [[nodiscard]] PageCodes page(MapKind kind, PageIndex at) const {
        if (kind == MapKind::Coarse) return page_of_field(world.ground->coarse(), at);
        const PageCodes* codes = world.ground->detail().find(at);
        PageCodes none;
        none.fill(kMidCode);
        return codes == nullptr ? none : *codes;
    }
    [[nodiscard]] std::vector<Page> rebuilt(MapKind kind, const std::set<PageIndex>& pages,
                                            std::span<const StampRecord> stamps) const {
        const auto original = kind == MapKind::Coarse ? world.ground->original_codes() : untouched;
        return rebuild_pages(pages, stamps, world.ground->map(kind), world.ground->shapes(), original);
    }
};

std::set<PageIndex> all_pages(const Ground& ground, MapKind kind) {
    std::set<PageIndex> pages;
    for_each_page(pages_of(ground.map(kind).grid.rect()), [&](PageIndex page) { pages.insert(page); });
    return pages;
}

class Rebuild : public testing::TestWithParam<HeightPrecision> {};
INSTANTIATE_TEST_SUITE_P(Both, Rebuild, testing::ValuesIn(test::kBothPrecisions), [](const auto& param) {
    return param.param == HeightPrecision::bits32 ? "bits32" : "bits16";
});

TEST(StampsInEffect, AreThoseOfStrokesThatAreNotUndone) {
    const auto stamp = [](std::uint64_t sequence, bool begins) {
        return Edit{.begins_stroke = begins, .record = {.sequence = sequence}};
    };
    const auto of = [](EditKind kind, std::uint64_t sequence) {
        return Edit{.kind = kind, .record = {.sequence = sequence}};
    };
    const auto effect = [](const std::vector<Edit>& edits) {
        std::vector<std::uint64_t> sequences;
        for (const StampRecord& record : stamps_in_effect(edits)) sequences.push_back(record.sequence);
        return sequences;
    };
    using Numbers = std::vector<std::uint64_t>;
    std::vector<Edit> edits{stamp(1, true), stamp(2, true), stamp(3, false), stamp(4, true)};
    EXPECT_EQ(effect(edits), (Numbers{1, 2, 3, 4}));
    edits.push_back(of(EditKind::Undo, 4));
    EXPECT_EQ(effect(edits), (Numbers{1, 2, 3}));
    edits.push_back(of(EditKind::Undo, 2));
    EXPECT_EQ(effect(edits), (Numbers{1}));
    edits.push_back(of(EditKind::Redo, 2));
    EXPECT_EQ(effect(edits), (Numbers{1, 2, 3}));
    edits.push_back(stamp(5, true));  // 4 is gone for good
    EXPECT_EQ(effect(edits), (Numbers{1, 2, 3, 5}));
    edits.push_back(of(EditKind::Undo, 5));
    edits.push_back(of(EditKind::Undo, 2));
    edits.push_back(of(EditKind::Undo, 1));
    EXPECT_EQ(effect(edits), Numbers{});
    edits.push_back(of(EditKind::Redo, 1));
    edits.push_back(of(EditKind::Redo, 2));
    EXPECT_EQ(effect(edits), (Numbers{1, 2, 3}));
}

TEST_P(Rebuild, StampsInEffectAloneGiveTheGroundThatWasUndoneAndRedone) {
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        const Lived lived(seed, GetParam(), 30);
        const auto again = test::small_world(GetParam());
        for (const StampRecord& record : stamps_in_effect(lived.edits)) again->apply(record);
        EXPECT_EQ(again->hash(), lived.world.ground->hash()) << "seed " << seed;
    }
}

TEST_P(Rebuild, AnyPagesAreThoseOfTheWholeWorld) {
    std::size_t compared = 0, touched = 0;
    for (std::uint32_t seed = 11; seed <= 18; ++seed) {
        const Lived lived(seed, GetParam(), 25);
        const std::vector<StampRecord> stamps = stamps_in_effect(lived.edits);
        RandomRequests random(seed);
        for (const MapKind kind : {MapKind::Coarse, MapKind::Detail}) {
            const std::set<PageIndex> all = all_pages(*lived.world.ground, kind);
            std::vector<std::set<PageIndex>> subsets{all};
            for (const PageIndex page : all) subsets.push_back({page});
            for (int i = 0; i < 4; ++i) {
                subsets.emplace_back();
                for (const PageIndex page : all)
                    if (random.chance(0.3)) subsets.back().insert(page);
            }
            for (const std::set<PageIndex>& pages : subsets) {
                const std::vector<Page> rebuilt = lived.rebuilt(kind, pages, stamps);
                ASSERT_EQ(rebuilt.size(), pages.size());
                auto wanted = pages.begin();
                for (const Page& page : rebuilt) {
                    ASSERT_EQ(page.index, *wanted++);
                    ASSERT_EQ(*page.codes, lived.page(kind, page.index))
                        << "seed " << seed << " page " << page.index.x << ", " << page.index.z;
                    ++compared;
                    touched += is_untouched(*page.codes) ? 0 : 1;
                }
            }
        }
    }
    EXPECT_GT(compared, 500u);
    EXPECT_GT(touched, compared / 2);
}

// The definition of a stamp, written down a second time, on dense arrays.
TEST_P(Rebuild, PagesAreThoseOfTheDefinition) {
    const Lived lived(99, GetParam(), 20);
    const Ground& ground = *lived.world.ground;
    const std::vector<StampRecord> stamps = stamps_in_effect(lived.edits);
    for (const MapKind kind : {MapKind::Coarse, MapKind::Detail}) {
        const MapGeometry& map = ground.map(kind);
        const std::int32_t width = map.grid.width, depth = map.grid.depth;
        std::vector<std::uint32_t> codes;
        for (std::int32_t z = 0; z < depth; ++z)
            for (std::int32_t x = 0; x < width; ++x)
                codes.push_back(kind == MapKind::Coarse ? ground.original_code({x, z}) : kMidCode);
        for (const StampRecord& record : stamps) {
            if (record.map != kind) continue;
            const reference::Stamp stamp(record, map, ground.shapes());
            ASSERT_FALSE(stamp.doubtful());
            stamp.apply(codes, width, depth);
        }
        for (const Page& page : lived.rebuilt(kind, all_pages(ground, kind), stamps)) {
            const TexelRect whole = texels_of(page.index), part = intersection(whole, map.grid.rect());
            for (std::int32_t z = part.min.z; z < part.max.z; ++z)
                for (std::int32_t x = part.min.x; x < part.max.x; ++x)
                    ASSERT_EQ((*page.codes)[static_cast<std::size_t>((z - whole.min.z) * 64 + x - whole.min.x)],
                              codes[static_cast<std::size_t>(z * width + x)])
                        << "map " << static_cast<int>(kind) << " texel " << x << ", " << z;
        }
    }
}

// Each smooth asks for one page more on each side, going back in time, and other rules for none.
TEST(RebuildCost, IsThePageAndWhatSmoothReadsAroundIt) {
    auto ground = test::flat_ground(64 * 8, {.detail = false});
    const auto request = [&](StampRule rule, double radius_m) {
        return test::issued(*ground, {.shape = {0},
                                      .centre = {224, 224},
                                      .radius_m = radius_m,
                                      .amplitude_m = 0.5,
                                      .map = MapChoice::Coarse,
                                      .rule = rule,
                                      .level_m = 9.0});
    };
    const auto pages_read = [&](const std::vector<StampRecord>& stamps) {
        std::set<PageIndex> pages;
        rebuild_pages({{3, 3}}, stamps, ground->map(MapKind::Coarse), ground->shapes(), [&](Texel t) {
            EXPECT_TRUE(ground->map(MapKind::Coarse).grid.rect().contains(t));
            pages.insert(page_of(t));
            return kMidCode;
        });
        return pages.size();
    };
    EXPECT_EQ(pages_read({}), 1u);
    EXPECT_EQ(pages_read({request(StampRule::Add, 200), request(StampRule::Set, 200), request(StampRule::Min, 200)}),
              1u);
    EXPECT_EQ(pages_read({request(StampRule::Smooth, 10)}), 1u);  // stays inside the page
    EXPECT_EQ(pages_read({request(StampRule::Smooth, 200)}), 9u);
    EXPECT_EQ(
        pages_read({request(StampRule::Smooth, 200), request(StampRule::Add, 200), request(StampRule::Smooth, 200)}),
        25u);
}

}  // namespace
}  // namespace tilth
