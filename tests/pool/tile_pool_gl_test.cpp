// Textures of tiles: none before the first, exactly clear, used again only after the GPU is done, bounded.
#include "tilth/pool/tile_pool.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/gl_context.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

struct Case {
    context::Route route;
    HeightPrecision precision;
    SlopeFormat slopes;
};

class TilePoolTest : public test::GlRouteTest<Case> {
protected:
    static TilePool pool(std::int32_t most_tiles = 0) {
        return {device(),
                {.grid = {.size = 128, .apron = 3, .map = {{0, 0}, {500, 300}}},
                 .precision = GetParam().precision,
                 .slopes = GetParam().slopes,
                 .most_tiles = most_tiles}};
    }
    /// Writes nonsense into every texel.
    static void soil(TileSet& set) {
        SplitMix64 random{8};
        HeightField field(134, 134);
        for (std::uint32_t& code : field.codes()) code = static_cast<std::uint32_t>(random.next());
        gl::TransferStats transfer;
        const TexelRect rect = set.planes.rect();
        set.planes.upload({field.codes().data(), 134, rect}, rect, transfer);
        set.slopes.texture().upload(0, set.slopes.texture().bounds(), field.codes().data());
    }
    static void expect_clear(const TileSet& set) {
        std::vector<std::uint32_t> codes(134 * 134);
        gl::TransferStats transfer;
        set.planes.read_back(set.planes.rect(), codes.data(), 134, transfer);
        EXPECT_TRUE(std::all_of(codes.begin(), codes.end(), [](std::uint32_t code) { return code == kMidCode; }));
        std::vector<std::uint8_t> slopes(134 * 134 * slope_bytes());
        set.slopes.texture().read(0, slopes.data());
        const std::uint8_t flat = GetParam().slopes == SlopeFormat::rg8 ? 128 : 0;
        EXPECT_TRUE(std::all_of(slopes.begin(), slopes.end(), [&](std::uint8_t byte) { return byte == flat; }));
    }
    static std::size_t slope_bytes() { return GetParam().slopes == SlopeFormat::rg8 ? 2 : 4; }
};

TEST_P(TilePoolTest, NothingExistsBeforeTheFirstTile) {
    const gl::StateGuard guard(device());
    const std::uint64_t before = device().resident_bytes();
    TilePool tiles = pool();
    EXPECT_EQ(device().resident_bytes(), before);
    EXPECT_EQ(tiles.bytes(), 0u);
    EXPECT_EQ(tiles.find({0, 0}), nullptr);
    ASSERT_NE(test::value(tiles.acquire({1, 0})), nullptr);
    const std::uint64_t expected =
        134u * 134u * ((GetParam().precision == HeightPrecision::bits32 ? 4 : 2) + slope_bytes());
    EXPECT_EQ(tiles.bytes(), expected);
    EXPECT_EQ(tiles.bytes_per_tile(), expected);
    EXPECT_EQ(device().resident_bytes() - before, expected);
}

TEST_P(TilePoolTest, ATileIsClearAtFirstAndWhenItsTexturesServedAnother) {
    const gl::StateGuard guard(device());
    TilePool tiles = pool();
    // What a host left behind must not change a cleared value.
    device().gl().Enable(GL_SCISSOR_TEST);
    device().gl().Scissor(3, 3, 5, 5);
    device().gl().ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    TileSet& first = *test::value(tiles.acquire({1, 1}));
    EXPECT_EQ(first.planes.rect(), (TexelRect{{125, 125}, {259, 259}}));
    EXPECT_EQ(first.slopes.rect(), first.planes.rect());
    expect_clear(first);
    soil(first);
    const std::uint64_t texture = first.planes.high().serial(), bytes = tiles.bytes();
    tiles.release({1, 1});
    EXPECT_EQ(tiles.find({1, 1}), nullptr);
    EXPECT_EQ(tiles.bytes(), bytes);
    device().gl().Finish();
    TileSet& again = *test::value(tiles.acquire({3, 0}));
    EXPECT_EQ(again.planes.high().serial(), texture);
    EXPECT_EQ(again.planes.rect(), (TexelRect{{381, -3}, {515, 131}}));
    EXPECT_EQ(again.planes.held(), (TexelRect{{381, 0}, {500, 131}}));
    EXPECT_EQ(again.slopes.rect(), again.planes.rect());
    EXPECT_EQ(tiles.bytes(), bytes);
    expect_clear(again);
}

TEST_P(TilePoolTest, ATileThatWasGivenUpIsNotUsedBeforeItsFence) {
    const gl::StateGuard guard(device());
    TilePool tiles = pool(2);
    const std::uint64_t first = test::value(tiles.acquire({0, 0}))->planes.high().serial();
    // A fence that does not pass: the entry points say so.
    gl::Api& gl = const_cast<gl::Api&>(device().gl());
    const auto wait = gl.ClientWaitSync;
    gl.ClientWaitSync = [](GLsync, GLbitfield, GLuint64) -> GLenum { return GL_TIMEOUT_EXPIRED; };
    tiles.release({0, 0});
    const TileSet* const too_early = test::value(tiles.acquire({1, 0}));
    gl.ClientWaitSync = wait;
    ASSERT_EQ(too_early, nullptr) << "the GPU still reads the only set";
    EXPECT_EQ(tiles.bytes(), tiles.bytes_per_tile()) << "and no other was made";
    device().gl().Finish();
    const TileSet* const second = test::value(tiles.acquire({1, 0}));
    ASSERT_NE(second, nullptr);
    EXPECT_EQ(second->planes.high().serial(), first);
    EXPECT_NE(test::value(tiles.acquire({2, 0})), nullptr);
    EXPECT_EQ(test::value(tiles.acquire({3, 0})), nullptr) << "two sets are the bound";
    EXPECT_EQ(tiles.resident(), 2u);
}

TEST_P(TilePoolTest, SetsThatNobodyWantsAreFreedInTime) {
    const gl::StateGuard guard(device());
    TilePool tiles = pool();
    for (std::int32_t x = 0; x < 3; ++x) ASSERT_NE(test::value(tiles.acquire({x, 0})), nullptr);
    tiles.release({0, 0});
    tiles.release({2, 0});
    device().gl().Finish();
    for (int frame = 0; frame < TilePool::kIdleFrames; ++frame) tiles.trim();
    EXPECT_EQ(tiles.bytes(), 3 * tiles.bytes_per_tile());
    tiles.trim();
    EXPECT_EQ(tiles.bytes(), tiles.bytes_per_tile());
    EXPECT_NE(tiles.find({1, 0}), nullptr);
}

TEST_P(TilePoolTest, NoMemoryIsAnErrorAndTheNextTryWorks) {
    const gl::StateGuard guard(device());
    TilePool tiles = pool();
    ASSERT_NE(test::value(tiles.acquire({0, 0})), nullptr);
    const std::uint64_t before = device().resident_bytes();
    gl::Api& gl = const_cast<gl::Api&>(device().gl());
    static int calls = 0;
    for (int failing = 1; failing <= 3; ++failing) {  // each of the textures in turn
        if (failing == 3 && GetParam().precision == HeightPrecision::bits16) break;
        static PFNGLGETERRORPROC real = nullptr;
        static PFNGLTEXIMAGE2DPROC image = nullptr;
        static int fail_at = 0;
        real = gl.GetError, image = gl.TexImage2D;
        calls = 0, fail_at = failing;
        gl.TexImage2D = [](GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLint border,
                           GLenum format, GLenum type, const void* data) {
            ++calls;
            image(target, level, internal, width, height, border, format, type, data);
        };
        gl.GetError = []() -> GLenum {
            if (calls != fail_at) return real();
            calls = 1000;
            return GL_OUT_OF_MEMORY;
        };
        const Result<TileSet*> refused = tiles.acquire({1, 0});
        gl.GetError = real, gl.TexImage2D = image;
        ASSERT_FALSE(refused) << failing;
        EXPECT_EQ(refused.error().code, ErrorCode::OutOfMemory);
        EXPECT_EQ(tiles.find({1, 0}), nullptr);
        EXPECT_EQ(device().resident_bytes(), before);
    }
    EXPECT_NE(test::value(tiles.acquire({1, 0})), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Contexts, TilePoolTest,
                         ::testing::Values(Case{context::Route::Egl, HeightPrecision::bits32, SlopeFormat::rg8},
                                           Case{context::Route::Egl, HeightPrecision::bits16, SlopeFormat::rg16f},
                                           Case{context::Route::Osmesa, HeightPrecision::bits32, SlopeFormat::rg16f},
                                           Case{context::Route::Osmesa, HeightPrecision::bits16, SlopeFormat::rg8}),
                         [](const auto& param_info) {
                             return std::string(param_info.param.route == context::Route::Egl ? "Egl" : "Osmesa") +
                                    (param_info.param.precision == HeightPrecision::bits32 ? "Bits32" : "Bits16");
                         });

}  // namespace
}  // namespace tilth
