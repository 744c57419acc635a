// Codes go into the planes and come back, every bit of every code, and nothing beside the rectangle.
#include "tilth/pool/height_planes.h"

#include <gtest/gtest.h>

#include "support/gl_context.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/pool/slope_map.h"

namespace tilth {
namespace {

class HeightPlanesTest : public test::GlTest, public ::testing::WithParamInterface<HeightPrecision> {
protected:
    [[nodiscard]] static std::uint32_t kept(std::uint32_t code) {
        return GetParam() == HeightPrecision::bits32 ? code : code & 0xffff0000u;
    }
};

TEST_P(HeightPlanesTest, EveryBitOfACodeSurvives) {
    const gl::StateGuard guard(device());
    // All 65 536 values of a half in one map, in both halves of the code.
    HeightField field(256, 256), back(256, 256, 0);
    for (std::uint32_t i = 0; i < 65536; ++i) field.codes()[i] = kept(i << 16 | ((i * 40503u) & 0xffffu));
    HeightPlanes planes = test::value(HeightPlanes::create(device(), 256, 256, GetParam()));
    gl::TransferStats transfer;
    planes.upload(field, field.rect(), transfer);
    planes.read_back(field.rect(), back, transfer);
    const std::size_t texel_bytes = GetParam() == HeightPrecision::bits32 ? 4 : 2;
    EXPECT_EQ(transfer.bytes_up, 65536u * texel_bytes);
    EXPECT_EQ(transfer.bytes_down, 65536u * texel_bytes);
    for (std::size_t i = 0; i < 65536; ++i) ASSERT_EQ(back.codes()[i], field.codes()[i]) << i;
}

TEST_P(HeightPlanesTest, TransfersTouchTheirRectangleAlone) {
    const gl::StateGuard guard(device());
    SplitMix64 random{17};
    HeightField shown(97, 61, kept(0x5a5a5a5au));  // what the planes should hold
    HeightPlanes planes = test::value(HeightPlanes::create(device(), 97, 61, GetParam()));
    gl::TransferStats transfer;
    planes.upload(shown, shown.rect(), transfer);
    for (int round = 0; round < 40; ++round) {
        const auto below = [&](std::int32_t n) {
            return static_cast<std::int32_t>(random.next() % static_cast<std::uint64_t>(n));
        };
        const Texel min{below(97), below(61)};
        const TexelRect rect{min, {min.x + 1 + below(97 - min.x), min.z + 1 + below(61 - min.z)}};
        HeightField other(97, 61);
        for (std::uint32_t& code : other.codes()) code = kept(static_cast<std::uint32_t>(random.next()));
        planes.upload(other, rect, transfer);
        for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
            for (std::int32_t x = rect.min.x; x < rect.max.x; ++x) shown.set_code({x, z}, other.code({x, z}));

        HeightField back(97, 61, 0x12345678u);
        const TexelRect part = intersection(expanded(rect, 3), shown.rect());
        planes.read_back(part, back, transfer);
        for (std::int32_t z = 0; z < 61; ++z)
            for (std::int32_t x = 0; x < 97; ++x)
                ASSERT_EQ(back.code({x, z}), part.contains({x, z}) ? shown.code({x, z}) : 0x12345678u)
                    << x << ", " << z;
    }
}

TEST_P(HeightPlanesTest, MapsBeyondTheTextureLimitAreRefused) {
    const gl::StateGuard guard(device());
    const std::int32_t limit = device().capabilities().max_texture_size;
    EXPECT_FALSE(HeightPlanes::create(device(), limit + 1, 4, GetParam()));
    EXPECT_FALSE(SlopeMap::create(device(), 4, limit + 1, SlopeFormat::rg8));
}

TEST_P(HeightPlanesTest, MemoryIsWhatTheTypesSay) {
    const gl::StateGuard guard(device());
    const HeightPlanes planes = test::value(HeightPlanes::create(device(), 100, 50, GetParam()));
    EXPECT_EQ(planes.bytes(), 100u * 50u * (GetParam() == HeightPrecision::bits32 ? 4u : 2u));
    const SlopeMap slopes = test::value(SlopeMap::create(device(), 100, 50, SlopeFormat::rg8));
    EXPECT_EQ(slopes.padded_width() % (1 << (SlopeMap::kLevels - 1)), 0);
    EXPECT_GE(slopes.padded_width(), 100);
    EXPECT_EQ(slopes.texture().levels(), SlopeMap::kLevels);
}

INSTANTIATE_TEST_SUITE_P(Precisions, HeightPlanesTest,
                         ::testing::Values(HeightPrecision::bits32, HeightPrecision::bits16));

}  // namespace
}  // namespace tilth
