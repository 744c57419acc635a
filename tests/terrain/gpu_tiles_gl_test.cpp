// Tiles on the GPU hold the bits of one big map on the CPU: stamps across corners, smooth, fills, read-backs.
#include "tilth/gpu_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/gl_context.h"
#include "support/route_and_precision.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

struct WorldOptions {
    std::int32_t size = 128, width = 250, depth = 243;  ///< the far tiles reach beyond the map
    SlopeFormat slopes = SlopeFormat::rg8;
    SlopeStencil stencil = SlopeStencil::Central;
    std::size_t slot_bytes = 512u << 10;
    int slots = 8;
    bool gpu_executor = true;
};

/// A detail map of one texel a metre as tiles on the GPU, and whole on the CPU.
struct World {
    World(gl::Device& gl_device, HeightPrecision height_precision, const WorldOptions& wanted = {})
        : device(gl_device),
          precision(height_precision),
          options(wanted),
          grid{.size = wanted.size,
               .apron = stencil_reach(wanted.stencil) + 1,
               .map = {{0, 0}, {wanted.width, wanted.depth}}},
          map{.kind = MapKind::Detail,
              .grid = {.spacing_m = 1, .width = wanted.width, .depth = wanted.depth},
              .codec = HeightCodec::detail(),
              .precision = height_precision},
          library(test::shaders(gl_device)),
          deformer(test::value(Deformer::create(gl_device, library))) {
        std::vector<std::uint16_t> texels(37 * 23);
        for (std::uint16_t& texel : texels) texel = static_cast<std::uint16_t>(random.next());
        (void)*shapes.add_image("noise", 37, 23, texels);
        (void)*shapes.bake("saddle", 64, [](double x, double z) { return (x * x - z * z) * 0.9; });
        (void)*shapes.add_profile("rim", [](double t) { return (1 - t) * (2 * t - 0.5); });
        tiles = test::value(GpuTiles::create(device, library, wanted.gpu_executor ? &deformer : nullptr,
                                             {.pool = {.grid = grid, .precision = precision, .slopes = wanted.slopes},
                                              .slopes = slope_settings(),
                                              .slot_bytes = wanted.slot_bytes,
                                              .slots = wanted.slots}));
        tiles->set_stats(&stats);
    }
    [[nodiscard]] SlopeSettings slope_settings() const { return {options.stencil, map.codec.code_quantum_m(), 1.0}; }
    [[nodiscard]] std::vector<TileIndex> all() const {
        std::vector<TileIndex> indices;
        const TileWindow window = tiles_of(grid, grid.map);
        for (std::int32_t z = window.min.z; z <= window.max.z; ++z)
            for (std::int32_t x = window.min.x; x <= window.max.x; ++x) indices.push_back({x, z});
        return indices;
    }
    void acquire_all() {
        for (const TileIndex index : all()) ASSERT_TRUE(tiles->acquire(index));
    }

    /// A stamp about (x, z), `spread` texels away at most.
    PreparedStamp stamp(std::span<const StampRule> rules, double x, double z, double spread, double largest_radius,
                        double largest_amplitude) {
        StampRecord record;
        record.centre_x = static_cast<std::int64_t>((x + random.between(-spread, spread)) * 0x1p24);
        record.centre_z = static_cast<std::int64_t>((z + random.between(-spread, spread)) * 0x1p24);
        record.shape = static_cast<std::uint32_t>(random.next() % shapes.size());
        record.radius = static_cast<std::uint32_t>(random.between(0.4, largest_radius) * 0x1p18);
        record.rotation = static_cast<std::uint32_t>(random.next());
        record.key = static_cast<std::uint32_t>(random.next());
        record.rule = rules[random.next() % rules.size()];
        record.negative = random.next() & 1;
        record.mirror = random.next() & 1;
        record.map = MapKind::Detail;
        record.amplitude = static_cast<std::uint32_t>(random.unit() * largest_amplitude);
        record.level = kMidCode + static_cast<std::uint32_t>(random.between(-1, 1) * 0x1000'0000);
        if (precision == HeightPrecision::bits16) record.level &= 0xffff'0000u;
        if (record.rule == StampRule::Smooth) record.amplitude = 1 + static_cast<std::uint32_t>(random.next() % 65536);
        if (record.rule == StampRule::Smooth) record.negative = 0;
        return prepare(record, map, shapes);
    }

    /// The tiles that hold a texel of one of `stamps`.
    [[nodiscard]] std::vector<TileIndex> touched(std::span<const PreparedStamp> stamps) const {
        std::vector<TileIndex> indices;
        for (const TileIndex index : all())
            if (std::any_of(stamps.begin(), stamps.end(), [&](const PreparedStamp& s) {
                    return !intersection(s.rect(), grid.stored(index)).empty();
                }))
                indices.push_back(index);
        return indices;
    }
    /// To both. After a smooth stamp aprons are copied from their owners, as the cache does.
    void apply(std::span<const PreparedStamp> stamps) {
        std::size_t applied = 0;
        const std::vector<TileIndex> indices = touched(stamps);
        const Result<void> drawn = tiles->stamp(stamps, indices, applied);
        ASSERT_TRUE(drawn) << drawn.error().message;
        ASSERT_EQ(applied, stamps.size());
        for (const PreparedStamp& s : stamps) cpu += apply_stamp(s, field, grid.map);
        if (stamps.size() != 1 || stamps.front().reads_own_texel_only()) return;
        for (const TileIndex to : indices)
            for (const TileIndex from : indices) {
                const TexelRect shared =
                    intersection(intersection(stamps.front().rect(), grid.interior(from)), grid.stored(to));
                if (from != to && !shared.empty()) tiles->exchange(from, to, shared);
            }
    }

    /// Stored texels of the map in which tiles differ from the CPU's map.
    std::int64_t differences() {
        std::int64_t count = 0;
        GatheredCodes gathered;
        for (const TileIndex index : all()) {
            const TexelRect held = intersection(grid.stored(index), grid.map);
            const std::vector<std::uint32_t> codes = tiles->codes(index, held);
            const CodeView truth = gathered.gather(field, held);
            for (std::size_t i = 0; i < codes.size(); ++i) count += codes[i] != truth.codes[i];
        }
        return count;
    }
    /// Components of slopes, on the interiors and one texel around, that are more than `steps` of the storage away from
    /// those of the one map.
    std::int64_t wrong_slopes(int steps) {
        std::int64_t wrong = 0;
        GatheredCodes gathered;
        const CodeView whole = gathered.gather(field, grid.map);
        const std::size_t texel = slope_bytes(options.slopes);
        for (const TileIndex index : all()) {
            const TexelRect right = intersection(expanded(grid.interior(index), 1), grid.map);
            std::vector<std::uint8_t> truth(static_cast<std::size_t>(right.count()) * texel);
            store_slopes(right, whole, grid.map, slope_settings(), options.slopes, truth.data());
            const auto side = static_cast<std::size_t>(grid.stored_size());
            std::vector<std::uint8_t> stored(side * side * texel);
            tiles->slopes_of(index)->read(0, stored.data());
            const TexelRect rect = grid.stored(index);
            std::size_t i = 0;
            for (std::int32_t z = right.min.z; z < right.max.z; ++z)
                for (std::int32_t x = right.min.x; x < right.max.x; ++x, i += texel) {
                    const std::size_t at =
                        (static_cast<std::size_t>(z - rect.min.z) * side + static_cast<std::size_t>(x - rect.min.x)) *
                        texel;
                    for (std::size_t c = 0; c < 2; ++c) {
                        const auto number = [&](const std::vector<std::uint8_t>& bytes, std::size_t first) {
                            return texel == 2 ? bytes[first + c] : bytes[first + 2 * c] | bytes[first + 2 * c + 1] << 8;
                        };
                        wrong += std::abs(number(stored, at) - number(truth, i)) > steps;
                    }
                }
        }
        return wrong;
    }

    gl::Device& device;
    gl::StateGuard guard{device};
    HeightPrecision precision;
    WorldOptions options;
    TileGrid grid;
    MapGeometry map;
    ShapeLibrary shapes;
    gl::ShaderLibrary library;
    Deformer deformer;
    std::unique_ptr<GpuTiles> tiles;
    gl::FrameStats stats;
    DetailField field;
    ApplyResult cpu;
    SplitMix64 random{77};
};

constexpr StampRule kOwnTexelRules[] = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set};
constexpr StampRule kAllRules[] = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth};
constexpr StampRule kSmooth[] = {StampRule::Smooth};
constexpr StampRule kAdd[] = {StampRule::Add};

class GpuTilesTest : public test::GlRouteTest<test::RouteAndPrecision> {
protected:
    static World world(const WorldOptions& options = {}) { return {device(), GetParam().precision, options}; }
};

TEST_P(GpuTilesTest, TenThousandStampsRoundACornerLeaveTheBitsOfOneBigMap) {
    World made = world();
    made.acquire_all();
    SplitMix64 frames{4};
    for (std::size_t done = 0; done < 10000;) {
        const std::size_t count = std::min<std::size_t>(10000 - done, 1 + frames.next() % 300);
        std::vector<PreparedStamp> stamps;
        for (std::size_t i = 0; i < count; ++i)  // most on the corner, some along the edges and at the map's far border
            stamps.push_back(frames.next() % 4 != 0
                                 ? made.stamp(kOwnTexelRules, 128, 128, 12, i % 50 == 0 ? 90 : 9, 0x0080'0000)
                                 : made.stamp(kOwnTexelRules, 128, 128, 126, 12, 0x0080'0000));
        made.apply(stamps);
        done += count;
        if (frames.next() % 8 == 0) {
            ASSERT_EQ(made.differences(), 0) << "after " << done << " stamps";
        }
    }
    EXPECT_EQ(made.differences(), 0);
    EXPECT_EQ(made.wrong_slopes(1), 0);
    made.deformer.finish(made.stats.deform);
    EXPECT_EQ(made.stats.deform.saturated, made.cpu.saturated);
    EXPECT_EQ(made.stats.deform.fallbacks + made.stats.derive.fallbacks, 0u);
}

TEST_P(GpuTilesTest, SmoothAndExchangeLeaveTheBitsOfOneBigMap) {
    World made = world();
    made.acquire_all();
    for (int i = 0; i < 600; ++i) {
        const PreparedStamp stamp = i % 2 == 0 ? made.stamp(kSmooth, 128, 128, 30, i % 40 == 0 ? 100 : 12, 0)
                                               : made.stamp(kAllRules, 128, 128, 124, 20, 0x0100'0000);
        made.apply({&stamp, 1});
        if (i % 60 == 0) {
            ASSERT_EQ(made.differences(), 0) << "after " << i + 1 << " stamps";
        }
    }
    EXPECT_EQ(made.differences(), 0);
    EXPECT_EQ(made.wrong_slopes(1), 0);
}

TEST_P(GpuTilesTest, SaturatedTexelsOfSharedAreasCountOnce) {
    World made = world();
    made.acquire_all();
    for (int i = 0; i < 80; ++i) {
        const PreparedStamp stamp = made.stamp(kOwnTexelRules, 128, 128, 30, 25, 0xf000'0000);
        made.apply({&stamp, 1});
    }
    made.deformer.finish(made.stats.deform);
    EXPECT_GT(made.cpu.saturated, 1000u);
    EXPECT_EQ(made.stats.deform.saturated, made.cpu.saturated);
    EXPECT_EQ(made.differences(), 0);
}

TEST_P(GpuTilesTest, ACornerIsOneSetUpAndNothingIsCountedThatCannotSaturate) {
    World made = world();
    made.acquire_all();
    const PreparedStamp stamp = made.stamp(kAdd, 128, 128, 0, 6, 0x0010'0000);
    made.apply({&stamp, 1});
    EXPECT_EQ(made.stats.deform.passes, 1u);
    EXPECT_EQ(made.stats.deform.draws, 4u);
    EXPECT_EQ(made.stats.derive.passes, 1u);
    EXPECT_EQ(made.stats.derive.draws, 4u);
    std::uint64_t texels = 0;
    for (const TileIndex index : made.all())
        texels += static_cast<std::uint64_t>(intersection(stamp.rect(), made.grid.stored(index)).count());
    EXPECT_EQ(made.stats.deform.texels, texels);
    EXPECT_EQ(made.differences(), 0);
}

TEST_P(GpuTilesTest, PartsBeyondTheScratchGoIntoSeveralPasses) {
    if (GetParam().route == context::Route::Osmesa) GTEST_SKIP() << "a question of arithmetic; EGL answers it";
    World made = world({.size = 640, .width = 1280, .depth = 1280});
    made.acquire_all();
    for (int i = 0; i < 2; ++i) {
        const PreparedStamp add = made.stamp(kAdd, 640, 640, 20, 600, 0x0100'0000);
        PreparedStamp smooth = made.stamp(kSmooth, 640, 640, 20, 600, 0);
        made.apply({&add, 1});
        made.apply({&smooth, 1});
    }
    std::vector<PreparedStamp> many;
    for (int i = 0; i < 400; ++i) many.push_back(made.stamp(kOwnTexelRules, 640, 640, 640, 60, 0x0010'0000));
    made.apply(many);
    EXPECT_GT(made.stats.deform.passes, 6u);
    EXPECT_EQ(made.differences(), 0);
    EXPECT_EQ(made.wrong_slopes(1), 0);
    const std::uint64_t planes = GetParam().precision == HeightPrecision::bits32 ? 4 : 2;
    EXPECT_LE(made.deformer.bytes(), planes * 1024 * 1024 + (1u << 20)) << "scratch, and the lists";
}

TEST_P(GpuTilesTest, FillsThroughTheRingAndAtOnceGiveCodesAndSlopes) {
    for (const bool gpu_executor : {true, false})
        for (const SlopeFormat format : {SlopeFormat::rg8, SlopeFormat::rg16f}) {
            World made = world({.slopes = format,
                                .stencil = format == SlopeFormat::rg8 ? SlopeStencil::Central : SlopeStencil::Fourth,
                                .slot_bytes = 40000,
                                .slots = 3,
                                .gpu_executor = gpu_executor});
            for (int i = 0; i < 60; ++i)
                apply_stamp(made.stamp(kOwnTexelRules, 80, 100, 60, 25, 0x0100'0000), made.field, made.grid.map);
            made.acquire_all();
            int refused = 0, slices = 0;
            for (const TileIndex index : made.all()) {
                const TexelRect stored = made.grid.stored(index);
                for (std::int32_t z = stored.min.z; z < stored.max.z; z += 20, ++slices) {
                    const TexelRect rect{{stored.min.x, z}, {stored.max.x, std::min(z + 20, stored.max.z)}};
                    const bool paging = slices % 3 != 0;
                    while (!made.tiles->fill(index, rect, made.field, paging)) {
                        ASSERT_TRUE(paging);
                        ++refused;
                        made.tiles->finish();
                    }
                }
            }
            EXPECT_EQ(made.differences(), 0);
            EXPECT_EQ(made.wrong_slopes(gpu_executor ? 1 : 0), 0);
            EXPECT_EQ(made.stats.derive.fallbacks, 0u);
            std::uint64_t moved = 0;
            for (const TileIndex index : made.all())
                moved += static_cast<std::uint64_t>(intersection(made.grid.stored(index), made.grid.map).count()) *
                         (GetParam().precision == HeightPrecision::bits32 ? 4 : 2);
            if (gpu_executor) {
                EXPECT_EQ(made.stats.transfer.bytes_up, moved);
            } else {
                EXPECT_GT(made.stats.transfer.bytes_up, moved);
            }
        }
}

TEST_P(GpuTilesTest, AFullRingChangesNothing) {
    World made = world({.slot_bytes = 64 * 64 * 4, .slots = 2});
    made.acquire_all();
    const PreparedStamp stamp = made.stamp(kAdd, 32, 32, 0, 30, 0x0100'0000);
    apply_stamp(stamp, made.field, made.grid.map);
    const TexelRect rect{{0, 0}, {64, 64}};
    gl::Api& gl = const_cast<gl::Api&>(device().gl());
    const auto wait = gl.ClientWaitSync;
    gl.ClientWaitSync = [](GLsync, GLbitfield, GLuint64) -> GLenum { return GL_TIMEOUT_EXPIRED; };
    const DetailField untouched;
    EXPECT_TRUE(made.tiles->fill({0, 0}, rect, untouched, true));
    EXPECT_TRUE(made.tiles->fill({0, 0}, rect, untouched, true));
    const gl::TransferStats before = made.stats.transfer;
    EXPECT_FALSE(made.tiles->fill({0, 0}, rect, made.field, true));
    gl.ClientWaitSync = wait;
    EXPECT_EQ(made.stats.transfer, before);
    for (const std::uint32_t code : made.tiles->codes({0, 0}, rect)) ASSERT_EQ(code, kMidCode);
    made.tiles->finish();
    EXPECT_TRUE(made.tiles->fill({0, 0}, rect, made.field, true));
    EXPECT_EQ(made.differences(), 0);
    EXPECT_TRUE(made.tiles->fill({0, 0}, made.grid.stored({0, 0}), made.field, true)) << "more than a slot";
    EXPECT_EQ(made.stats.derive.fallbacks, 1u);
    EXPECT_EQ(made.differences(), 0);
}

TEST_P(GpuTilesTest, ReadBacksBringTheCodesAndNarrowTheBounds) {
    World made = world({.slot_bytes = 9000, .slots = 2});
    made.acquire_all();
    for (int i = 0; i < 40; ++i) {
        const PreparedStamp stamp = made.stamp(kOwnTexelRules, 128, 128, 60, 40, 0x0100'0000);
        made.apply({&stamp, 1});
    }
    DetailField read;
    EXPECT_EQ(made.tiles->poll_read_back({0, 0}, read), ReadBackState::None);
    for (const TileIndex index : made.all()) {
        const TexelRect interior = intersection(made.grid.interior(index), made.grid.map);
        const TexelRect rects[] = {{interior.min, {interior.max.x, interior.min.z + 33}},
                                   {{interior.min.x, interior.min.z + 33}, interior.max}};
        while (!made.tiles->begin_read_back(index, rects)) made.tiles->finish();
        ReadBackState state = made.tiles->poll_read_back(index, read);
        for (int i = 0; i < 1000 && state == ReadBackState::Pending; ++i) {
            made.tiles->finish();
            state = made.tiles->poll_read_back(index, read);
        }
        EXPECT_EQ(state, ReadBackState::Done);
        EXPECT_EQ(made.tiles->poll_read_back(index, read), ReadBackState::None);
    }
    GatheredCodes a, b;
    const CodeView truth = a.gather(made.field, made.grid.map), got = b.gather(read, made.grid.map);
    const auto count = static_cast<std::size_t>(made.grid.map.count());
    EXPECT_TRUE(std::equal(got.codes, got.codes + count, truth.codes));
    EXPECT_EQ(made.stats.transfer.bytes_down, count * (GetParam().precision == HeightPrecision::bits32 ? 4u : 2u));

    DetailField at_once;
    for (const TileIndex index : made.all()) {
        const TexelRect interior = made.grid.interior(index);
        made.tiles->read_back_now(index, {&interior, 1}, at_once);
    }
    const CodeView now = b.gather(at_once, made.grid.map);
    EXPECT_TRUE(std::equal(now.codes, now.codes + count, truth.codes));
}

TEST_P(GpuTilesTest, BoundsFollowWhatIsKnownOfTheGround) {
    World made = world();
    made.acquire_all();
    StampRecord record{.centre_x = std::int64_t{96} << 24,
                       .centre_z = std::int64_t{96} << 24,
                       .shape = static_cast<std::uint32_t>(BuiltinProfile::Disc),
                       .radius = 20u << 18,
                       .amplitude = 0x3000'0000,
                       .map = MapKind::Detail};
    const PreparedStamp up = prepare(record, made.map, made.shapes),
                        down = prepare(negated(record), made.map, made.shapes);
    for (int i = 0; i < 3; ++i) {
        EXPECT_FALSE(made.tiles->may_saturate({0, 0}, up) && i == 0);
        made.apply({&up, 1});
        made.apply({&down, 1});
    }
    EXPECT_TRUE(made.tiles->may_saturate({0, 0}, up)) << "bounds only widen";
    // A stamp between the beginning and the end of a read-back: the old codes must not narrow the bounds.
    const TexelRect interior = made.grid.interior({0, 0});
    DetailField read;
    ASSERT_TRUE(made.tiles->begin_read_back({0, 0}, {&interior, 1}));
    made.apply({&up, 1});
    made.tiles->finish();
    while (made.tiles->poll_read_back({0, 0}, read) == ReadBackState::Pending) made.tiles->finish();
    EXPECT_TRUE(made.tiles->may_saturate({0, 0}, up));
    made.apply({&down, 1});
    made.tiles->read_back_now({0, 0}, {&interior, 1}, read);
    EXPECT_FALSE(made.tiles->may_saturate({0, 0}, up));
    EXPECT_EQ(made.differences(), 0);
}

TEST_P(GpuTilesTest, UntouchedGroundCostsNothing) {
    const std::uint64_t before = device().resident_bytes();
    const std::size_t objects = device().live_objects().size();
    World made = world();
    EXPECT_EQ(made.tiles->pool().bytes() + made.tiles->working_bytes(), 0u);
    EXPECT_EQ(device().resident_bytes(), before);
    EXPECT_LE(device().live_objects().size() - objects, 2u) << "framebuffers for copies";
    EXPECT_EQ(made.tiles->slopes_of({0, 0}), nullptr);
    EXPECT_TRUE(made.tiles->acquire({0, 0}));
    EXPECT_NE(made.tiles->slopes_of({0, 0}), nullptr);
    made.tiles->release({0, 0});
    EXPECT_EQ(made.tiles->slopes_of({0, 0}), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Contexts, GpuTilesTest, test::every_route_and_precision(), test::name_of);

}  // namespace
}  // namespace tilth
