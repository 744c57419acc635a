// The rule that reads its neighbours, against the mean written down again; borders repeat.
#include <gtest/gtest.h>

#include <random>

#include "ground/support.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

TEST(Smooth, WithFullWeightIsTheMeanOfTheEightNeighboursBefore) {
    constexpr int kSide = 40;
    std::mt19937 random(21);
    const ShapeLibrary shapes;
    for (const HeightPrecision precision : test::kBothPrecisions) {
        const bool bits16 = precision == HeightPrecision::bits16;
        HeightField field(kSide, kSide);
        for (std::uint32_t& code : field.codes())
            code = static_cast<std::uint32_t>(random()) & (bits16 ? 0xffff0000u : 0xffffffffu);
        const HeightField before = field;
        const StampRecord record =
            test::record_at(20, 20, 100, 65536, test::builtin(BuiltinProfile::Disc), StampRule::Smooth);
        EXPECT_EQ(apply_stamp(prepare(record, test::map_of(kSide, precision), shapes), field).saturated, 0u);
        for (int z = 0; z < kSide; ++z)
            for (int x = 0; x < kSide; ++x) {
                std::uint64_t sum = 0;
                for (int k = 0; k < 9; ++k) {
                    if (k == 4) continue;
                    const int nx = std::min(std::max(x + k % 3 - 1, 0), kSide - 1),
                              nz = std::min(std::max(z + k / 3 - 1, 0), kSide - 1);
                    sum += before.code({nx, nz});
                }
                const auto expected = bits16 ? (sum / 65536 + 4) / 8 * 65536 : (sum + 4) / 8;
                ASSERT_EQ(field.code({x, z}), expected) << x << ", " << z;
            }
    }
}

TEST(Smooth, LeavesFlatGroundAndPlanesAlone) {
    const ShapeLibrary shapes;
    HeightField field(64, 64);
    for (int z = 0; z < 64; ++z)
        for (int x = 0; x < 64; ++x) field.set_code({x, z}, static_cast<std::uint32_t>(1000000 * x + 3000000 * z));
    const HeightField before = field;
    apply_stamp(prepare(test::record_at(32, 32, 25, 65536, test::builtin(BuiltinProfile::Gaussian), StampRule::Smooth),
                        test::map_of(64), shapes),
                field);
    EXPECT_TRUE(std::ranges::equal(field.codes(), before.codes()));
    DetailField sparse;  // at a map's corner, over untouched pages
    apply_stamp(prepare(test::record_at(0, 0, 25, 65536, test::builtin(BuiltinProfile::Gaussian), StampRule::Smooth),
                        test::map_of(64), shapes),
                sparse, {{0, 0}, {64, 64}});
    for (const auto& [page, codes] : sparse.pages())
        for (const std::uint32_t code : *codes) ASSERT_EQ(code, kMidCode);
}

TEST(Smooth, CalmsASpikeByItsAmplitude) {
    const ShapeLibrary shapes;
    for (const std::uint32_t amplitude : {0u, 16384u, 65536u}) {
        HeightField field(9, 9);
        field.set_code({4, 4}, kMidCode + 80000);
        apply_stamp(prepare(test::record_at(4, 4, 6, amplitude, test::builtin(BuiltinProfile::Disc), StampRule::Smooth),
                            test::map_of(9), shapes),
                    field);
        const double part = amplitude / 65536.0;
        EXPECT_EQ(field.code({4, 4}), kMidCode + static_cast<std::uint32_t>(80000 * (1 - part)));
        EXPECT_EQ(field.code({5, 4}), kMidCode + static_cast<std::uint32_t>(10000 * part));
        EXPECT_EQ(field.code({7, 4}), kMidCode);
    }
}

}  // namespace
}  // namespace tilth
