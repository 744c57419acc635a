// Which texels a stamp touches: clipping, world offsets, dense and sparse maps.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "ground/support.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

TEST(StampPlacing, RectanglesHoldTheStampAndAreAtMostOneTexelWider) {
    const MapGeometry map = test::map_of(200);
    const ShapeLibrary shapes;
    std::mt19937_64 random(17);
    for (int i = 0; i < 3000; ++i) {
        StampRecord record =
            test::record_at(80 + 1e-18 * static_cast<double>(random()), 100,
                            6 + static_cast<double>(random() % 20000) / 1024, 1, test::builtin(BuiltinProfile::Disc));
        record.centre_z -= static_cast<std::int64_t>(random() % (1u << 26));
        const TexelRect rect = prepare(record, map, shapes).rect();
        const double x = static_cast<double>(record.centre_x) * 0x1p-24,
                     z = static_cast<double>(record.centre_z) * 0x1p-24, r = record.radius / 262144.0;
        // Texels nearer than r on the axis are inside; nothing that is a texel further away is.
        EXPECT_LE(rect.min.x, static_cast<int>(std::floor(x - r)) + 1);
        EXPECT_GE(rect.min.x, static_cast<int>(std::floor(x - r - 1.0 / 1024)));
        EXPECT_GE(rect.max.x, static_cast<int>(std::ceil(x + r)));
        EXPECT_LE(rect.max.z, static_cast<int>(std::floor(z + r + 1.0 / 1024)) + 1);
        EXPECT_LE(rect.width(), 2 * r + 1.01) << r;  // so many texels lie on a closed stretch of 2 r
        EXPECT_LE(rect.depth(), 2 * r + 1.01) << r;
    }
}

// S10.
TEST(StampPlacing, IsClippedToTheMap) {
    auto ground = test::flat_ground(33, {.detail = false});
    const StateHash before = ground->hash();
    const auto at = [&](double x, double z, BuiltinProfile profile = BuiltinProfile::Disc) {
        return test::stamp(*ground,
                           {.shape = test::builtin(profile), .centre = {x, z}, .radius_m = 8, .amplitude_m = 0.5});
    };
    for (const WorldPos far : {WorldPos{-8.5, 16}, {41, 16}, {16, -9}, {16, 1e6}, {-1e9, -1e9}, {1e10, 5}}) {
        const ApplyResult result = at(far.x, far.z);
        EXPECT_EQ(result.texels, 0u) << far.x << ", " << far.z;
        EXPECT_TRUE(result.rect.empty());
        EXPECT_EQ(ground->hash(), before);
    }
    for (const WorldPos half : {WorldPos{0, 16}, {32, 16}, {16, 0}, {16, 32}}) {
        const HeightField old = ground->coarse();
        const ApplyResult result = at(half.x, half.z);
        EXPECT_NEAR(static_cast<double>(result.texels), 17 * 9, 17 + 9) << half.x << ", " << half.z;
        int changed = 0, expected = 0;
        for (int z = 0; z < 33; ++z)
            for (int x = 0; x < 33; ++x) {
                const bool inside = (x - half.x) * (x - half.x) + (z - half.z) * (z - half.z) < 64;
                expected += inside ? 1 : 0;
                changed += ground->coarse().code({x, z}) != old.code({x, z}) ? 1 : 0;
                ASSERT_EQ(ground->coarse().code({x, z}) != old.code({x, z}), inside) << x << ", " << z;
                if (inside) {
                    ASSERT_TRUE(result.rect.contains({x, z}));
                }
            }
        EXPECT_EQ(changed, expected);
    }
    EXPECT_EQ(at(0, 0).texels, 81u);  // posts 0..8 each way
    EXPECT_EQ(test::stamp(*ground, {.shape = {0}, .centre = {16, 16}, .radius_m = 5000, .amplitude_m = 0.1}).texels,
              33u * 33u);
}

// S15: ten thousand kilometres away the same codes as at zero, both maps, to the last bit. Offsets that doubles hold
// there.
TEST(StampPlacing, IsTheSameFarFromTheOrigin) {
    for (const HeightPrecision precision : test::kBothPrecisions)
        for (const WorldPos origin : {WorldPos{1e7, -1e7}, {-1e7, 12345678.5}, {999999999, -1e9}}) {
            auto near = test::flat_ground(65, {.precision = precision});
            auto far = test::flat_ground(65, {.origin = origin, .precision = precision});
            const test::UserShapes a(near->shapes()), b(far->shapes());
            std::mt19937 random(18);
            for (int i = 0; i < 200; ++i) {
                StampRequest request{.shape = {static_cast<std::uint32_t>(random() % near->shapes().size())},
                                     .centre = {(random() % 66000) / 1024.0, (random() % 66000) / 1024.0},
                                     .radius_m = 0.1 + (random() % 1000) * 0.015,
                                     .amplitude_m = 0.01,
                                     .rotation_rad = i * 0.1};
                test::stamp(*near, request);
                request.centre.x += origin.x, request.centre.z += origin.z;
                test::stamp(*far, request);
            }
            EXPECT_EQ(near->hash(), far->hash()) << origin.x;
        }
    // An arbitrary centre is off by at most 1e-3 texel: half of 2^-24 m and half a sub-texel, with the double's own
    // ulp.
    auto far = test::flat_ground(65, {.origin = {1e7, 1e7}});
    std::mt19937_64 random(19);
    for (int i = 0; i < 1000; ++i) {
        const double x = 1e7 + 60.0 * static_cast<double>(random()) * 0x1p-64;
        const StampRecord record = test::issued(
            *far, {.shape = {0}, .centre = {x, 1e7 + 30}, .radius_m = 1, .amplitude_m = 1, .map = MapChoice::Detail});
        const PreparedStamp stamp = prepare(record, far->map(MapKind::Detail), far->shapes());
        const double texels = stamp.params.centre_x + stamp.params.offset_x / 1024.0;
        EXPECT_NEAR(texels, static_cast<double>((static_cast<long double>(x) - 1e7L) * 3), 1e-3);
    }
}

TEST(StampPlacing, TheSparseMapIsTheDenseMap) {
    for (const HeightPrecision precision : test::kBothPrecisions) {
        constexpr int kSide = 321;  // not a multiple of a page
        const MapGeometry map = test::map_of(kSide, precision);
        ShapeLibrary shapes;
        const test::UserShapes user(shapes);
        HeightField dense(kSide, kSide);
        DetailField sparse;
        std::mt19937 random(20);
        for (int i = 0; i < 400; ++i) {
            StampRecord record = test::record_at(random() % 400 - 40.0 + 0.37, random() % 400 - 40.3,
                                                 1 + random() % (i % 10 == 0 ? 150 : 20), random() >> 4,
                                                 {static_cast<std::uint32_t>(random() % shapes.size())},
                                                 static_cast<StampRule>(random() % 5));
            if (record.rule == StampRule::Smooth) record.amplitude &= 0xffff;
            record.rotation = static_cast<std::uint32_t>(random());
            record.key = static_cast<std::uint32_t>(random());
            record.negative = static_cast<std::uint8_t>(random() % 2);
            const PreparedStamp stamp = prepare(record, map, shapes);
            const ApplyResult a = apply_stamp(stamp, dense), b = apply_stamp(stamp, sparse, map.grid.rect());
            ASSERT_EQ(a.rect, b.rect);
            ASSERT_EQ(a.texels, b.texels);
            ASSERT_EQ(a.saturated, b.saturated);
        }
        for (int z = 0; z < kSide; ++z)
            for (int x = 0; x < kSide; ++x) ASSERT_EQ(sparse.code({x, z}), dense.code({x, z})) << x << ", " << z;
        // Beyond the map nothing was written, though pages reach there.
        for (int z = 0; z < 384; ++z) ASSERT_EQ(sparse.code({kSide, z}), kMidCode);
        for (const auto& [page, codes] : sparse.pages())
            ASSERT_TRUE(page.x >= 0 && page.x < 6 && page.z >= 0 && page.z < 6);
    }
}

TEST(DetailField, PagesAreMadeWhereTheyAreTouched) {
    DetailField field;
    EXPECT_EQ(field.code({5, -70}), kMidCode);
    EXPECT_EQ(field.find({0, -2}), nullptr);
    EXPECT_EQ(page_of({63, 64}), (PageIndex{0, 1}));
    EXPECT_EQ(page_of({-1, -64}), (PageIndex{-1, -1}));
    field.touch({0, -2})[58 * 64 + 5] = 7;  // row -70 is row 58 of page -2
    EXPECT_EQ(field.code({5, -70}), 7u);
    EXPECT_EQ(field.code({6, -70}), kMidCode);
    EXPECT_EQ(field.pages().size(), 1u);
}

}  // namespace
}  // namespace tilth
