#include "render/relief_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "support/bench_device.h"
#include "tilth/core/hash.h"

namespace tilth::bench {
namespace {

constexpr double kWalk_m = 60, kWayside_m = 12;
constexpr double kCorner_m = 3 * kTileWidth_m;  // where four tiles meet, in the middle of the map
const double kAlong = std::numbers::sqrt2 / 2;  // of the walk's direction, on either axis
constexpr double kHeading_rad = -std::numbers::pi / 4;

/// The same numbers with every standard library.
class Dice {
public:
    double within(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }

private:
    std::mt19937 engine_{20101118};
};

/// A place in tile (x, z) of the four about the corner, no farther than `kWayside_m` from the way.
WorldPos place_beside_way(Dice& dice, int x, int z) {
    while (true) {
        const WorldPos on_way = walk_place(dice.within(0, 1));
        const double dx = dice.within(-kWayside_m, kWayside_m), dz = dice.within(-kWayside_m, kWayside_m);
        const WorldPos at{on_way.x + dx, on_way.z + dz};
        if (std::hypot(dx, dz) < kWayside_m && (at.x > kCorner_m) == (x == 1) && (at.z > kCorner_m) == (z == 1))
            return at;
    }
}

void add_stamps(std::vector<StampRequest>& all, Dice& dice, ShapeId boot) {
    const ShapeId gaussian{static_cast<std::uint32_t>(BuiltinProfile::Gaussian)};
    for (int tile = 0; tile < 4; ++tile) {
        for (int i = 0; i < 20; ++i) {
            const WorldPos at = place_beside_way(dice, tile % 2, tile / 2);
            all.push_back({.shape = boot, .centre = at, .radius_m = 0.5, .amplitude_m = -0.05});
            all.back().rotation_rad = dice.within(0, 6);
        }
        for (int i = 0; i < 20; ++i) {
            const WorldPos at = place_beside_way(dice, tile % 2, tile / 2);
            all.push_back({.shape = gaussian, .centre = at, .radius_m = dice.within(0.5, 2)});
            all.back().amplitude_m = dice.within(-0.15, -0.05);
        }
    }
}

void add_dense_stamps(std::vector<StampRequest>& all, Dice& dice) {
    const ShapeId gaussian{static_cast<std::uint32_t>(BuiltinProfile::Gaussian)};
    for (int i = 0; i < 4 * 400; ++i) {
        const WorldPos at = place_beside_way(dice, i % 2, i / 2 % 2);
        all.push_back({.shape = gaussian, .centre = at, .radius_m = dice.within(0.5, 2)});
        all.back().amplitude_m = dice.within(-0.2, -0.05);
        all.back().rule = StampRule::Min;  // so that none gets deeper than it is
    }
}

}  // namespace

const char* name_of(Dents dents) {
    switch (dents) {
        case Dents::None:
            return "untouched";
        case Dents::Trail:
            return "trail";
        case Dents::Dense:
            return "dense";
    }
    return "";
}

std::shared_ptr<const HeightSource> reference_heights() {
    static const std::shared_ptr<const HeightSource> made =
        make_ridged_source({.seed = 7, .size = kReferencePosts, .relief_m = 40});
    return made;
}

std::unique_ptr<Terrain> reference_terrain(std::string shader_folder) {
    TerrainSettings settings{.executor = ExecutorKind::Cpu, .shader_folder = std::move(shader_folder)};
    settings.ground = {.spacing_m = kReferenceSpacing_m, .texels_per_post = 3, .tile_size = 2048};
    return value(Terrain::create(reference_heights(), settings, get_proc()));
}

ShapeId bake_boot(ShapeLibrary& shapes) {
    // As wide as the print is with its rim; weight -1 is its rim's height over its depth.
    return value(shapes.bake("boot", 128, [](double x, double z) {
        return std::clamp(-test::boot_print_m(x * 0.17, z * 0.17) / 0.03, -1.0, 1.0);
    }));
}

std::vector<StampRequest> dents_of(Dents dents, ShapeId boot) {
    std::vector<StampRequest> all;
    if (dents == Dents::None) return all;
    Dice dice;
    add_stamps(all, dice, boot);
    if (dents == Dents::Dense) add_dense_stamps(all, dice);
    for (int i = 0; i < 80; ++i) {
        const WorldPos at = walk_place(i / 80.0);
        const double aside_m = i % 2 == 0 ? 0.13 : -0.13;
        all.push_back({.shape = boot,
                       .centre = {at.x - aside_m * kAlong, at.z + aside_m * kAlong},
                       .radius_m = 0.17,
                       .amplitude_m = -0.03,
                       .rotation_rad = kHeading_rad,
                       .mirror = i % 2 != 0});
    }
    std::uint32_t key = 0;
    for (StampRequest& request : all) request.map = MapChoice::Detail, request.key = ++key;
    return all;
}

void make_dents(Terrain& terrain, Dents dents) {
    const ShapeId boot = bake_boot(terrain.shapes());
    const WorldPos corner{kCorner_m, kCorner_m};
    terrain.set_viewers({&corner, 1});
    check(terrain.update(0));
    check(terrain.drain());
    for (const StampRequest& request : dents_of(dents, boot)) static_cast<void>(value(terrain.stamp(request)));
    check(terrain.update(0));
    check(terrain.drain());
}

WorldPos walk_place(double share) {
    const double from_corner_m = (share - 0.5) * kWalk_m;
    return {kCorner_m + kAlong * from_corner_m, kCorner_m + kAlong * from_corner_m};
}

View walk_view(const Ground& ground, WorldPos place) {
    return {.eye = {place.x, ground.height_m(place, MapSelect::Coarse) + 2, place.z},
            .forward = {kAlong, -0.15, kAlong},
            .fov_y_rad = std::numbers::pi / 2,
            .near_m = 0.1,
            .far_m = 1000};
}

std::uint64_t hash_of(Terrain& terrain) {
    const StateHash state = value(terrain.hash());
    const std::uint64_t both[] = {state.coarse, state.detail};
    return hash_bytes(std::as_bytes(std::span(both)));
}

// ---- shader folders ----

ShaderOverlay::ShaderOverlay(const std::string& name) {
    namespace fs = std::filesystem;
    const std::string own = text("tilth-bench-", name, "-", static_cast<std::int64_t>(std::random_device{}()));
    folder_ = (fs::temp_directory_path() / own).string();
    constexpr auto how = fs::copy_options::recursive | fs::copy_options::overwrite_existing;
    fs::copy(TILTH_SOURCE_DIR "/shaders", folder_, how);
    fs::copy(TILTH_SOURCE_DIR "/benchmarks/render/shaders/" + name, folder_, how);
}

ShaderOverlay::~ShaderOverlay() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

}  // namespace tilth::bench
