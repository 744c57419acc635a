// Change sets: whatever changed is in them, and no code lies outside the ranges that they state.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "support/gl_context.h"
#include "support/random_world.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth {
namespace {

class ChangesTest : public test::GlTest {
protected:
    static std::unique_ptr<Terrain> open(ExecutorKind executor, bool with_gl, bool publish = true) {
        TerrainSettings settings{.clipmap = {.n = 31, .levels = 3}};
        settings.ground.tile_size = 128;
        settings.executor = executor;
        settings.undo_bytes = 64u << 20;
        settings.publish_changes = publish;
        return test::value(
            Terrain::create(make_ridged_source({.seed = 5, .size = 129, .relief_m = 50}), settings,
                            with_gl ? test::test_context(test::default_route()).context->get_proc() : nullptr));
    }

    static void stamp(Terrain& terrain, std::uint64_t number) {
        for (const MapChoice map : {MapChoice::Coarse, MapChoice::Detail}) {
            RandomStamps stamps{.seed = 7 + number, .count = 5, .map = map};
            stamps.region = {WorldPos{-3, -3}, WorldPos{131, 131}};
            stamps.radius_m = {0.1, map == MapChoice::Coarse ? 12.0 : 3.0};
            stamps.amplitude_m = {-1, 1};
            for (std::uint32_t shape = 0; shape < kBuiltinProfiles; ++shape) stamps.shapes.push_back({shape});
            stamps.rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth};
            for (const StampRequest& request : random_stamps(stamps, terrain.ground()))
                ASSERT_TRUE(terrain.stamp(request));
        }
        if (number % 2 == 1) {
            ASSERT_TRUE(terrain.undo());
        }
    }
};

/// Of one map: codes before and after, and the changes since. Each texel that differs lies in one; its old code is in
/// the range of the first, its new one in that of the last.
template <class CodeBefore, class CodeAfter>
void expect_explained(const std::vector<Change>& changes, MapKind map, const TexelRect& all, const CodeBefore& before,
                      const CodeAfter& after, std::int64_t& changed) {
    for (std::int32_t z = all.min.z; z < all.max.z; ++z)
        for (std::int32_t x = all.min.x; x < all.max.x; ++x) {
            const std::uint32_t was = before(Texel{x, z}), is = after(Texel{x, z});
            const Change *first = nullptr, *last = nullptr;
            for (const Change& change : changes) {
                const TexelRect& r = change.rect;
                if (change.map != map || x < r.min.x || z < r.min.z || x >= r.max.x || z >= r.max.z) continue;
                if (first == nullptr) first = &change;
                last = &change;
            }
            if (was != is) {
                ASSERT_NE(first, nullptr) << x << " " << z << " changed and nobody was told";
                ++changed;
            }
            if (first == nullptr) continue;
            ASSERT_TRUE(first->before.min <= was && was <= first->before.max) << x << " " << z;
            ASSERT_TRUE(last->after.min <= is && is <= last->after.max) << x << " " << z;
        }
}

TEST_F(ChangesTest, TellOfEveryTexelAndNeverTooNarrowARange) {
    for (const auto& [executor, with_gl] : {std::pair(ExecutorKind::Gpu, true), std::pair(ExecutorKind::Cpu, true),
                                            std::pair(ExecutorKind::Cpu, false)}) {
        SCOPED_TRACE(testing::Message() << "gpu " << (executor == ExecutorKind::Gpu) << " gl " << with_gl);
        const auto terrain = open(executor, with_gl), truth = open(ExecutorKind::Cpu, false);
        std::int64_t coarse_changed = 0, detail_changed = 0;
        for (std::uint64_t round = 0; round < 8; ++round) {
            const HeightField coarse = truth->ground().coarse();
            const DetailField detail = truth->ground().detail();
            std::vector<Change> changes;
            const auto frame = [&] {
                ASSERT_TRUE(terrain->update(0));
                changes.insert(changes.end(), terrain->changes().begin(), terrain->changes().end());
            };
            for (std::uint64_t i = 0; i < 3; ++i) {
                const WorldPos viewer{16.0 + static_cast<double>(round) * 13, 64};
                terrain->set_viewers({&viewer, 1});
                for (Terrain* each : {terrain.get(), truth.get()}) stamp(*each, 3 * round + i);
                frame();
                ASSERT_TRUE(truth->update(0));
            }
            ASSERT_TRUE(terrain->drain());  // smooth and undo that waited for tiles
            frame();
            const MapGeometry& map = truth->ground().map(MapKind::Detail);
            expect_explained(
                changes, MapKind::Coarse, coarse.rect(), [&](Texel t) { return coarse.code(t); },
                [&](Texel t) { return truth->ground().coarse().code(t); }, coarse_changed);
            expect_explained(
                changes, MapKind::Detail, map.grid.rect(), [&](Texel t) { return detail.code(t); },
                [&](Texel t) { return truth->ground().detail().code(t); }, detail_changed);
            if (HasFatalFailure()) return;
            frame();
            EXPECT_TRUE(terrain->changes().empty()) << "nothing happened since";
        }
        EXPECT_GT(coarse_changed, 100);
        EXPECT_GT(detail_changed, 100);
    }
}

TEST_F(ChangesTest, OfOneStampInMemoryAreExact) {
    const auto terrain = open(ExecutorKind::Cpu, false);
    const StampRecord record = test::value(terrain->stamp({.shape = {5},
                                                           .centre = {256 / 3.0, 256 / 3.0},
                                                           .radius_m = 3,
                                                           .amplitude_m = -0.5,
                                                           .map = MapChoice::Detail}));
    ASSERT_TRUE(terrain->update(0));
    ASSERT_EQ(terrain->changes().size(), 4u) << "tiles of 128 texels, three a metre: it lies on a corner";
    for (const Change& change : terrain->changes()) {
        EXPECT_EQ(change.map, MapKind::Detail);
        EXPECT_EQ(change.before, (CodeRange{kMidCode, kMidCode}));
        EXPECT_EQ(change.after, (CodeRange{kMidCode - (1u << 27), kMidCode})) << "half a metre is 2^27 codes";
        EXPECT_EQ(change.first_sequence, record.sequence);
        EXPECT_EQ(change.last_sequence, record.sequence);
    }
}

TEST_F(ChangesTest, CostNothingUnlessTheyAreAskedFor) {
    const auto terrain = open(ExecutorKind::Cpu, true, false);
    stamp(*terrain, 1);
    ASSERT_TRUE(terrain->update(0));
    EXPECT_TRUE(terrain->changes().empty());
}

}  // namespace
}  // namespace tilth
