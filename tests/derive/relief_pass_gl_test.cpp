// The relief window shows the tiles' detail, its pyramid bounds it exactly, and both after any changes and moves: every
// texel of every texture against codes that are followed on the CPU, texel by texel.
#include "tilth/derive/relief_pass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "support/gl_context.h"
#include "tilth/gl/api.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/world/tile_grid.h"

namespace tilth {
namespace {

struct Case {
    SlopeFormat format;
    HeightPrecision precision;
};

constexpr std::int32_t kSize = 256;
constexpr double kQuantum = 1.0 / (1 << 28);

std::size_t wrapped(std::int32_t texel, std::int32_t size) {
    while (texel < 0) texel += size;
    while (texel >= size) texel -= size;
    return static_cast<std::size_t>(texel);
}

/// What a window of kSize texels should hold.
struct Expected {
    std::vector<std::uint32_t> codes = std::vector<std::uint32_t>(kSize * kSize, kMidCode);
    std::vector<std::uint32_t> slopes;  ///< as stored
    explicit Expected(std::uint32_t flat) : slopes(kSize * kSize, flat) {}
    static std::size_t at(Texel map) { return wrapped(map.z, kSize) * kSize + wrapped(map.x, kSize); }
};

class ReliefPassTest : public test::GlTest, public ::testing::WithParamInterface<Case> {
protected:
    /// One tile's textures and what the test put into them.
    struct Tile {
        HeightPlanes planes;
        SlopeMap slopes;
        TexelRect interior;
        std::vector<std::uint32_t> codes, stored;  ///< of planes.rect()
        [[nodiscard]] std::size_t at(Texel map) const {
            return static_cast<std::size_t>(map.z - planes.origin().z) *
                       static_cast<std::size_t>(planes.rect().width()) +
                   static_cast<std::size_t>(map.x - planes.origin().x);
        }
    };

    void SetUp() override {
        GlTest::SetUp();
        if (IsSkipped() || HasFatalFailure()) return;
        library_.emplace(shaders());
        pass_.emplace(
            test::value(ReliefPass::create(device(), *library_, GetParam().precision, GetParam().format, kQuantum)));
        window_.emplace(test::value(ReliefWindow::create(device(), kSize, GetParam().format)));
    }
    void TearDown() override {
        tiles_.clear();
        window_.reset();
        pass_.reset();
        GlTest::TearDown();
    }

    static std::uint32_t flat() { return GetParam().format == SlopeFormat::rg8 ? 0x8080u : 0u; }
    std::int32_t between(std::int32_t low, std::int32_t high) {  // both included
        return low + static_cast<std::int32_t>(random_.next() % static_cast<std::uint64_t>(high - low + 1));
    }
    TexelRect rect(Texel low, Texel high, std::int32_t most) {
        const Texel min{between(low.x, high.x), between(low.z, high.z)};
        return {min, {min.x + between(1, most), min.z + between(1, most)}};
    }

    std::uint32_t random_code() {
        const auto bits = static_cast<std::uint32_t>(random_.next());
        std::uint32_t code = bits;  // from one end of the range to the other
        switch (random_.next() % 8) {
            case 0:
                code = 0;
                break;
            case 1:
                code = 0xffff'ffffu;
                break;
            case 2:
                code = kMidCode;
                break;
            case 3:
            case 4:  // soft ground: a centimetre or two
                code = kMidCode + (bits & 0x00ff'ffffu) - 0x0080'0000u;
                break;
            default:
                break;
        }
        return GetParam().precision == HeightPrecision::bits32 ? code : code & 0xffff'0000u;
    }
    /// RG8: any two bytes. RG16F: any two halves but infinities, NaN and those below the normal ones.
    std::uint32_t random_slope() {
        const auto bits = static_cast<std::uint32_t>(random_.next());
        if (GetParam().format == SlopeFormat::rg8) return bits & 0xffffu;
        const auto half = [](std::uint32_t b) { return (b & 0x83ffu) | (1 + (b >> 16) % 30) << 10; };
        return half(bits) | half(bits * 2654435761u) << 16;
    }

    void add_tile(const TileGrid& grid, TileIndex index) {
        const TexelRect stored = grid.stored(index);
        tiles_.push_back(
            {test::value(HeightPlanes::create(
                 device(), {.label = "tile", .rect = stored, .map = grid.map, .precision = GetParam().precision})),
             test::value(SlopeMap::create(device(),
                                          {.label = "tile", .rect = stored, .format = GetParam().format, .levels = 1})),
             grid.inside(index), std::vector<std::uint32_t>(static_cast<std::size_t>(stored.count())),
             std::vector<std::uint32_t>(static_cast<std::size_t>(stored.count()))});
        randomise(tiles_.back());
    }
    /// All codes and slopes of the tile change. Aprons too, unlike the neighbours': only interiors may be read.
    void randomise(Tile& tile) {
        for (std::uint32_t& code : tile.codes) code = random_code();
        for (std::uint32_t& slope : tile.stored) slope = random_slope();
        gl::TransferStats transfer;
        const TexelRect rect = tile.planes.rect();
        tile.planes.upload({tile.codes.data(), static_cast<std::size_t>(rect.width()), rect}, rect, transfer);
        std::vector<std::uint8_t> bytes;
        const std::size_t each = slope_bytes();
        for (const std::uint32_t slope : tile.stored)
            for (std::size_t b = 0; b < each; ++b) bytes.push_back(static_cast<std::uint8_t>(slope >> 8 * b));
        tile.slopes.texture().upload(0, tile.slopes.texture().bounds(), bytes.data());
    }
    static std::size_t slope_bytes() { return GetParam().format == SlopeFormat::rg8 ? 2 : 4; }

    [[nodiscard]] std::vector<ReliefSource> sources(std::uint32_t shown = ~0u) const {
        std::vector<ReliefSource> from;
        for (std::size_t i = 0; i < tiles_.size(); ++i)
            if ((shown >> i & 1) != 0) from.push_back({&tiles_[i].planes, &tiles_[i].slopes, tiles_[i].interior});
        return from;
    }

    /// Does to `expected` what a run does to the window. Returns which texels of the window that are.
    std::vector<bool> follow(std::span<const TexelRect> changed, const TexelRect& square, std::uint32_t shown,
                             Expected& expected) const {
        std::vector<bool> dirty(kSize * kSize);
        for (std::int32_t z = square.min.z; z < square.max.z; ++z)
            for (std::int32_t x = square.min.x; x < square.max.x; ++x) {
                const Texel texel{x, z};
                if (std::none_of(changed.begin(), changed.end(),
                                 [&](const TexelRect& rect) { return rect.contains(texel); }))
                    continue;
                const std::size_t at = Expected::at(texel);
                dirty[at] = true;
                expected.codes[at] = kMidCode;
                expected.slopes[at] = flat();
                for (std::size_t i = 0; i < tiles_.size(); ++i) {
                    const Tile& tile = tiles_[i];
                    if ((shown >> i & 1) == 0 || !tile.interior.contains(texel)) continue;
                    expected.codes[at] = tile.codes[tile.at(texel)];
                    expected.slopes[at] = tile.stored[tile.at(texel)];
                }
            }
        return dirty;
    }

    /// Every texel of every texture.
    void compare(const Expected& expected) const {
        std::vector<float> heights(kSize * kSize);
        window_->heights().read(0, heights.data());
        std::vector<std::uint8_t> slopes(kSize * kSize * slope_bytes());
        window_->slopes().read(0, slopes.data());
        for (std::size_t i = 0; i < heights.size(); ++i) {
            const std::int64_t quanta = std::int64_t{expected.codes[i]} - std::int64_t{kMidCode};
            const double exact = static_cast<double>(quanta) * kQuantum;
            // A float holds 24 bits; beyond, GL may round either way.
            const double tolerance = std::abs(quanta) <= 1 << 24 ? 0 : std::abs(exact) * std::ldexp(1.0, -23);
            ASSERT_LE(std::abs(static_cast<double>(heights[i]) - exact), tolerance)
                << "texel " << i % kSize << ", " << i / kSize << " holds " << heights[i];
            ASSERT_FALSE(std::isnan(heights[i]));
            for (std::size_t b = 0; b < slope_bytes(); ++b)
                ASSERT_EQ(slopes[i * slope_bytes() + b], expected.slopes[i] >> 8 * b & 0xffu)
                    << "slope " << i % kSize << ", " << i / kSize << " byte " << b;
        }
        // Ranges by their definition: all texels of a node, far sides included.
        std::vector<float> top;
        for (std::int32_t level = 0; level < ReliefWindow::kLevels; ++level) {
            const std::int32_t side = 2 << level, nodes = kSize / side;
            std::vector<float> range(static_cast<std::size_t>(nodes * nodes) * 2);
            window_->pyramid().read(level, range.data());
            for (std::int32_t z = 0; z < nodes; ++z)
                for (std::int32_t x = 0; x < nodes; ++x) {
                    float high = -1e9f, low = 1e9f;
                    for (std::int32_t j = z * side; j <= (z + 1) * side; ++j)
                        for (std::int32_t i = x * side; i <= (x + 1) * side; ++i) {
                            const float height = heights[Expected::at({i, j})];
                            high = std::max(high, height), low = std::min(low, height);
                        }
                    const auto at = static_cast<std::size_t>(z * nodes + x) * 2;
                    ASSERT_EQ(range[at], high) << "level " << level << " node " << x << ", " << z;
                    ASSERT_EQ(range[at + 1], low) << "level " << level << " node " << x << ", " << z;
                }
            top = std::move(range);
        }
        constexpr std::int32_t kTop = kSize / ReliefWindow::kTopCells;
        ASSERT_EQ(window_->range().width(), kTop);
        std::vector<float> range(kTop * kTop * 2);
        window_->range().read(0, range.data());
        for (std::int32_t z = 0; z < kTop; ++z)
            for (std::int32_t x = 0; x < kTop; ++x) {
                float high = -1e9f, low = 1e9f;
                for (std::int32_t j = z - 1; j <= z + 1; ++j)
                    for (std::int32_t i = x - 1; i <= x + 1; ++i) {
                        const std::size_t at = (wrapped(j, kTop) * kTop + wrapped(i, kTop)) * 2;
                        high = std::max(high, top[at]), low = std::min(low, top[at + 1]);
                    }
                const auto at = static_cast<std::size_t>(z * kTop + x) * 2;
                ASSERT_EQ(range[at], high) << "range " << x << ", " << z;
                ASSERT_EQ(range[at + 1], low) << "range " << x << ", " << z;
            }
    }

    /// Texels that a run must write for `dirty` ones of the window, one by one: those, the nodes that read one, the
    /// ranges of 3 x 3 that read one of the coarsest of these.
    static std::uint64_t texels_to_write(const std::vector<bool>& dirty) {
        auto count = static_cast<std::uint64_t>(std::count(dirty.begin(), dirty.end(), true));
        std::vector<bool> stale;
        for (std::int32_t level = 0; level < ReliefWindow::kLevels; ++level) {
            const std::int32_t side = 2 << level, nodes = kSize / side;
            stale.assign(static_cast<std::size_t>(nodes * nodes), false);
            for (std::int32_t z = 0; z < nodes; ++z)
                for (std::int32_t x = 0; x < nodes; ++x) {
                    bool reads = false;
                    for (std::int32_t j = z * side; j <= (z + 1) * side && !reads; ++j)
                        for (std::int32_t i = x * side; i <= (x + 1) * side && !reads; ++i)
                            reads = dirty[Expected::at({i, j})];
                    stale[static_cast<std::size_t>(z * nodes + x)] = reads;
                    count += reads ? 1 : 0;
                }
        }
        constexpr std::int32_t kTop = kSize / ReliefWindow::kTopCells;
        for (std::int32_t z = 0; z < kTop; ++z)
            for (std::int32_t x = 0; x < kTop; ++x) {
                bool reads = false;
                for (std::int32_t j = z - 1; j <= z + 1; ++j)
                    for (std::int32_t i = x - 1; i <= x + 1; ++i)
                        reads = reads || stale[wrapped(j, kTop) * kTop + wrapped(i, kTop)];
                count += reads ? 1 : 0;
            }
        return count;
    }

    static GLint parameter(const gl::Texture2D& texture, GLenum name) {
        GLint value = -1;
        texture.bind(0);
        device().gl().GetTexParameteriv(GL_TEXTURE_2D, name, &value);
        return value;
    }

    static constexpr std::uint64_t kPasses = 2 + ReliefWindow::kLevels;
    std::optional<gl::ShaderLibrary> library_;
    std::optional<ReliefPass> pass_;
    std::optional<ReliefWindow> window_;
    std::vector<Tile> tiles_;
    SplitMix64 random_{5};
};

TEST_P(ReliefPassTest, ShowsTheTilesAfterAnyChangesAndMoves) {
    const gl::StateGuard guard(device());
    // The map ends within the window, at its low and its high corner; one tile of the middle is not there.
    const TileGrid grid{.size = 128, .apron = 3, .map = {{0, 0}, {350, 290}}};
    for (const TileIndex index : {TileIndex{0, 0}, TileIndex{1, 0}, TileIndex{1, 1}, TileIndex{2, 2}})
        add_tile(grid, index);
    Expected expected(flat());
    TexelRect square = relief_square({64, 64}, kSize, 64);
    ASSERT_EQ(square.min, (Texel{-64, -64}));
    std::vector<TexelRect> changed{square};
    std::uint32_t shown = 0xf;
    std::uint64_t moves = 0;
    for (int round = 0; round < 16; ++round) {
        const std::vector<bool> dirty = follow(changed, square, shown, expected);
        const bool any = std::count(dirty.begin(), dirty.end(), true) > 0;
        gl::StageStats derive;
        pass_->run(changed, square, sources(shown), *window_, derive);
        EXPECT_EQ(derive.passes, any ? kPasses : 0u) << "round " << round;
        EXPECT_EQ(derive.texels, texels_to_write(dirty)) << "round " << round;
        EXPECT_LE(derive.draws, kPasses + 4) << "a draw a source, and one for untouched ground";
        ASSERT_NO_FATAL_FAILURE(compare(expected)) << "round " << round;

        // Every tile changes everywhere: what is not named below has to keep what it was.
        changed.clear();
        for (Tile& tile : tiles_) randomise(tile);
        for (std::int32_t i = between(0, 6); i > 0; --i) {
            const TexelRect about = expanded(square, 30);
            changed.push_back(rect(about.min, about.max, round % 2 == 0 ? 9 : 120));
        }
        if (round % 3 == 1) {
            const TexelRect before = square;
            square = relief_square({between(-100, 450), between(-100, 400)}, kSize, round % 2 == 0 ? 64 : 16);
            for (const TexelRect& in : newly_covered(before, square)) changed.push_back(in);
            ++moves;
        }
        if (round % 4 == 2) {
            const auto tile = static_cast<std::size_t>(between(0, 3));
            shown ^= 1u << tile;
            changed.push_back(tiles_[tile].interior);
        }
    }
    EXPECT_GE(moves, 5u);
}

TEST_P(ReliefPassTest, NothingChangedIsNoPass) {
    const gl::StateGuard guard(device());
    const TileGrid grid{.size = 64, .apron = 2, .map = {{0, 0}, {300, 300}}};
    add_tile(grid, {0, 0});
    add_tile(grid, {1, 0});
    const TexelRect square{{0, 0}, {kSize, kSize}};
    const TexelRect beside[] = {{{-40, 10}, {0, 90}}, {{kSize, 0}, {kSize + 9, 9}}, {{30, 30}, {30, 50}}};
    gl::StageStats derive;
    pass_->run({}, square, sources(), *window_, derive);
    pass_->run(beside, square, sources(), *window_, derive);
    EXPECT_EQ(derive, gl::StageStats{});
    compare(Expected(flat()));
}

TEST_P(ReliefPassTest, AThousandRectanglesAreAsManyPassesAsOne) {
    const gl::StateGuard guard(device());
    const TileGrid grid{.size = 128, .apron = 2, .map = {{0, 0}, {400, 400}}};
    add_tile(grid, {0, 0});
    add_tile(grid, {1, 1});
    const TexelRect square{{-64, -64}, {kSize - 64, kSize - 64}};
    Expected expected(flat());
    gl::StageStats derive;
    pass_->run({&square, 1}, square, sources(), *window_, derive);
    EXPECT_EQ(derive.passes, kPasses);
    EXPECT_EQ(derive.bytes, kSize * kSize * (4 + slope_bytes()) + 8 * (derive.texels - kSize * kSize));
    static_cast<void>(follow({&square, 1}, square, ~0u, expected));
    ASSERT_NO_FATAL_FAILURE(compare(expected));

    for (Tile& tile : tiles_) randomise(tile);
    std::vector<TexelRect> many;
    while (many.size() < 1000) many.push_back(rect({-70, -70}, {kSize - 60, kSize - 60}, 24));
    for (const TexelRect& one : many) static_cast<void>(follow({&one, 1}, intersection(one, square), ~0u, expected));
    // Bounds of blocks may be taken for so many, which may show more of what changed than was named.
    pass_->run(many, square, sources(), *window_, derive = {});
    EXPECT_EQ(derive.passes, kPasses);
    EXPECT_LE(derive.texels, kSize * kSize * 3 / 2u) << "a texel twice";
    const TexelRect all[] = {square};
    Expected whole(flat());
    static_cast<void>(follow(all, square, ~0u, whole));
    std::vector<float> heights(kSize * kSize);
    window_->heights().read(0, heights.data());
    for (std::size_t i = 0; i < heights.size(); ++i) {
        const auto metres = [](std::uint32_t code) { return (double{1} * code - 2147483648.0) * kQuantum; };
        const bool named = expected.codes[i] == whole.codes[i];
        const double error = std::abs(static_cast<double>(heights[i]) - metres(whole.codes[i]));
        if (named) {
            ASSERT_LE(error, 1e-6) << i % kSize << ", " << i / kSize;
        }
    }
}

TEST_P(ReliefPassTest, LeavesThePyramidAsSamplersNeedIt) {
    const gl::StateGuard guard(device());
    const TexelRect square{{0, 0}, {kSize, kSize}};
    gl::StageStats derive;
    pass_->run({&square, 1}, square, {}, *window_, derive);
    EXPECT_EQ(parameter(window_->pyramid(), GL_TEXTURE_BASE_LEVEL), 0);
    EXPECT_EQ(parameter(window_->pyramid(), GL_TEXTURE_MAX_LEVEL), ReliefWindow::kLevels - 1);
    EXPECT_EQ(parameter(window_->pyramid(), GL_TEXTURE_MIN_FILTER), GL_NEAREST_MIPMAP_NEAREST);
    EXPECT_EQ(parameter(window_->pyramid(), GL_TEXTURE_MAG_FILTER), GL_NEAREST);
    compare(Expected(flat()));
}

INSTANTIATE_TEST_SUITE_P(Ways, ReliefPassTest,
                         ::testing::Values(Case{SlopeFormat::rg8, HeightPrecision::bits32},
                                           Case{SlopeFormat::rg8, HeightPrecision::bits16},
                                           Case{SlopeFormat::rg16f, HeightPrecision::bits32},
                                           Case{SlopeFormat::rg16f, HeightPrecision::bits16}));

}  // namespace
}  // namespace tilth
