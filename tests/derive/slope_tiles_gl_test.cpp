// Slopes of tiles are those of the one map that they are cut from, across borders and at the map's edge.
#include <gtest/gtest.h>

#include "support/gl_context.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/world/tile_grid.h"

namespace tilth {
namespace {

struct Case {
    SlopeFormat format;
    SlopeStencil stencil;
    HeightPrecision precision;
};

class SlopeTilesTest : public test::GlTest, public ::testing::WithParamInterface<Case> {
protected:
    static constexpr std::int32_t kWidth = 150, kDepth = 139;

    static HeightField bumpy() {
        HeightField field(kWidth, kDepth);
        SplitMix64 random{21};
        for (std::uint32_t& code : field.codes()) {
            code = kMidCode + static_cast<std::uint32_t>(random.next() % 0x0400'0000u);
            if (GetParam().precision == HeightPrecision::bits16) code &= 0xffff'0000u;
        }
        return field;
    }
    static SlopeSettings settings() { return {GetParam().stencil, 1.0 / (1 << 28), 1.0 / 30}; }
    static std::vector<std::uint8_t> stored(const SlopeMap& map) {
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(map.texture().width()) *
                                        static_cast<std::size_t>(map.texture().height()) * slope_bytes(map.format()));
        map.texture().read(0, bytes.data());
        return bytes;
    }
};

TEST_P(SlopeTilesTest, EqualThoseOfTheWholeMapOnTheInteriorAndATexelAround) {
    const gl::StateGuard guard(device());
    const HeightField field = bumpy();
    const std::int32_t apron = stencil_reach(GetParam().stencil) + 1;
    const TileGrid grid{.size = 64, .apron = apron, .map = field.rect()};
    gl::ShaderLibrary library = shaders();
    SlopePass pass =
        test::value(SlopePass::create(device(), library, GetParam().precision, GetParam().format, settings()));
    gl::TransferStats transfer;
    gl::StageStats derive, mips;

    HeightPlanes whole = test::value(HeightPlanes::create(device(), kWidth, kDepth, GetParam().precision));
    whole.upload(field, field.rect(), transfer);
    SlopeMap whole_slopes = test::value(SlopeMap::create(device(), kWidth, kDepth, GetParam().format));
    const TexelRect all = field.rect();
    pass.run({&all, 1}, whole, whole_slopes, derive, mips);
    const std::vector<std::uint8_t> truth = stored(whole_slopes);
    const std::size_t texel = slope_bytes(GetParam().format);

    std::vector<HeightPlanes> planes;
    std::vector<SlopeMap> by_gpu, alone, by_cpu;
    std::vector<TileIndex> tiles;
    for (std::int32_t z = 0; z < 3; ++z)
        for (std::int32_t x = 0; x < 3; ++x) {
            const TexelRect rect = grid.stored({x, z});
            tiles.push_back({x, z});
            planes.push_back(test::value(HeightPlanes::create(
                device(), {.label = "tile", .rect = rect, .map = all, .precision = GetParam().precision})));
            planes.back().upload(field, planes.back().held(), transfer);
            for (std::vector<SlopeMap>* maps : {&by_gpu, &alone, &by_cpu})
                maps->push_back(test::value(SlopeMap::create(
                    device(), {.label = "tile", .rect = rect, .format = GetParam().format, .levels = 1})));
        }
    std::vector<SlopeTarget> targets;
    for (std::size_t i = 0; i < tiles.size(); ++i) targets.push_back({&planes[i], &by_gpu[i], {&all, 1}});
    gl::StageStats together;
    pass.run(targets, together);
    EXPECT_EQ(together.draws, 9u);
    EXPECT_LE(together.passes, 3u) << "nine tiles of 68 texels share a scratch of 256";
    EXPECT_EQ(together.fallbacks, 0u);

    std::int64_t compared = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        pass.run({&all, 1}, planes[i], alone[i], derive, mips);
        upload_slopes({&all, 1}, field, all, settings(), by_cpu[i], derive, mips, transfer);
        const std::vector<std::uint8_t> gpu = stored(by_gpu[i]), one = stored(alone[i]), cpu = stored(by_cpu[i]);
        const TexelRect rect = grid.stored(tiles[i]);
        const TexelRect right = intersection(expanded(grid.interior(tiles[i]), 1), all);
        for (std::int32_t z = right.min.z; z < right.max.z; ++z)
            for (std::int32_t x = right.min.x; x < right.max.x; ++x, ++compared) {
                const std::size_t at =
                    (static_cast<std::size_t>(z - rect.min.z) * static_cast<std::size_t>(rect.width()) +
                     static_cast<std::size_t>(x - rect.min.x)) *
                    texel;
                const std::size_t in_whole =
                    (static_cast<std::size_t>(z) * static_cast<std::size_t>(whole_slopes.padded_width()) +
                     static_cast<std::size_t>(x)) *
                    texel;
                for (std::size_t b = 0; b < texel; ++b) {
                    ASSERT_EQ(gpu[at + b], truth[in_whole + b]) << x << ", " << z;
                    ASSERT_EQ(one[at + b], truth[in_whole + b]) << x << ", " << z;
                }
                for (std::size_t c = 0; c < 2; ++c) {  // a storage step: neighbours in bytes, in halves by value
                    if (texel == 2) {
                        ASSERT_LE(std::abs(cpu[at + c] - truth[in_whole + c]), 1) << x << ", " << z;
                    } else {
                        const auto half = [](const std::uint8_t* p) { return p[0] | p[1] << 8; };
                        ASSERT_LE(std::abs(half(&cpu[at + 2 * c]) - half(&truth[in_whole + 2 * c])), 1)
                            << x << ", " << z;
                    }
                }
            }
    }
    EXPECT_GT(compared, kWidth * kDepth);
}

TEST_P(SlopeTilesTest, OnlyWhatTheChangeMadeStaleIsWritten) {
    const gl::StateGuard guard(device());
    const HeightField field = bumpy();
    const TileGrid grid{.size = 64, .apron = 3, .map = field.rect()};
    gl::ShaderLibrary library = shaders();
    SlopePass pass =
        test::value(SlopePass::create(device(), library, GetParam().precision, GetParam().format, settings()));
    gl::TransferStats transfer;
    std::vector<HeightPlanes> planes;
    std::vector<SlopeMap> slopes;
    for (std::int32_t x = 0; x < 2; ++x) {
        const TexelRect rect = grid.stored({x, 0});
        planes.push_back(test::value(HeightPlanes::create(
            device(), {.label = "tile", .rect = rect, .map = grid.map, .precision = GetParam().precision})));
        planes.back().upload(field, planes.back().held(), transfer);
        slopes.push_back(test::value(
            SlopeMap::create(device(), {.label = "tile", .rect = rect, .format = GetParam().format, .levels = 1})));
    }
    const std::vector<std::uint8_t> flat = stored(slopes.front());
    const TexelRect changed{{60, 20}, {67, 22}};
    const SlopeTarget targets[] = {{&planes[0], &slopes[0], {&changed, 1}}, {&planes[1], &slopes[1], {&changed, 1}}};
    gl::StageStats derive;
    pass.run(targets, derive);
    EXPECT_EQ(derive.passes, 1u);
    std::uint64_t expected = 0;
    for (std::size_t i = 0; i < 2; ++i) {
        const TexelRect rect = planes[i].rect();
        const TexelRect stale = stale_slopes(changed, planes[i].held(), grid.map, GetParam().stencil);
        expected += static_cast<std::uint64_t>(stale.count());
        const std::vector<std::uint8_t> now = stored(slopes[i]);
        const std::size_t texel = slope_bytes(GetParam().format);
        for (std::size_t at = 0; at < now.size(); ++at) {
            const auto index = static_cast<std::int32_t>(at / texel);
            const Texel t{rect.min.x + index % rect.width(), rect.min.z + index / rect.width()};
            if (!stale.contains(t)) {
                ASSERT_EQ(now[at], flat[at]) << t.x << ", " << t.z;
            }
        }
        EXPECT_NE(now, flat);
    }
    EXPECT_EQ(derive.texels, expected);
}

INSTANTIATE_TEST_SUITE_P(Ways, SlopeTilesTest,
                         ::testing::Values(Case{SlopeFormat::rg8, SlopeStencil::Central, HeightPrecision::bits32},
                                           Case{SlopeFormat::rg8, SlopeStencil::Fourth, HeightPrecision::bits16},
                                           Case{SlopeFormat::rg16f, SlopeStencil::Fourth, HeightPrecision::bits32},
                                           Case{SlopeFormat::rg16f, SlopeStencil::Central, HeightPrecision::bits16}));

}  // namespace
}  // namespace tilth
