// Persistent ground is exact: stamps commute, cancel, do not drift, saturate and are counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "ground/reference.h"
#include "ground/support.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

class Exact : public testing::TestWithParam<HeightPrecision> {
protected:
    GroundSettings settings() const { return {.precision = GetParam()}; }
};
INSTANTIATE_TEST_SUITE_P(Both, Exact, testing::ValuesIn(test::kBothPrecisions), [](const auto& param) {
    return param.param == HeightPrecision::bits32 ? "bits32" : "bits16";
});

/// Additive stamps of every shape, on both maps, over a world of 65 posts a side.
std::vector<StampRecord> additive_records(Ground& ground, int count) {
    const test::UserShapes user(ground.shapes());
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<StampRecord> records;
    for (int i = 0; i < count; ++i) {
        StampRequest request{.shape = {static_cast<std::uint32_t>(random() % ground.shapes().size())},
                             .centre = {unit(random) * 70 - 3, unit(random) * 70 - 3},
                             .radius_m = 0.05 * std::pow(300, unit(random)),
                             .amplitude_m = unit(random) * 0.04 - 0.02,
                             .rotation_rad = unit(random) * 7,
                             .mirror = random() % 2 == 0};
        request.map = i % 2 == 0 ? MapChoice::Coarse : MapChoice::Detail;
        records.push_back(test::issued(ground, request));
    }
    return records;
}

TEST_P(Exact, AdditiveStampsGiveTheSameHashInAnyOrder) {
    auto first = test::flat_ground(65, settings()), second = test::flat_ground(65, settings());
    std::vector<StampRecord> records = additive_records(*first, 600);
    const test::UserShapes same(second->shapes());
    std::uint64_t saturated = 0;
    for (const StampRecord& record : records) saturated += first->apply(record).saturated;
    ASSERT_EQ(saturated, 0u);
    std::shuffle(records.begin(), records.end(), std::mt19937(8));
    for (const StampRecord& record : records) second->apply(record);
    EXPECT_EQ(first->hash(), second->hash());
    EXPECT_NE(first->hash(), test::flat_ground(65, settings())->hash());
}

TEST_P(Exact, AStampAndItsNegationRestoreTheHash) {
    auto ground = test::flat_ground(65, settings());
    std::vector<StampRecord> records = additive_records(*ground, 300);
    for (std::size_t i = 0; i < 60; ++i) ground->apply(records[i]);
    const StateHash before = ground->hash();
    for (std::size_t i = 60; i < records.size(); ++i) ASSERT_EQ(ground->apply(records[i]).saturated, 0u);
    EXPECT_NE(ground->hash(), before);
    for (std::size_t i = 60; i < records.size(); ++i) ASSERT_EQ(ground->apply(negated(records[i])).saturated, 0u);
    EXPECT_EQ(ground->hash(), before);

    // Craters with their residue, clipped ones too; radii that are widened; each alone.
    for (const double radius : {0.001, 0.02, 0.3, 0.9999, 1.3, 7.7, 20.0})
        for (const double x : {32.3, 0.2, -1.0, 64.9})
            for (const BuiltinProfile profile : test::kAllProfiles) {
                const StampRecord record = test::issued(*ground, {.shape = test::builtin(profile),
                                                                  .centre = {x, 31.1},
                                                                  .radius_m = radius,
                                                                  .amplitude_m = -1.7,
                                                                  .map = MapChoice::Detail});
                ASSERT_EQ(ground->apply(record).saturated, 0u);
                ground->apply(negated(record));
                ASSERT_EQ(ground->hash(), before) << "radius " << radius << " profile " << static_cast<int>(profile);
            }
}

// One million overlapping stamps at one place, both signs, 1 mm and more at the peak.
TEST(ExactStamps, AMillionStampsAtOnePlaceAreTheSumInIntegers) {
    const MapGeometry map = test::map_of(24);
    const ShapeLibrary shapes;
    HeightField field(24, 24);
    std::vector<std::int64_t> sum(field.codes().size(), kMidCode);
    constexpr int kRecords = 8;
    std::vector<PreparedStamp> prepared;
    double real_m = 0;  // at the centre
    for (int i = 0; i < kRecords; ++i) {
        const double amplitude_m = (1.0 + 0.37 * i) * 1e-3;
        StampRecord record =
            test::record_at(11, 12, 1.8 + 0.4 * (i / 2), static_cast<std::uint32_t>(std::lround(amplitude_m * 0x1p28)),
                            {static_cast<std::uint32_t>(i / 2 % 4)});
        record.negative = static_cast<std::uint8_t>(i % 2);  // neighbours differ in amplitude: 0.37 mm a pair remain
        const reference::Stamp definition(record, map, shapes);
        for (std::size_t t = 0; t < sum.size(); ++t)
            sum[t] +=
                definition.change(static_cast<int>(t) % 24, static_cast<int>(t) / 24) * (1000000 / kRecords / 200);
        prepared.push_back(prepare(record, map, shapes));
        const double least = shapes.shape({record.shape}).least_radius_texels * 262144;
        const double widening = record.radius < least ? record.radius / least : 1.0;
        real_m += (i % 2 == 0 ? 1 : -1) * amplitude_m * widening * widening * (1000000.0 / kRecords / 200);
    }
    std::uint64_t saturated = 0;
    HeightField part(24, 24);
    // 200 times the same 5 000 stamps; after each the map starts where the last left off, down again by its negation.
    for (int round = 0; round < 200; ++round) {
        for (int i = 0; i < 1000000 / 200; ++i)
            saturated += apply_stamp(prepared[static_cast<std::size_t>(i % kRecords)], field).saturated;
        if (round == 0) part = field;
        if (round % 2 == 0) {
            for (std::size_t t = 0; t < sum.size(); ++t)
                ASSERT_EQ(std::int64_t{field.codes()[t]}, sum[t]) << t << " round " << round;
            for (PreparedStamp& stamp : prepared) stamp.params.flags ^= STAMP_NEGATIVE;
        } else {
            for (const std::uint32_t code : field.codes()) ASSERT_EQ(code, kMidCode) << "round " << round;
            for (PreparedStamp& stamp : prepared) stamp.params.flags ^= STAMP_NEGATIVE;
        }
    }
    EXPECT_EQ(saturated, 0u);
    // Against real numbers (S6): half a code of the amplitude and half of each product, a stamp.
    const double got_m = HeightCodec::detail().height_m(part.code({11, 12}));
    EXPECT_NEAR(got_m, real_m, 5000 * 0x1p-28);
    EXPECT_GT(std::abs(real_m), 0.1);
}

TEST_P(Exact, TheTotalOfManyStampsNeverWraps) {
    const std::uint32_t top = GetParam() == HeightPrecision::bits16 ? 0xffff0000u : 0xffffffffu;
    auto ground = test::flat_ground(17, settings());
    const StampRequest disc{.shape = test::builtin(BuiltinProfile::Disc),
                            .centre = {8, 8},
                            .radius_m = 3,
                            .amplitude_m = 5,
                            .map = MapChoice::Detail};
    StampRequest dig = disc;
    dig.amplitude_m = -5;
    const Texel centre{24, 24};
    EXPECT_EQ(test::stamp(*ground, disc).saturated, 0u);  // 5 m of 8
    std::uint64_t inside = 0;
    for (int z = 0; z < 49; ++z)
        for (int x = 0; x < 49; ++x) inside += (x - 24) * (x - 24) + (z - 24) * (z - 24) < 81 ? 1 : 0;
    EXPECT_EQ(test::stamp(*ground, disc).saturated, inside);
    EXPECT_EQ(ground->detail().code(centre), top);
    EXPECT_EQ(test::stamp(*ground, disc).saturated, inside);  // counted again, stamp by stamp
    EXPECT_EQ(ground->detail().code(centre), top);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(test::stamp(*ground, dig).saturated, 0u);
    EXPECT_EQ(ground->detail().code(centre), top - 3 * (5u << 28));
    EXPECT_EQ(test::stamp(*ground, dig).saturated, inside);
    EXPECT_EQ(ground->detail().code(centre), 0u);
    EXPECT_EQ(ground->detail().code({0, 0}), kMidCode);
}

TEST_P(Exact, ReachingTheEndOfTheRangeExactlyIsNotSaturation) {
    const MapGeometry map = test::map_of(16, GetParam());
    const ShapeLibrary shapes;
    HeightField field(16, 16);
    StampRecord down = test::record_at(8, 8, 6, kMidCode, test::builtin(BuiltinProfile::Disc));
    down.negative = 1;
    EXPECT_EQ(apply_stamp(prepare(down, map, shapes), field).saturated, 0u);
    EXPECT_EQ(field.code({8, 8}), 0u);
    EXPECT_EQ(apply_stamp(prepare(negated(down), map, shapes), field).saturated, 0u);
    EXPECT_EQ(test::volume(field), 0);
}

TEST_P(Exact, MinAndMaxAreIdempotentAndDoNotDependOnTheKey) {
    for (const StampRule rule : {StampRule::Min, StampRule::Max})
        for (const BuiltinProfile profile : test::kAllProfiles) {
            auto once = test::flat_ground(33, settings()), twice = test::flat_ground(33, settings());
            StampRequest request{.shape = test::builtin(profile),
                                 .centre = {15.7, 16.2},
                                 .radius_m = 4.3,
                                 .amplitude_m = rule == StampRule::Min ? -0.123 : 0.123,
                                 .map = MapChoice::Detail,
                                 .rule = rule,
                                 .rotation_rad = 1,
                                 .key = 1};
            test::stamp(*once, request);
            for (const std::uint32_t key : {2u, 3u, 4u}) request.key = key, test::stamp(*twice, request);
            EXPECT_EQ(once->hash(), twice->hash());
            EXPECT_NE(once->hash(), test::flat_ground(33, settings())->hash());
            // Only in the asked direction, and never by more than the amplitude (to half a quantum of the map).
            const double half = GetParam() == HeightPrecision::bits16 ? 0x1p-13 : 0x1p-29;
            for (const auto& [page, codes] : once->detail().pages())
                for (const std::uint32_t code : *codes) {
                    const double h = HeightCodec::detail().height_m(code);
                    ASSERT_LE(rule == StampRule::Min ? h : -h, 0);
                    ASSERT_LE(std::abs(h), 0.123 + half);
                }
        }
}

TEST_P(Exact, OverlappingPrintsAreNotDeeperThanOne) {
    auto ground = test::flat_ground(33, settings());
    const test::UserShapes user(ground->shapes());
    std::mt19937 random(9);
    for (int i = 0; i < 200; ++i)
        test::stamp(*ground, {.shape = user.image,
                              .centre = {14 + 4e-9 * static_cast<double>(random()), 16},
                              .radius_m = 0.8,
                              .amplitude_m = -0.03,
                              .rule = StampRule::Min,
                              .rotation_rad = static_cast<double>(i)});
    std::uint32_t lowest = kMidCode;
    for (const auto& [page, codes] : ground->detail().pages())
        lowest = std::min(lowest, *std::min_element(codes->begin(), codes->end()));
    const double depth = -HeightCodec::detail().height_m(lowest);
    EXPECT_LE(depth, 0.03 + (GetParam() == HeightPrecision::bits16 ? 0x1p-13 : 0x1p-29));
    EXPECT_GT(depth, 0.02);
}

TEST_P(Exact, SetWithFullWeightReachesTheLevelFromAnywhere) {
    const MapGeometry map = test::map_of(64, GetParam());
    const ShapeLibrary shapes;
    std::mt19937 random(10);
    const std::uint32_t kept = GetParam() == HeightPrecision::bits16 ? 0xffff0000u : 0xffffffffu;
    HeightField field(64, 64);
    for (std::uint32_t& code : field.codes()) code = static_cast<std::uint32_t>(random()) & kept;
    StampRecord record = test::record_at(32, 32, 10, 0x01234567u, test::builtin(BuiltinProfile::Disc), StampRule::Set);
    record.level = 0x76543210u;
    record.negative = 1;
    EXPECT_EQ(apply_stamp(prepare(record, map, shapes), field).saturated, 0u);
    const std::uint32_t level = 0x76543210u - 0x01234567u;
    const std::uint32_t expected = kept == 0xffffffffu ? level : (level + 0x8000u) & kept;
    int reached = 0;
    for (int z = 0; z < 64; ++z)
        for (int x = 0; x < 64; ++x)
            if ((x - 32) * (x - 32) + (z - 32) * (z - 32) < 100) {
                ASSERT_EQ(field.code({x, z}), expected);
                ++reached;
            }
    EXPECT_GT(reached, 300);
    // Partial weight lies between where it was and the level, and never passes it.
    HeightField partly(64, 64, 0x10000000u);
    record.shape = test::builtin(BuiltinProfile::Cone).value;
    apply_stamp(prepare(record, map, shapes), partly);
    for (const std::uint32_t code : partly.codes()) ASSERT_TRUE(code >= 0x10000000u && code <= expected);
    EXPECT_EQ(partly.code({32, 32}), expected);
}

// A target beyond the range saturates and is counted.
TEST_P(Exact, LevelsBeyondTheRangeSaturate) {
    const MapGeometry map = test::map_of(16, GetParam());
    const ShapeLibrary shapes;
    for (const StampRule rule : {StampRule::Max, StampRule::Set}) {
        HeightField field(16, 16);
        StampRecord record = test::record_at(8, 8, 6, 0x80000000u, test::builtin(BuiltinProfile::Disc), rule);
        record.level = 0xc0000000u;
        const ApplyResult result = apply_stamp(prepare(record, map, shapes), field);
        EXPECT_EQ(result.saturated,
                  static_cast<std::uint64_t>(std::count_if(field.codes().begin(), field.codes().end(),
                                                           [](std::uint32_t c) { return c != kMidCode; })));
        EXPECT_EQ(field.code({8, 8}), GetParam() == HeightPrecision::bits16 ? 0xffff0000u : 0xffffffffu);
    }
}

// A prepared stamp stays good when shapes are added before it is applied.
TEST(ExactStamps, AddingShapesDoesNotMoveThoseInUse) {
    const MapGeometry map = test::map_of(32);
    ShapeLibrary shapes;
    HeightField before(32, 32), after(32, 32);
    const PreparedStamp prepared =
        prepare(test::record_at(16, 16, 8, 1u << 20, test::builtin(BuiltinProfile::Cosine)), map, shapes);
    apply_stamp(prepared, before);
    const Shape* shape = &shapes.shape(test::builtin(BuiltinProfile::Cosine));
    for (int i = 0; i < 100; ++i)
        ASSERT_TRUE(shapes.add_profile("profile " + std::to_string(i), [](double t) { return 1 - t; }).ok());
    ASSERT_EQ(&shapes.shape(test::builtin(BuiltinProfile::Cosine)), shape);
    apply_stamp(prepared, after);
    EXPECT_TRUE(std::ranges::equal(before.codes(), after.codes()));
}

}  // namespace
}  // namespace tilth
