// Detail tiles over real textures: whatever was stamped, wherever the viewers went, each resident tile's textures hold
// what one big map on the CPU holds, aprons included.
#include "tilth/detail_stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "support/fault_store.h"
#include "support/gl_context.h"
#include "tilth/gl/debug_group.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/source/analytic_sources.h"

namespace tilth {
namespace {

struct WorldSettings {
    bool gpu = false;
    HeightPrecision precision = HeightPrecision::bits32;
    std::int32_t tile_size = 128;
    std::int32_t posts = 257;  ///< a side; 769 texels, 7 tiles of 128
    std::shared_ptr<TileStore> store;
    std::uint64_t most_gpu_bytes = 0;
};

/// A detail stage and the big map that it is compared with.
class World {
public:
    World(gl::Device& device, const WorldSettings& setup) : device_(device), shaders_(test::shaders()), setup_(setup) {
        whole_ = make_ground();
        const gl::StateGuard guard(device);
        if (setup.gpu) deformer_ = std::make_unique<Deformer>(test::value(Deformer::create(device, shaders_)));
        open();
    }

    /// A new stage on the same store, as after a program's end. Nothing may be in memory.
    void reopen() {
        ASSERT_TRUE(stage_->cache().is_idle());
        open();
    }

    [[nodiscard]] DetailStage& stage() { return *stage_; }
    [[nodiscard]] Ground& ground() { return *ground_; }
    [[nodiscard]] const GridSpec& texels() const { return ground_->map(MapKind::Detail).grid; }
    [[nodiscard]] const gl::FrameStats& total() const { return total_; }
    [[nodiscard]] const gl::FrameStats& last() const { return frame_; }

    void stamp(const StampRequest& request) {
        const StampRecord record = test::value(ground_->issue(request));
        queue_.push_back({.record = record, .stroke = nullptr});
        ASSERT_TRUE(whole_->accept(record));
        whole_->apply(record);
    }

    void stamp_randomly(std::uint64_t seed, std::int64_t count, WorldPos low, WorldPos high, double largest_radius_m,
                        std::vector<StampRule> rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set,
                                                        StampRule::Smooth}) {
        RandomStamps random{.seed = seed, .count = count, .map = MapChoice::Detail, .rules = std::move(rules)};
        random.region = {low, high};
        random.radius_m = {0.05, largest_radius_m};
        random.amplitude_m = {-0.5, 0.5};
        for (std::uint32_t shape = 0; shape < ground_->shapes().size(); ++shape) random.shapes.push_back({shape});
        for (const StampRequest& request : random_stamps(random, *ground_)) stamp(request);
    }

    void frame(WorldPos viewer) { frame({&viewer, 1}); }
    void frame(std::span<const WorldPos> viewers) {
        const gl::StateGuard guard(device_);
        frame_ = {};
        stage_->set_viewers(viewers);
        stage_->begin(frame_);
        ASSERT_TRUE(stage_->apply(queue_, frame_));
        queue_.clear();
        stage_->transfer(frame_);
        total_ += frame_;
    }

    /// Frames until the store has every tile that was left.
    void frames_until_saved(WorldPos viewer) {
        const auto saving = [&] {
            const std::vector<CachedTile> tiles = stage_->cache().tiles();
            return std::any_of(tiles.begin(), tiles.end(),
                               [](const CachedTile& tile) { return tile.state == TileState::Saving; });
        };
        for (int patience = 0; saving() && patience < 10000; ++patience) {
            frame(viewer);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    /// Everything on its way arrives; then the hash, and every texel of every texture, are those of the big map.
    void expect_the_whole_maps_codes() {
        const gl::StateGuard guard(device_);
        ASSERT_TRUE(stage_->settle(total_));
        EXPECT_EQ(test::value(stage_->hash(total_)), whole_->hash().detail);
        std::vector<std::uint32_t> wanted;
        for (const CachedTile& tile : stage_->cache().tiles()) {
            if (!stage_->cache().can_be_drawn(tile.tile)) continue;
            const TexelRect rect = intersection(stage_->cache().grid().stored(tile.tile), texels().rect());
            wanted.resize(static_cast<std::size_t>(rect.count()));
            whole_->detail().copy(rect, wanted.data(), static_cast<std::size_t>(rect.width()));
            EXPECT_EQ(stage_->textures().codes(tile.tile, rect), wanted)
                << "tile " << tile.tile.x << ", " << tile.tile.z;
        }
    }
    [[nodiscard]] std::size_t drawable() {
        std::size_t count = 0;
        for (const CachedTile& tile : stage_->cache().tiles()) count += stage_->cache().can_be_drawn(tile.tile);
        return count;
    }
    /// The world position of a texel.
    [[nodiscard]] WorldPos at(double x, double z) const {
        return {texels().origin.x + x * texels().spacing_m, texels().origin.z + z * texels().spacing_m};
    }

private:
    [[nodiscard]] std::unique_ptr<Ground> make_ground() const {
        std::unique_ptr<Ground> ground =
            test::value(Ground::create(std::make_shared<FlatSource>(setup_.posts, 10.0),
                                       {.tile_size = setup_.tile_size, .precision = setup_.precision}));
        std::vector<std::uint16_t> texels(37 * 23);
        SplitMix64 random{11};
        for (std::uint16_t& texel : texels) texel = static_cast<std::uint16_t>(random.next());
        (void)test::value(ground->shapes().add_image("noise", 37, 23, texels));
        return ground;
    }
    void open() {
        const gl::StateGuard guard(device_);
        stage_.reset();
        ground_ = make_ground();
        TerrainSettings terrain;
        terrain.tiles.store = setup_.store;
        terrain.tiles.most_gpu_bytes = setup_.most_gpu_bytes;
        stage_ = test::value(DetailStage::create(device_, shaders_, *ground_, terrain, deformer_.get()));
    }

    gl::Device& device_;
    gl::ShaderLibrary shaders_;
    WorldSettings setup_;
    std::unique_ptr<Ground> ground_, whole_;
    std::unique_ptr<Deformer> deformer_;
    std::unique_ptr<DetailStage> stage_;
    std::vector<GroundEdit> queue_;
    gl::FrameStats frame_, total_;
};

class DetailStageTest : public test::GlTest {
protected:
    std::unique_ptr<World> world(const WorldSettings& setup) { return std::make_unique<World>(device(), setup); }
    std::uint64_t bytes_of_tile_textures() {
        std::uint64_t sum = 0;
        for (const gl::LiveObject& object : device().live_objects())
            if (object.kind == gl::ObjectKind::Texture && object.label.find("detail tile") != std::string::npos)
                sum += object.bytes;
        return sum;
    }
};

TEST_F(DetailStageTest, TenThousandStampsRoundACornerLeaveEveryTextureAsOneBigMap) {
    for (const bool gpu : {true, false})
        for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
            const std::unique_ptr<World> made = world({.gpu = gpu, .precision = precision});
            const WorldPos corner = made->at(384, 384);
            for (std::uint64_t round = 0; round < 100; ++round) {
                made->stamp_randomly(round, 100, {corner.x - 4, corner.z - 4}, {corner.x + 4, corner.z + 4}, 3.0);
                made->frame(corner);
            }
            made->expect_the_whole_maps_codes();
            EXPECT_EQ(made->drawable(), 4u);
            EXPECT_EQ(made->total().fallbacks(), 0u);
        }
}

// 200 m at tiles of 42 m: every tile that is resident gets it at once, the others when they arrive.
TEST_F(DetailStageTest, AStampLargerThanNineTilesReachesThoseThatAreAwayWhenTheyArrive) {
    for (const bool gpu : {true, false}) {
        const std::unique_ptr<World> made = world({.gpu = gpu});
        made->stamp_randomly(7, 300, made->at(0, 0), made->at(768, 768), 2.0);
        made->frame(made->at(384, 384));
        made->stamp({.centre = made->at(400, 390), .radius_m = 120, .amplitude_m = -0.25, .map = MapChoice::Detail});
        made->frame(made->at(384, 384));
        made->expect_the_whole_maps_codes();
        for (const WorldPos place : {made->at(64, 64), made->at(700, 64), made->at(700, 700), made->at(64, 700)}) {
            made->frame(place);
            made->expect_the_whole_maps_codes();
        }
        EXPECT_GT(made->total().cache.late_stamps, 0u);
    }
}

TEST_F(DetailStageTest, AWalkerFindsHisPrintsAgain) {
    for (const bool gpu : {true, false}) {
        const std::unique_ptr<World> made = world({.gpu = gpu});
        for (int step = 0; step < 400; ++step) {  // there and back twice, across five tiles
            const double phase = step % 200 / 200.0;
            const WorldPos viewer = made->at(60 + 640 * (phase < 0.5 ? 2 * phase : 2 - 2 * phase), 200 + step * 0.5);
            if (step % 3 == 0)
                made->stamp({.shape = {6},  // the image
                             .centre = {viewer.x, viewer.z + (step % 2 ? 0.15 : -0.15)},
                             .radius_m = 1.7,
                             .amplitude_m = step % 7 == 0 ? 0.7 : -0.1,
                             .map = MapChoice::Detail,
                             .rule = step % 7 == 0 ? StampRule::Smooth : StampRule::Min,
                             .rotation_rad = step * 0.1});
            made->frame(viewer);
            ASSERT_LE(made->drawable(), 9u);
            if (step % 100 == 99) made->frames_until_saved(viewer);  // at either end
        }
        EXPECT_GT(made->total().cache.saves, 0u);
        EXPECT_GT(made->total().cache.loads, 0u);
        EXPECT_GT(made->total().cache.evictions, 0u);
        made->expect_the_whole_maps_codes();
        EXPECT_TRUE(made->stage().cache().take_errors().empty());
    }
}

TEST_F(DetailStageTest, RandomPlacesRandomStampsEndInTheSameGround) {
    for (const bool gpu : {true, false}) {
        const std::unique_ptr<World> made = world({.gpu = gpu, .tile_size = 64});
        std::mt19937 random(5);
        std::uniform_real_distribution<double> place(-20, 790);
        std::vector<WorldPos> viewers(2);
        for (std::uint64_t step = 0; step < 500; ++step) {
            if (step % 3 == 0) viewers = {made->at(place(random), place(random)), made->at(place(random), 100)};
            const WorldPos near = step % 2 ? viewers[0] : made->at(place(random), place(random));
            made->stamp_randomly(step, 4, {near.x - 12, near.z - 12}, {near.x + 12, near.z + 12}, 5.0);
            made->frame(viewers);
            ASSERT_LE(made->drawable(), 18u);
            if (step % 100 == 99) made->expect_the_whole_maps_codes();
        }
        made->expect_the_whole_maps_codes();
    }
}

// The issue's table: nine tiles of 2 048 texels, codes and slopes, and the textures that GL has.
TEST_F(DetailStageTest, MemoryIsThatOfTheDentedTilesAboutTheViewer) {
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
        const std::uint64_t before = bytes_of_tile_textures();
        const std::unique_ptr<World> made = world({.precision = precision, .tile_size = 2048, .posts = 2732});
        const WorldPos middle = made->at(2048 * 2 + 1024, 2048 * 2 + 1024);  // of the map's last full tile but one
        made->frame(middle);
        EXPECT_EQ(made->stage().tile_bytes(), 0u) << "untouched ground";
        EXPECT_EQ(bytes_of_tile_textures(), before);
        for (int z = 0; z < 4; ++z)
            for (int x = 0; x < 4; ++x)
                made->stamp({.centre = made->at(2048 * x + 1024, 2048 * z + 1024), .radius_m = 1, .amplitude_m = -0.1});
        made->frame(middle);
        // Of sixteen tiles seven have no textures.
        EXPECT_EQ(made->drawable(), 9u);
        const std::uint64_t planes = precision == HeightPrecision::bits32 ? 4 : 2;
        EXPECT_EQ(made->stage().tile_bytes(), 9u * 2052 * 2052 * (planes + 2));
        EXPECT_EQ(bytes_of_tile_textures() - before, made->stage().tile_bytes());
        RecordProperty(precision == HeightPrecision::bits32 ? "bits32_mib" : "bits16_mib",
                       std::to_string(static_cast<double>(made->stage().tile_bytes()) / (1 << 20)));
        std::printf("nine dented tiles, %s: %.1f MiB (%.0f without aprons)\n",
                    precision == HeightPrecision::bits32 ? "bits32" : "bits16",
                    static_cast<double>(made->stage().tile_bytes()) / (1 << 20),
                    9.0 * 2048 * 2048 * static_cast<double>(planes + 2) / (1 << 20));
    }
}

TEST_F(DetailStageTest, UnderACapNearerTilesDisplaceFartherOnesAndNothingIsLost) {
    for (const bool gpu : {true, false}) {
        const std::uint64_t tile = 132u * 132 * 6;
        const std::unique_ptr<World> made = world({.gpu = gpu, .most_gpu_bytes = 4 * tile + 1});
        for (std::uint64_t step = 0; step < 120; ++step) {
            const WorldPos viewer = made->at(64 + 5.0 * static_cast<double>(step), 330);
            made->stamp_randomly(step, 3, {viewer.x - 40, viewer.z - 40}, {viewer.x + 40, viewer.z + 40}, 2.0);
            made->frame(viewer);
            ASSERT_LE(made->stage().tile_bytes(), 4 * tile);
        }
        made->expect_the_whole_maps_codes();
        EXPECT_EQ(made->drawable(), 4u);
    }
}

TEST_F(DetailStageTest, ABoundBelowFourTilesIsRefusedWithBothFigures) {
    const std::unique_ptr<Ground> ground =
        test::value(Ground::create(std::make_shared<FlatSource>(257, 10.0), {.tile_size = 128}));
    gl::ShaderLibrary library = test::shaders();
    TerrainSettings settings;
    settings.tiles.most_gpu_bytes = 132 * 132 * 6 * 4 - 1;
    const auto refused = DetailStage::create(device(), library, *ground, settings, nullptr);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("most_gpu_bytes: 418175 bytes hold 3 tiles of 104544 bytes"),
              std::string::npos)
        << refused.error().message;
    const BudgetSettings bad_budgets[] = {
        {.frame_target_ms = 0}, {.frame_target_ms = std::nan("")}, {.most_ms = -1}, {.slice_bytes = 100}};
    for (const BudgetSettings& budget : bad_budgets) {
        settings.tiles = {.budget = budget};
        const auto bad = DetailStage::create(device(), library, *ground, settings, nullptr);
        ASSERT_FALSE(bad);
        EXPECT_EQ(bad.error().message.rfind("budget:", 0), 0u) << bad.error().message;
    }
    settings.tiles = {.band = 0.95};
    EXPECT_FALSE(DetailStage::create(device(), library, *ground, settings, nullptr));
    settings.tiles = {.apron = 1};
    EXPECT_FALSE(DetailStage::create(device(), library, *ground, settings, nullptr));
}

// A store that answers nothing for 2 s and more, and one that fails: the frame goes on without the tile.
TEST_F(DetailStageTest, ASlowOrBrokenStoreCostsNoFrameAndNoEdit) {
    for (const bool gpu : {true, false}) {
        const auto store = std::make_shared<test::FaultStore>();
        const std::unique_ptr<World> made = world({.gpu = gpu, .store = store});
        const test::InterruptAtEnd at_end(store);
        const WorldPos here = made->at(64, 64), there = made->at(700, 700);
        made->stamp_randomly(1, 40, {here.x - 5, here.z - 5}, {here.x + 5, here.z + 5}, 1.0);
        made->frame(here);
        made->frame(there);
        made->expect_the_whole_maps_codes();  // saved by now, or on its way
        while (made->stage().cache().state({0, 0}) != TileState::Absent) made->frame(there);

        store->hold();  // longer than any latency: until it is released
        for (int frame = 0; frame < 30; ++frame) {
            made->stamp_randomly(100 + static_cast<std::uint64_t>(frame), 2, {here.x - 5, here.z - 5},
                                 {here.x + 5, here.z + 5}, 1.0, {StampRule::Add, StampRule::Min});
            made->frame(here);
            EXPECT_EQ(made->drawable(), 0u);
            EXPECT_GE(made->last().cache.missing_active, 1u) << "the frame says what it misses";
        }
        EXPECT_TRUE(made->stage().cache().take_errors().empty());
        store->release();
        made->expect_the_whole_maps_codes();
        EXPECT_GE(made->drawable(), 1u);

        made->frame(there);
        while (made->stage().cache().state({0, 0}) != TileState::Absent) made->frame(there);
        store->fail_all(true);
        std::vector<Error> errors;
        for (int frame = 0; frame < 200; ++frame) {
            made->frame(here);
            for (const Error& error : made->stage().cache().take_errors()) errors.push_back(error);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));  // retries come by the clock
        }
        ASSERT_EQ(errors.size(), 1u) << "once, although it was tried again";
        EXPECT_NE(errors.front().message.find("(0, 0)"), std::string::npos) << errors.front().message;
        made->stamp_randomly(3, 10, {here.x - 5, here.z - 5}, {here.x + 5, here.z + 5}, 1.0, {StampRule::Add});
        made->frame(here);
        store->fail_all(false);
        made->expect_the_whole_maps_codes();
        EXPECT_GE(made->drawable(), 1u);
    }
}

// Tiles larger than the ring: a read-back takes several rounds, and whoever looks meanwhile sees all of it.
TEST_F(DetailStageTest, ALargeReadBackIsWaitedForWholly) {
    const std::unique_ptr<World> made = world({.gpu = true, .tile_size = 2048, .posts = 1400});
    const WorldPos here = made->at(1024, 1024);
    made->stamp({.centre = here, .radius_m = 330, .amplitude_m = -0.5, .map = MapChoice::Detail});
    made->frame(here);
    made->frame(std::span<const WorldPos>{});  // leaves: the read-back begins
    EXPECT_EQ(made->stage().cache().state({0, 0}), TileState::Saving);
    made->expect_the_whole_maps_codes();
    made->frame(here);
    made->expect_the_whole_maps_codes();
}

// A dent that ends just before a tile that was never touched itself: its apron is not empty, also when another program
// run knows it from the store's list alone.
TEST_F(DetailStageTest, ReopenedTilesHaveTheirNeighboursInTheirAprons) {
    for (const bool gpu : {true, false}) {
        const auto store = std::make_shared<MemoryStore>();
        const std::unique_ptr<World> made = world({.gpu = gpu, .store = store});
        for (const double x : {380.0, 300.0, 256.0})  // the first ends one texel before tile 3, which is never visited
            made->stamp({.centre = made->at(x, 330), .radius_m = 1.0, .amplitude_m = -0.25, .map = MapChoice::Detail});
        made->frame(std::span<const WorldPos>{});
        made->frame(made->at(300, 330));
        made->expect_the_whole_maps_codes();
        for (int frame = 0; frame < 2000 && !made->stage().cache().is_idle(); ++frame) {
            made->frame(std::span<const WorldPos>{});
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        made->reopen();
        if (gpu) {  // grazed again, by a stamp that only the textures of tile 2 have
            made->frame(made->at(300, 330));
            made->expect_the_whole_maps_codes();
            made->stamp({.centre = made->at(380, 332), .radius_m = 1, .amplitude_m = -0.25, .map = MapChoice::Detail});
            made->frame(made->at(300, 330));
        }
        made->frame(made->at(420, 330));
        made->expect_the_whole_maps_codes();
        made->stamp({.centre = made->at(388, 331), .radius_m = 1.5, .amplitude_m = -0.25, .map = MapChoice::Detail});
        made->frame(made->at(420, 330));
        made->expect_the_whole_maps_codes();
        EXPECT_TRUE(made->stage().cache().can_be_drawn({3, 2}));
        // Of the eight neighbours those that nothing reaches cost nothing.
        EXPECT_LE(made->drawable(), 3u);
    }
}

}  // namespace
}  // namespace tilth
