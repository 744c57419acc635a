// The dither of bits16: unbiased, different for each key and texel, the same on replay.
#include <gtest/gtest.h>

#include <cmath>

#include "ground/support.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

/// One stamp on a 256 x 256 map of constant weight: how many quanta each texel took.
std::vector<int> quanta(std::uint32_t amplitude, std::uint32_t key, bool negative = false) {
    const MapGeometry map = test::map_of(256, HeightPrecision::bits16);
    ShapeLibrary shapes;
    const ShapeId white = *shapes.add_image("white", 1, 1, std::vector<std::uint16_t>{65535});
    HeightField field(256, 256);
    StampRecord record = test::record_at(128, 128, 200, amplitude, white);
    record.key = key;
    record.negative = negative ? 1 : 0;
    apply_stamp(prepare(record, map, shapes), field);
    std::vector<int> result;
    for (const std::uint32_t code : field.codes()) result.push_back(static_cast<int>(code >> 16) - 32768);
    return result;
}

// Each texel takes floor(a) or one more, with probability f: mean f, standard deviation sqrt(f (1 - f) / n); five of
// them.
TEST(Dither, IsUnbiasedOverTexelsAndOverKeys) {
    for (const double fraction : {0.01, 0.3, 0.5, 0.51, 0.99}) {
        const auto amplitude = static_cast<std::uint32_t>((3 + fraction) * 65536);
        const double f = amplitude / 65536.0 - 3;
        for (const std::uint32_t key : {0u, 1u, 0xdeadbeefu}) {
            double sum = 0;
            for (const int q : quanta(amplitude, key)) {
                ASSERT_TRUE(q == 3 || q == 4);
                sum += q - 3;
            }
            EXPECT_NEAR(sum / 65536, f, 5 * std::sqrt(f * (1 - f) / 65536)) << "key " << key;
        }
        // The same few texels under keys that count up, as `repeat` draws them.
        double sums[3] = {};
        constexpr int kKeys = 400;
        for (std::uint32_t key = 1000; key < 1000 + kKeys; ++key) {
            const std::vector<int> all = quanta(amplitude, key);
            sums[0] += all[0] - 3, sums[1] += all[257] - 3, sums[2] += all[65535] - 3;
        }
        for (const double sum : sums) EXPECT_NEAR(sum / kKeys, f, 5 * std::sqrt(f * (1 - f) / kKeys));
    }
}

// Two independent draws agree at a texel with probability f^2 + (1 - f)^2 = 1/2 at f = 1/2.
TEST(Dither, DiffersBetweenKeysAndBetweenNeighbours) {
    const std::vector<int> a = quanta(32768, 1);
    const double tolerance = 5 * 0.5 / 256;
    for (const std::uint32_t key : {0u, 2u, 3u, 0x80000001u}) {
        const std::vector<int> b = quanta(32768, key);
        int equal = 0;
        for (std::size_t i = 0; i < a.size(); ++i) equal += a[i] == b[i] ? 1 : 0;
        EXPECT_NEAR(equal / 65536.0, 0.5, tolerance) << key;
    }
    for (const std::size_t step : {1u, 2u, 255u, 256u, 257u, 64u * 256u}) {
        int equal = 0, count = 0;
        for (std::size_t i = 0; i + step < a.size(); ++i, ++count) equal += a[i] == a[i + step] ? 1 : 0;
        EXPECT_NEAR(static_cast<double>(equal) / count, 0.5, 5 * 0.5 / std::sqrt(count)) << step;
    }
    EXPECT_EQ(quanta(32768, 1), a);
    std::vector<int> down = quanta(32768, 1, true);
    for (int& q : down) q = -q;
    EXPECT_EQ(down, a);  // the magnitude is rounded, the sign applied after
}

TEST(Dither, WholeQuantaAreNotTouched) {
    for (const std::uint32_t key : {5u, 6u})
        for (const int q : quanta(7 * 65536, key)) ASSERT_EQ(q, 7);
}

TEST(Dither, KeysAreDrawnFromTheSequenceUnlessGiven) {
    auto ground = test::flat_ground(9);
    const StampRequest request{.shape = {0}, .centre = {4, 4}, .amplitude_m = 0.1};
    const StampRecord first = test::issued(*ground, request), second = test::issued(*ground, request);
    EXPECT_NE(first.key, second.key);
    EXPECT_EQ(first.sequence, 1u);
    EXPECT_EQ(second.sequence, 2u);
    auto other = test::flat_ground(9);
    EXPECT_EQ(test::issued(*other, request), first);
    StampRequest keyed = request;
    keyed.key = 77;
    EXPECT_EQ(test::issued(*other, keyed).key, 77u);
    EXPECT_EQ(negated(first).key, first.key);
}

}  // namespace
}  // namespace tilth
