// Undo and redo give the very bits back that were there, for every kind of stamp, on both maps.
#include "tilth/ground/apply_edit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ground/random_edits.h"
#include "tilth/ground/before_image.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

using test::kPlenty;
using test::RandomRequests;
using test::Undoable;

class ApplyEdit : public testing::TestWithParam<HeightPrecision> {};
INSTANTIATE_TEST_SUITE_P(Both, ApplyEdit, testing::ValuesIn(test::kBothPrecisions), [](const auto& param) {
    return param.param == HeightPrecision::bits32 ? "bits32" : "bits16";
});

bool has_images(const Stroke& stroke) { return !stroke.coarse.empty() || !stroke.detail.empty(); }

TEST_P(ApplyEdit, UndoingGivesEachStateBackAndRedoingToo) {
    std::size_t with_images = 0, without_images = 0;
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        RandomRequests random(seed);
        Undoable world(test::small_world(GetParam()), kPlenty);
        std::vector<StateHash> states{world.ground->hash()};
        while (states.size() <= 12) {
            world.random_stroke(random);
            states.push_back(world.ground->hash());
            (has_images(*world.history.done().back()) ? with_images : without_images) += 1;
        }
        for (int round = 0; round < 2; ++round) {
            for (std::size_t k = states.size() - 1; k-- > 0;) {
                ASSERT_TRUE(world.undo());
                ASSERT_EQ(world.ground->hash(), states[k]) << "seed " << seed << ", undo to " << k;
            }
            for (std::size_t k = 1; k < states.size(); ++k) {
                ASSERT_TRUE(world.redo());
                ASSERT_EQ(world.ground->hash(), states[k]) << "seed " << seed << ", redo to " << k;
            }
        }
    }
    EXPECT_GT(with_images, 20u);  // the seeds have both kinds
    EXPECT_GT(without_images, 5u);
}

TEST_P(ApplyEdit, ARandomWalkThroughTheHistoryMeetsTheStatesItRemembers) {
    RandomRequests random(77);
    Undoable world(test::small_world(GetParam()), kPlenty);
    std::vector<StateHash> past{world.ground->hash()}, future;  // past.back(): now
    int undone = 0, redone = 0;
    for (int step = 0; step < 200; ++step) {
        const double what = random.real(0, 1);
        if (what < 0.35 && past.size() > 1) {
            ASSERT_TRUE(world.undo());
            future.push_back(past.back());
            past.pop_back();
            ++undone;
        } else if (what < 0.6 && !future.empty()) {
            ASSERT_TRUE(world.redo());
            past.push_back(future.back());
            future.pop_back();
            ++redone;
        } else {
            world.random_stroke(random, 4);
            past.push_back(world.ground->hash());
            future.clear();
        }
        ASSERT_EQ(world.ground->hash(), past.back()) << "step " << step;
        ASSERT_EQ(world.history.undoable(), past.size() - 1);
        ASSERT_EQ(world.history.redoable(), future.size());
    }
    EXPECT_GT(undone, 30);
    EXPECT_GT(redone, 10);
}

TEST_P(ApplyEdit, WithABoundUndoGoesAsFarAsItSaysAndNoFurther) {
    RandomRequests random(3);
    Undoable world(test::small_world(GetParam()), 600'000);
    std::vector<StateHash> states{world.ground->hash()};
    while (states.size() <= 40) {
        world.random_stroke(random, 3);
        world.history.trim();
        states.push_back(world.ground->hash());
    }
    const std::size_t undoable = world.history.undoable();
    EXPECT_LE(world.history.bytes(), 600'000u);
    ASSERT_GT(undoable, 0u);
    ASSERT_LT(undoable, 40u);
    for (std::size_t k = 1; k <= undoable; ++k) {
        ASSERT_TRUE(world.undo());
        ASSERT_EQ(world.ground->hash(), states[40 - k]);
    }
    EXPECT_FALSE(world.undo());
    EXPECT_EQ(world.ground->hash(), states[40 - undoable]);
}

// `add` alone within the range: sixty-four bytes a stamp, no page is kept, and none is put back.
TEST_P(ApplyEdit, AddsThatStayInTheRangeKeepNoImages) {
    Undoable world(test::small_world(GetParam()), kPlenty);
    const StateHash before = world.ground->hash();
    for (std::uint32_t i = 0; i < 50; ++i)
        world.stamp({.shape = {i % 9},
                     .centre = {10.0 + i * 0.4, 30.0},
                     .radius_m = 0.1 + i * 0.1,
                     .amplitude_m = i % 2 == 0 ? 0.05 : -0.07,
                     .map = i % 3 == 0 ? MapChoice::Coarse : MapChoice::Detail},
                    i == 0);
    EXPECT_FALSE(has_images(*world.history.done().back()));
    EXPECT_LE(world.history.bytes(), 256 + 50 * sizeof(StampRecord));
    EXPECT_NE(world.ground->hash(), before);
    ASSERT_TRUE(world.undo());
    EXPECT_EQ(world.ground->hash(), before);
}

// A stroke of three heaps, 3 m each on ground that ends 8 m up: the third saturates. Its page needs an image from
// before the first, which has to be computed by then; the page next door needs none.
TEST_P(ApplyEdit, AnAddThatSaturatesKeepsThePageFromBeforeTheStroke) {
    for (const MapChoice choice : {MapChoice::Detail, MapChoice::Coarse}) {
        Undoable world(test::small_world(GetParam()), kPlenty);
        const MapKind kind = choice == MapChoice::Detail ? MapKind::Detail : MapKind::Coarse;
        const MapGeometry& map = world.ground->map(kind);
        StampRequest heap{.shape = test::builtin(BuiltinProfile::Disc),
                          .centre = map.grid.world({20, 20}),
                          .radius_m = 8 * map.grid.spacing_m,
                          .amplitude_m = map.codec.quantum_m * 65536 * 3 / 16,
                          .map = choice};
        StampRequest dent = heap;  // an earlier stroke, so that the page is not untouched
        dent.amplitude_m = -0.01;
        world.stamp(dent);
        const StateHash before = world.ground->hash();
        const PageCodes page_before = kind == MapKind::Detail ? *world.ground->detail().find({0, 0})
                                                              : page_of_field(world.ground->coarse(), {0, 0});
        StampRequest small = heap;
        small.centre = map.grid.world({90, 20});
        small.amplitude_m = 0.02;
        world.stamp(small, true);
        EXPECT_EQ(world.stamp(heap, false).saturated, 0u);
        EXPECT_EQ(world.stamp(heap, false).saturated, 0u);
        EXPECT_FALSE(has_images(*world.history.done().back()));
        EXPECT_GT(world.stamp(heap, false).saturated, 100u);
        const Stroke& stroke = *world.history.done().back();
        ASSERT_EQ(stroke.images(kind).size(), 1u);
        ASSERT_EQ(stroke.images(kind).count({0, 0}), 1u);
        EXPECT_EQ(*stroke.images(kind).at({0, 0}), page_before);
        const StateHash after = world.ground->hash();
        ASSERT_TRUE(world.undo());
        EXPECT_EQ(world.ground->hash(), before);
        ASSERT_TRUE(world.redo());
        EXPECT_EQ(world.ground->hash(), after);
        ASSERT_TRUE(world.undo());
        EXPECT_EQ(world.ground->hash(), before);
    }
}

TEST_P(ApplyEdit, PagesThatWereNotThereGoAgain) {
    Undoable world(test::small_world(GetParam()), kPlenty);
    const StampRequest set{.shape = test::builtin(BuiltinProfile::Disc),
                           .centre = world.ground->map(MapKind::Detail).grid.world({64, 64}),  // on four pages
                           .radius_m = 3,
                           .amplitude_m = 0,
                           .map = MapChoice::Detail,
                           .rule = StampRule::Set,
                           .level_m = 1};
    world.stamp(set);
    const Stroke& stroke = *world.history.done().back();
    EXPECT_EQ(world.ground->detail().pages().size(), 4u);
    ASSERT_EQ(stroke.detail.size(), 4u);
    for (const auto& [page, image] : stroke.detail) EXPECT_EQ(image, nullptr);
    EXPECT_LT(world.history.bytes(), 1000u);
    ASSERT_TRUE(world.undo());
    EXPECT_TRUE(world.ground->detail().pages().empty());
}

// Everything is issued before anything is applied, and the history forgets meanwhile.
TEST_P(ApplyEdit, AnUndoThatWaitsIsAppliedWhole) {
    RandomRequests random(8);
    Undoable world(test::small_world(GetParam()), 1);
    world.random_stroke(random);
    world.history.trim();
    const StateHash before = world.ground->hash();
    std::vector<GroundEdit> waiting;
    for (int i = 0; i < 12; ++i) {
        waiting.push_back(world.history.add(test::issued(*world.ground, random.next(*world.ground)), i == 0));
        ASSERT_NE(waiting.back().stroke, nullptr);
    }
    waiting.push_back(undo_edit(*world.history.undo()));
    const GroundEdit next = world.history.add(test::issued(*world.ground, random.next(*world.ground)), true);
    for (const GroundEdit& edit : waiting) {
        world.history.trim();
        apply_edit(*world.ground, edit);
    }
    EXPECT_EQ(world.ground->hash(), before);
    const StrokePtr stroke = waiting.back().stroke;
    EXPECT_TRUE(has_images(*stroke));
    waiting.clear();
    EXPECT_TRUE(stroke->forgotten);
    EXPECT_FALSE(has_images(*stroke));
    EXPECT_TRUE(next.stroke->forgotten);  // by the bound
}

TEST_P(ApplyEdit, NothingIsKeptForAForgottenStroke) {
    Undoable world(test::small_world(GetParam()), 1);
    const StampRequest set{.shape = {0},
                           .centre = {10, 30},
                           .radius_m = 5,
                           .map = MapChoice::Detail,
                           .rule = StampRule::Set,
                           .level_m = 1};
    const GroundEdit edit = world.history.add(test::issued(*world.ground, set), true);
    world.history.trim();
    apply_edit(*world.ground, edit);
    EXPECT_FALSE(has_images(*edit.stroke));
    EXPECT_FALSE(world.ground->detail().pages().empty());
}

// What a cache does: stamps reach the tiles one after the other, whenever each is loaded.
TEST_P(ApplyEdit, ImagesKeptTileByTileAreThoseOfTheWholeMap) {
    RandomRequests random(21);
    Undoable whole(test::small_world(GetParam()), kPlenty);
    const MapGeometry& map = whole.ground->map(MapKind::Detail);
    UndoHistory history(kPlenty);
    std::vector<GroundEdit> edits;
    for (int i = 0; i < 40; ++i) {
        StampRequest request = random.next(*whole.ground);
        request.map = MapChoice::Detail;
        request.level_m = 0.5;
        if (request.rule == StampRule::Smooth) request.rule = StampRule::Set;  // smooth is not clipped to tiles
        const bool begins = i % 8 == 0;
        const Result<StampRecord> record = whole.ground->issue(request);
        if (!record) continue;  // an amplitude of the coarse map
        apply_edit(*whole.ground, whole.history.add(*record, begins));
        edits.push_back(history.add(*record, begins));
    }
    ASSERT_GT(edits.size(), 30u);
    DetailField field;
    for (std::int32_t z = 2; z >= 0; --z)
        for (std::int32_t x = 0; x < 3; ++x) {
            const TexelRect tile = intersection({{x * 128, z * 128}, {(x + 1) * 128, (z + 1) * 128}}, map.grid.rect());
            for (const GroundEdit& edit : edits) {
                const PreparedStamp stamp = prepare(edit.record, map, whole.ground->shapes());
                keep_images(edit, stamp, tile, field, map, whole.ground->shapes());
                apply_stamp(stamp, field, tile);
            }
        }
    std::size_t images = 0;
    ASSERT_EQ(history.undoable(), whole.history.undoable());
    for (std::size_t i = 0; i < history.undoable(); ++i) {
        const Stroke::Images& a = history.done()[i]->detail;
        const Stroke::Images& b = whole.history.done()[i]->detail;
        ASSERT_EQ(a.size(), b.size());
        for (const auto& [page, image] : a) {
            ASSERT_TRUE(b.contains(page));
            ASSERT_EQ(image == nullptr, b.at(page) == nullptr);
            if (image == nullptr) continue;
            EXPECT_EQ(*image, *b.at(page));
            ++images;
        }
    }
    EXPECT_GT(images, 20u);
}

TEST_P(ApplyEdit, ChangedByHoldsEveryTexelThatChanges) {
    RandomRequests random(31);
    Undoable world(test::small_world(GetParam()), kPlenty);
    for (int i = 0; i < 15; ++i) {
        const HeightField coarse = world.ground->coarse();
        const DetailField detail = world.ground->detail();
        std::vector<ChangedRect> changed;
        if (i % 3 == 2) {
            const GroundEdit edit = undo_edit(*world.history.undo());
            changed = changed_by(*world.ground, edit);
            apply_edit(*world.ground, edit);
        } else {
            for (int k = 0; k < 3; ++k) {
                const GroundEdit edit =
                    world.history.add(test::issued(*world.ground, random.next(*world.ground)), k == 0);
                for (const ChangedRect& rect : changed_by(*world.ground, edit)) changed.push_back(rect);
                apply_edit(*world.ground, edit);
            }
        }
        const auto check = [&](MapKind kind, const auto& before, const auto& after) {
            const GridSpec& grid = world.ground->map(kind).grid;
            for (std::int32_t z = 0; z < grid.depth; ++z)
                for (std::int32_t x = 0; x < grid.width; ++x) {
                    if (before.code({x, z}) == after.code({x, z})) continue;
                    ASSERT_TRUE(std::any_of(changed.begin(), changed.end(), [&](const ChangedRect& rect) {
                        return rect.map == kind && rect.rect.contains({x, z});
                    }));
                }
        };
        check(MapKind::Coarse, coarse, world.ground->coarse());
        check(MapKind::Detail, detail, world.ground->detail());
    }
}

TEST_P(ApplyEdit, TheReachOfARecordHoldsItsRectangle) {
    RandomRequests random(41);
    const auto world = test::small_world(GetParam());
    for (int i = 0; i < 3000; ++i) {
        const StampRecord record = test::issued(*world, random.next(*world));
        const MapGeometry& map = world->map(record.map);
        const TexelRect rect = prepare(record, map, world->shapes()).rect(),
                        reach = reach_of(record, map, world->shapes());
        if (!rect.empty()) {
            ASSERT_EQ(intersection(rect, reach), rect) << i;
        }
        if (!reach.empty()) {
            ASSERT_EQ(intersection(reach, map.grid.rect()), reach) << i;
        }
    }
}

TEST(NeedsImages, IsEveryRuleButAnAddWellInsideTheRange) {
    const MapGeometry map = test::map_of(64);
    const ShapeLibrary shapes;
    for (const StampRule rule : {StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth})
        EXPECT_TRUE(needs_images(prepare(test::record_at(30, 30, 9, 5, {0}, rule), map, shapes), kMidCode, kMidCode));
    const PreparedStamp add = prepare(test::record_at(30, 30, 9, 1000, {0}), map, shapes);
    EXPECT_FALSE(needs_images(add, kMidCode, kMidCode));
    EXPECT_FALSE(needs_images(add, 10, 0xffffffffu - 2000));
    EXPECT_TRUE(needs_images(add, kMidCode, 0xffffffffu - 999));
}

TEST(PagesOfAField, ComeAndGoAsFarAsTheyLieInside) {
    HeightField field(100, 70);
    for (std::int32_t z = 0; z < 70; ++z)
        for (std::int32_t x = 0; x < 100; ++x) field.set_code({x, z}, static_cast<std::uint32_t>(z * 1000 + x));
    const PageCodes corner = page_of_field(field, {1, 1});
    for (std::int32_t z = 0; z < 64; ++z)
        for (std::int32_t x = 0; x < 64; ++x)
            ASSERT_EQ(corner[static_cast<std::size_t>(z * 64 + x)],
                      x < 36 && z < 6 ? static_cast<std::uint32_t>((z + 64) * 1000 + x + 64) : kMidCode);
    HeightField other(100, 70);
    put_page(other, {1, 1}, corner);
    for (std::int32_t z = 0; z < 70; ++z)
        for (std::int32_t x = 0; x < 100; ++x)
            ASSERT_EQ(other.code({x, z}), x >= 64 && z >= 64 ? field.code({x, z}) : kMidCode);
}

TEST(OriginalCodes, OutliveTheGroundAndItsStamps) {
    for (const bool mirror : {false, true}) {
        auto made = Ground::create(std::make_shared<HillSource>(33, 5.0, 8.0), {.mirror = mirror});
        ASSERT_TRUE(made.ok());
        std::unique_ptr<Ground> ground = *std::move(made);
        std::vector<std::uint32_t> before;
        const auto read = [](const auto& code_at) {
            std::vector<std::uint32_t> codes;
            for (std::int32_t z = -3; z < 70; ++z)
                for (std::int32_t x = -3; x < 70; ++x) codes.push_back(code_at(Texel{x, z}));
            return codes;
        };
        before = read([&](Texel t) { return ground->coarse_code(t); });
        if (!mirror)
            test::stamp(*ground,
                        {.shape = {0}, .centre = {9, 9}, .radius_m = 9, .amplitude_m = 1, .map = MapChoice::Coarse});
        EXPECT_EQ(read([&](Texel t) { return ground->original_code(t); }), before);
        const auto original = ground->original_codes();
        ground.reset();
        EXPECT_EQ(read(original), before);
    }
}

TEST(Sequence, ContinuesFromTheLargest) {
    auto ground = test::flat_ground(33);
    EXPECT_EQ(ground->next_sequence(), 1u);
    ground->continue_from(40);
    EXPECT_EQ(test::issued(*ground, {.centre = {5, 5}}).sequence, 40u);
    ground->continue_from(7);
    EXPECT_EQ(ground->next_sequence(), 41u);
}

TEST(SharedPages, AreCopiedBeforeTheyAreWritten) {
    DetailField field;
    EXPECT_EQ(field.share({0, 0}), nullptr);
    field.touch({0, 0})[5] = 7;
    const std::shared_ptr<const PageCodes> share = field.share({0, 0});
    EXPECT_EQ(share.get(), field.find({0, 0}));
    field.touch({0, 0})[5] = 8;
    EXPECT_EQ((*share)[5], 7u);
    EXPECT_EQ(field.code({5, 0}), 8u);
}

}  // namespace
}  // namespace tilth
