// The facade's side of the detail map: cache, textures, budget and clock.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tilth/cache/tile_cache.h"
#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gpu_tiles.h"
#include "tilth/ground/ground.h"
#include "tilth/relief_stage.h"
#include "tilth/render/detail_view.h"
#include "tilth/store/memory_store.h"
#include "tilth/terrain.h"

namespace tilth {

/// Detail tiles of a terrain that draws. A frame is `begin`, `apply`, `transfer`, then `view_from` for each draw.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`, except while `uses_gl` is
/// false and nothing is stamped.
class DetailStage {
public:
    /// Makes no texture: they wait for the first stamp. `deformer`: of executor gpu, else nullptr. Fails with
    /// InvalidArgument (band, apron, a memory bound below four tiles) or the store's error.
    static Result<std::unique_ptr<DetailStage>> create(gl::Device& device, gl::ShaderLibrary& shaders, Ground& ground,
                                                       const TerrainSettings& settings, Deformer* deformer);

    void set_viewers(std::span<const WorldPos> viewers);
    /// The only viewer, until `set_viewers` was called.
    void set_default_viewer(WorldPos eye);

    /// False on untouched ground, where a frame has nothing to do.
    [[nodiscard]] bool uses_gl() const { return !cache_->is_untouched(); }
    void begin(gl::FrameStats& stats);
    Result<void> apply(std::span<const GroundEdit> edits, gl::FrameStats& stats);
    void transfer(gl::FrameStats& stats);
    [[nodiscard]] DetailView view_from(WorldPos eye) const;
    /// The same with relief about the eye, as the settings' backend wants it; without a backend the relief window is
    /// given up. Fails like `ReliefStage::update`.
    Result<DetailView> view_from(WorldPos eye, const DetailSettings& settings, gl::FrameStats& stats);

    // Outside frames: these wait.
    Result<void> settle(gl::FrameStats& stats);
    /// The ground's detail field holds the cell about `at`, or the tiles.
    Result<void> require(WorldPos at, gl::FrameStats& stats);
    /// Whether it is there: then `require` has nothing to do, and needs no GL.
    [[nodiscard]] bool is_in_field(WorldPos at) const;
    Result<void> require(std::span<const TileIndex> tiles, gl::FrameStats& stats);
    Result<std::uint64_t> hash(gl::FrameStats& stats);
    /// See `TileCache::snapshot`.
    std::optional<std::vector<TileSnapshot>> snapshot(gl::FrameStats& stats);
    void prepare_snapshot(gl::FrameStats& stats);

    /// Tiles that a ray's shadow crosses and whose codes are not in the field, and where it enters them, metres along
    /// the normalised direction; nearest first.
    struct Ahead {
        double distance_m = 0;
        TileIndex tile;
    };
    [[nodiscard]] std::vector<Ahead> tiles_along(const Vec3d& from, const Vec3d& direction, double max_m) const;

    Result<void> reload(gl::ShaderLibrary& shaders);

    [[nodiscard]] const TileCache& cache() const { return *cache_; }
    [[nodiscard]] TileCache& cache() { return *cache_; }
    [[nodiscard]] const GpuTiles& textures() const { return *textures_; }
    [[nodiscard]] std::uint64_t tile_bytes() const { return textures_->pool().bytes(); }
    [[nodiscard]] std::uint64_t relief_bytes() const { return relief_ ? relief_->bytes() : 0; }
    /// Stamps and pages that wait for tiles to arrive, and the terrain's own store.
    [[nodiscard]] std::uint64_t waiting_bytes() const;

private:
    [[nodiscard]] std::vector<TileIndex> tiles_about(WorldPos at) const;
    DetailStage(gl::Device& device, gl::ShaderLibrary& shaders, Ground& ground, const TerrainSettings& settings,
                std::unique_ptr<GpuTiles> textures);

    gl::Device& device_;
    gl::ShaderLibrary& shaders_;
    Ground& ground_;
    SlopeFormat slopes_;
    ClipmapSettings clipmap_;
    double band_;
    FrameBudget budget_;
    std::unique_ptr<GpuTiles> textures_;
    std::shared_ptr<MemoryStore> own_store_;  ///< where the host gave none
    std::unique_ptr<TileCache> cache_;
    std::unique_ptr<ReliefStage> relief_;  ///< while a backend shows relief
    bool has_viewers_ = false;             ///< the host's own
    double began_ms_ = -1;                 ///< when the last frame began
    double transfer_ms_ = 0;               ///< of the last frame
};

}  // namespace tilth
