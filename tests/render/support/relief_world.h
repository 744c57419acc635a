// A `Terrain` with prints in it and the truth beside it: the same stamps on a `Ground` without GL.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/support/shown_ground.h"
#include "render/support/trail.h"
#include "support/gl_context.h"
#include "tilth/cache/nine_regions.h"
#include "tilth/render/detail_settings.h"
#include "tilth/render/relief_reach.h"
#include "tilth/source/analytic_sources.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth::test {

/// Heights by a formula, metres over posts.
class FormulaSource final : public HeightSource {
public:
    FormulaSource(std::int32_t size, double min_m, double max_m, std::function<double(double x, double z)> height_m)
        : size_(size), min_m_(min_m), max_m_(max_m), height_m_(std::move(height_m)) {}
    [[nodiscard]] std::int32_t width() const override { return size_; }
    [[nodiscard]] std::int32_t depth() const override { return size_; }
    [[nodiscard]] double min_m() const override { return min_m_; }
    [[nodiscard]] double max_m() const override { return max_m_; }
    [[nodiscard]] double height_m(Texel t) const override { return height_m_(t.x, t.z); }

private:
    std::int32_t size_;
    double min_m_, max_m_;
    std::function<double(double, double)> height_m_;
};

/// What a frame left in the target.
struct Frame {
    std::vector<std::uint8_t> rgba;
    std::vector<float> depth;
    std::uint64_t primitives_generated = 0;
    gl::FrameStats stats;  ///< without times
};

/// What a `ReliefWorld` is made with. The default clipmap is that of the reference configuration: relief reaches 10 m.
struct ReliefWorldOptions {
    ClipmapSettings clipmap{.n = 255, .levels = 5, .blend = 0.1};
    std::int32_t tile_size = 1024;
    std::string shader_folder = TILTH_SOURCE_DIR "/shaders";
};

/// Posts 0.1 m apart, three texels a post, as in the reference configuration. The stamps go by the GPU executor into
/// tiles, and by the CPU into `truth()`.
class ReliefWorld {
public:
    using Options = ReliefWorldOptions;
    static constexpr double kSpacingM = 0.1;

    explicit ReliefWorld(const std::shared_ptr<const HeightSource>& source, const Options& options = {})
        : clipmap_(options.clipmap), tile_size_(options.tile_size) {
        TerrainSettings settings{
            .executor = ExecutorKind::Gpu, .clipmap = options.clipmap, .shader_folder = options.shader_folder};
        settings.ground.spacing_m = kSpacingM;
        settings.ground.texels_per_post = 3;
        settings.ground.tile_size = options.tile_size;
        truth_ = value(Ground::create(source, settings.ground));
        terrain_ = value(Terrain::create(source, settings, test_context(default_route()).context->get_proc()));
        // As wide as the print is with its rim; weight -1 is its rim's height over its depth.
        const auto boot = [](double x, double z) {
            return std::clamp(-boot_print_m(x * 0.17, z * 0.17) / 0.03, -1.0, 1.0);
        };
        boot_ = add([&](ShapeLibrary& shapes) { return shapes.bake("boot", 128, boot); });
        const auto noise = [](double x, double z) {  // a hash of the place: no two neighbours are alike
            const auto at = static_cast<std::uint32_t>((x + 1) * 700) * 0x9e3779b1u ^
                            static_cast<std::uint32_t>((z + 1) * 700) * 0x85ebca77u;
            const std::uint32_t mixed = (at ^ (at >> 15)) * 0x2c1b3c6du;
            return static_cast<double>((mixed ^ (mixed >> 13)) & 0xffffu) / 32767.5 - 1;
        };
        noise_ = add([&](ShapeLibrary& shapes) { return shapes.bake("noise", 512, noise); });
    }

    [[nodiscard]] ShapeId boot() const { return boot_; }
    [[nodiscard]] ShapeId noise() const { return noise_; }
    [[nodiscard]] Terrain& terrain() { return *terrain_; }
    [[nodiscard]] const Ground& truth() const { return *truth_; }

    void stamp(StampRequest request) {
        request.map = MapChoice::Detail;
        const StampRecord record = value(terrain_->stamp(request));
        EXPECT_TRUE(truth_->accept(record));
        truth_->apply(record);
    }
    /// A right boot, toes along +x turned by `rotation_rad`.
    void print(WorldPos at, double rotation_rad = 0, bool mirror = false) {
        stamp({.shape = boot_,
               .centre = at,
               .radius_m = 0.17,
               .amplitude_m = -0.03,
               .rotation_rad = rotation_rad,
               .mirror = mirror});
    }
    void settle(WorldPos viewer) {
        terrain_->set_viewers(std::span(&viewer, 1));
        EXPECT_TRUE(terrain_->update(0));
        EXPECT_TRUE(terrain_->drain());
    }

    /// From `above_m` over the surface at (x, z), along `forward`.
    [[nodiscard]] View view(WorldPos at, double above_m, Vec3d forward, int width = 480, int height = 270) const {
        return {.eye = {at.x, truth_->height_m(at) + above_m, at.z},
                .forward = forward,
                .width = width,
                .height = height,
                .near_m = 0.2,
                .far_m = 1000};
    }
    /// Where relief stands in full: before the fade over the last quarter, and a metre on this side of it, because the
    /// fade goes by the coarse ground at a pixel and what is compared by the ground that shows.
    [[nodiscard]] double whole_reach_m() const {
        const double tile_m = tile_size_ * kSpacingM / 3;
        return 0.75 * std::min(relief_reach(clipmap_, kSpacingM, 3, 1, 1e9).reach_m,
                               active_reach_m(tile_m, TileSettings().band)) -
               1;
    }

    /// Refused (by the driver, say): false, and `why`.
    [[nodiscard]] bool show(const DetailSettings& settings, std::string* why = nullptr) {
        const Result<void> set = terrain_->set_detail(settings);
        if (!set && why != nullptr) *why = set.error().message;
        return set.ok();
    }
    /// Draws the view on magenta, with the tiles that its eye wants. The frame that is told of is the last of `times`.
    Frame draw(const Target& target, const View& view, int times = 1) {
        settle({view.eye.x, view.eye.z});
        gl::Query query = value(gl::Query::create(device(), "generated", gl::QueryKind::PrimitivesGenerated));
        Frame frame;
        for (int time = 0; time < times; ++time) {
            EXPECT_TRUE(terrain_->update(0));
            target.clear(1, 0, 1, view.depth == DepthConvention::Reversed ? 0 : 1);
            query.begin();
            const Result<void> drawn = terrain_->draw(view, {.to_light = {0.5f, 0.45f, 0.3f}});
            query.end();
            EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
            if (!drawn) return frame;
            frame.primitives_generated = query.result();
        }
        frame.stats = terrain_->last_frame();
        for (gl::StageStats* stage : {&frame.stats.deform, &frame.stats.derive, &frame.stats.mips, &frame.stats.render})
            stage->cpu_ms = 0;
        frame.stats.cache.transfer_ms = frame.stats.store.snapshot_ms = 0;
        frame.rgba = target.pixels();
        frame.depth = target.depths();
        return frame;
    }

private:
    template <class Add>
    ShapeId add(Add add_to) {
        const ShapeId id = value(add_to(truth_->shapes()));
        EXPECT_EQ(value(add_to(terrain_->shapes())), id);
        return id;
    }
    ClipmapSettings clipmap_;
    std::int32_t tile_size_;
    std::unique_ptr<Ground> truth_;
    std::unique_ptr<Terrain> terrain_;
    ShapeId boot_, noise_;
};

}  // namespace tilth::test
