#include "tilth/detail_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tilth/core/clock.h"
#include "tilth/ground/raycast.h"
#include "tilth/render/relief_reach.h"

namespace tilth {
namespace {

constexpr std::int32_t kMostApron = 16;
constexpr std::uint64_t kLeastSlice = 32u << 10, kMostSlice = 16u << 20;
constexpr std::uint64_t kFewestTiles = 4;  // those that a frame may sample

Error invalid(std::string message) { return {ErrorCode::InvalidArgument, std::move(message)}; }

/// Linear filtering across a border needs one slope beyond it, and that slope its stencil.
std::int32_t least_apron(SlopeStencil stencil) { return stencil_reach(stencil) + 1; }

Result<void> check(const BudgetSettings& budget) {
    const auto bad = [](double value) { return !(value >= 0 && std::isfinite(value)); };
    if (!(budget.frame_target_ms > 0) || !std::isfinite(budget.frame_target_ms))
        return invalid(text("budget: frame_target_ms ", budget.frame_target_ms, " is not above 0"));
    if (bad(budget.least_ms) || bad(budget.least_share) || bad(budget.most_ms))
        return invalid("budget: least_ms, least_share and most_ms are finite and not below 0");
    if (budget.slice_bytes < kLeastSlice || budget.slice_bytes > kMostSlice)
        return invalid(text("budget: slice_bytes ", budget.slice_bytes, " is not in ", kLeastSlice, "..", kMostSlice));
    return {};
}

}  // namespace

Result<std::unique_ptr<DetailStage>> DetailStage::create(gl::Device& device, gl::ShaderLibrary& shaders, Ground& ground,
                                                         const TerrainSettings& settings, Deformer* deformer) {
    const TileSettings& tiles = settings.tiles;
    if (!(tiles.band >= 0.02 && tiles.band <= 0.9))
        return invalid(text("band: ", tiles.band, " is not in [0.02, 0.9]"));
    if (const Result<void> checked = check(tiles.budget); !checked) return checked.error();
    const std::int32_t needed = least_apron(settings.stencil);
    if (tiles.apron != 0 && (tiles.apron < needed || tiles.apron > kMostApron))
        return invalid(text("apron: ", tiles.apron, " texels is not in ", needed, "..", kMostApron));
    const MapGeometry& map = ground.map(MapKind::Detail);
    const TileGrid grid{
        .size = ground.settings().tile_size, .apron = tiles.apron == 0 ? needed : tiles.apron, .map = map.grid.rect()};
    const std::uint64_t texel_bytes = bytes_a_texel(map.precision, settings.slopes);
    const auto side = static_cast<std::uint64_t>(grid.stored_size());
    const std::uint64_t tile_bytes = side * side * texel_bytes;
    std::size_t most_tiles = 0;
    if (tiles.most_gpu_bytes != 0) {
        most_tiles = static_cast<std::size_t>(tiles.most_gpu_bytes / tile_bytes);
        if (most_tiles < kFewestTiles)
            return invalid(text("most_gpu_bytes: ", tiles.most_gpu_bytes, " bytes hold ", most_tiles, " tiles of ",
                                tile_bytes, " bytes; at least ", kFewestTiles, " are needed (",
                                kFewestTiles * tile_bytes, " bytes), or a smaller tile_size"));
    }

    Result<std::unique_ptr<GpuTiles>> textures =
        GpuTiles::create(device, shaders, deformer,
                         {.pool = {.grid = grid,
                                   .precision = map.precision,
                                   .slopes = settings.slopes,
                                   .most_tiles = static_cast<std::int32_t>(most_tiles)},
                          .slopes = {settings.stencil, map.codec.code_quantum_m(), map.grid.spacing_m},
                          .slot_bytes = 2 * static_cast<std::size_t>(tiles.budget.slice_bytes)});
    if (!textures) return textures.error();
    std::unique_ptr<DetailStage> made(new DetailStage(device, shaders, ground, settings, std::move(*textures)));
    if (!tiles.store) made->own_store_ = std::make_shared<MemoryStore>();
    Result<std::unique_ptr<TileCache>> cache =
        TileCache::create(ground, grid, tiles.store ? tiles.store : made->own_store_, *made->textures_,
                          {.band = tiles.band,
                           .gpu_executor = deformer != nullptr,
                           .most_tiles = most_tiles,
                           .bytes_a_texel = texel_bytes,
                           .publish_changes = settings.publish_changes});
    if (!cache) return cache.error();
    made->cache_ = std::move(*cache);
    const GridSpec& posts = ground.map(MapKind::Coarse).grid;
    made->set_default_viewer(posts.world({(posts.width - 1) / 2, (posts.depth - 1) / 2}));
    return made;
}

DetailStage::DetailStage(gl::Device& device, gl::ShaderLibrary& shaders, Ground& ground,
                         const TerrainSettings& settings, std::unique_ptr<GpuTiles> textures)
    : device_(device),
      shaders_(shaders),
      ground_(ground),
      slopes_(settings.slopes),
      clipmap_(settings.clipmap),
      band_(settings.tiles.band),
      budget_(settings.tiles.budget),
      textures_(std::move(textures)) {}

void DetailStage::set_viewers(std::span<const WorldPos> viewers) {
    has_viewers_ = true;
    cache_->set_viewers(viewers);
}

void DetailStage::set_default_viewer(WorldPos eye) {
    if (!has_viewers_) cache_->set_viewers({&eye, 1});
}

// ---- a frame ----

void DetailStage::begin(gl::FrameStats& stats) {
    const double now_ms = clock_ms();
    const double rest_ms = began_ms_ < 0 ? std::numeric_limits<double>::quiet_NaN() : now_ms - began_ms_ - transfer_ms_;
    began_ms_ = now_ms;
    budget_.begin_frame(rest_ms);
    textures_->set_stats(&stats);
    textures_->begin_frame();
    const std::uint64_t down = stats.transfer.bytes_down;
    cache_->update(now_ms, stats.cache);
    if (stats.transfer.bytes_down != down)  // read-backs that were begun: the ring bounds them, the budget counts them
        budget_.spend(stats.transfer.bytes_down - down, clock_ms() - now_ms);
}

Result<void> DetailStage::apply(std::span<const GroundEdit> edits, gl::FrameStats& stats) {
    textures_->set_stats(&stats);
    // What the textures do counts its own time, slopes apart; the rest is the CPU executor's.
    const double counted_ms = stats.deform.cpu_ms + stats.derive.cpu_ms, start_ms = clock_ms();
    Result<void> applied = cache_->apply(edits, stats.deform);
    stats.deform.cpu_ms += clock_ms() - start_ms - (stats.deform.cpu_ms + stats.derive.cpu_ms - counted_ms);
    return applied;
}

void DetailStage::transfer(gl::FrameStats& stats) {
    textures_->set_stats(&stats);
    const double before_ms = stats.cache.transfer_ms;
    cache_->transfer(budget_, stats.cache, stats.deform);
    transfer_ms_ = stats.cache.transfer_ms - before_ms;
}

DetailView DetailStage::view_from(WorldPos eye) const {
    const TileGrid& grid = cache_->grid();
    const double spacing_m = ground_.map(MapKind::Detail).grid.spacing_m;
    DetailView view{.grid = grid, .spacing_m = spacing_m, .reach_m = active_reach_m(grid.size * spacing_m, band_)};
    view.window = tiles_of_viewer(grid, ground_.map(MapKind::Detail).grid.posts(eye), band_).active;
    for_each_tile(view.window, [&](TileIndex tile) {
        const TileIndex corner = view.window.min;
        if (cache_->can_be_drawn(tile))
            view.slopes[static_cast<std::size_t>((tile.z - corner.z) * 2 + tile.x - corner.x)] =
                textures_->slopes_of(tile);
    });
    return view;
}

Result<DetailView> DetailStage::view_from(WorldPos eye, const DetailSettings& settings, gl::FrameStats& stats) {
    DetailView view = view_from(eye);
    view.settings = settings;
    if (settings.backend == DetailBackend::None) {
        relief_.reset();
        return view;
    }
    if (view.empty()) return view;
    if (!relief_) relief_ = std::make_unique<ReliefStage>(device_, shaders_, ground_, *cache_, *textures_, slopes_);
    const GridSpec& posts = ground_.map(MapKind::Coarse).grid;
    const std::int32_t size =
        relief_reach(clipmap_, posts.spacing_m, ground_.settings().texels_per_post, settings.reach, view.reach_m)
            .window_texels;
    Result<ReliefView> relief = relief_->update(eye, size, stats);
    if (!relief) return relief.error();
    view.relief = *relief;
    return view;
}

Result<void> DetailStage::reload(gl::ShaderLibrary& shaders) {
    Result<void> result = textures_->reload(shaders);
    if (relief_)
        if (Result<void> reloaded = relief_->reload(shaders); !reloaded) result = std::move(reloaded);
    return result;
}

// ---- outside frames ----

Result<void> DetailStage::settle(gl::FrameStats& stats) {
    textures_->set_stats(&stats);
    return cache_->settle(stats.cache, stats.deform);
}

std::vector<TileIndex> DetailStage::tiles_about(WorldPos at) const {
    const GridSpec& map = ground_.map(MapKind::Detail).grid;
    const PostPos texels = map.posts(at);
    std::vector<TileIndex> tiles;
    if (std::isnan(texels.x) || std::isnan(texels.z)) return tiles;
    const auto cell = [](double texel, std::int32_t count) {
        return static_cast<std::int32_t>(std::floor(std::clamp(texel, 0.0, count - 2.0)));
    };
    const Texel corner{cell(texels.x, map.width), cell(texels.z, map.depth)};
    for_each_tile(tiles_of(cache_->grid(), {corner, {corner.x + 2, corner.z + 2}}),
                  [&](TileIndex index) { tiles.push_back(index); });
    return tiles;
}

bool DetailStage::is_in_field(WorldPos at) const {
    const std::vector<TileIndex> tiles = tiles_about(at);
    return std::all_of(tiles.begin(), tiles.end(), [&](TileIndex index) { return cache_->is_in_field(index); });
}

Result<void> DetailStage::require(WorldPos at, gl::FrameStats& stats) { return require(tiles_about(at), stats); }

Result<void> DetailStage::require(std::span<const TileIndex> tiles, gl::FrameStats& stats) {
    if (std::all_of(tiles.begin(), tiles.end(), [&](TileIndex index) { return cache_->is_in_field(index); })) return {};
    textures_->set_stats(&stats);
    return cache_->require(tiles, stats.cache, stats.deform);
}

Result<std::uint64_t> DetailStage::hash(gl::FrameStats& stats) {
    textures_->set_stats(&stats);
    return cache_->hash(stats.cache, stats.deform);
}

std::optional<std::vector<TileSnapshot>> DetailStage::snapshot(gl::FrameStats& stats) {
    textures_->set_stats(&stats);
    return cache_->snapshot(stats.deform);
}

void DetailStage::prepare_snapshot(gl::FrameStats& stats) {
    textures_->set_stats(&stats);
    cache_->prepare_snapshot();
}

std::vector<DetailStage::Ahead> DetailStage::tiles_along(const Vec3d& from, const Vec3d& direction,
                                                         double max_m) const {
    std::vector<Ahead> ahead;
    const double length = std::hypot(direction.x, direction.y, direction.z);
    if (!(length > 0) || !std::isfinite(length)) return ahead;
    const GridSpec& map = ground_.map(MapKind::Detail).grid;
    const PostPos start = map.posts({from.x, from.z});
    for (const TileIndex tile : cache_->touched()) {
        // Cells about the tile's texels: one more on each side.
        const TexelRect rect = expanded(cache_->grid().interior(tile), 1);
        double begin = 0, end = max_m;
        clip_ray(start.x, direction.x / length / map.spacing_m, rect.min.x, rect.max.x, begin, end);
        clip_ray(start.z, direction.z / length / map.spacing_m, rect.min.z, rect.max.z, begin, end);
        if (begin <= end) ahead.push_back({begin, tile});
    }
    std::sort(ahead.begin(), ahead.end(), [](const Ahead& a, const Ahead& b) { return a.distance_m < b.distance_m; });
    return ahead;
}

std::uint64_t DetailStage::waiting_bytes() const {
    return cache_->waiting_bytes() + (own_store_ ? own_store_->bytes() : 0);
}

}  // namespace tilth
