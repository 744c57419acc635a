// The facade's side of the relief window: what fills it, when, and where there is detail.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "tilth/cache/tile_cache.h"
#include "tilth/core/result.h"
#include "tilth/derive/relief_pass.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gpu_tiles.h"
#include "tilth/ground/ground.h"
#include "tilth/pool/relief_window.h"
#include "tilth/render/detail_view.h"

namespace tilth {

/// Keeps a window of detail heights about one eye, while a backend asks for it. It exists only as long: with backend
/// none there is neither texture nor program.
/// One window: two viewers drawn in turn more than a window apart fill it again each time.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class ReliefStage final : public ReliefBounds {
public:
    ReliefStage(gl::Device& device, gl::ShaderLibrary& shaders, const Ground& ground, const TileCache& cache,
                GpuTiles& textures, SlopeFormat slopes);
    ~ReliefStage() override;
    ReliefStage(const ReliefStage&) = delete;
    ReliefStage& operator=(const ReliefStage&) = delete;

    /// Brings the window about `eye` up to date; `size`: texels a side. A pass or none for each of its textures'
    /// levels; counted in `stats.derive`. Fails with OutOfMemory, ShaderCompile or Unsupported: asked for again next
    /// time.
    Result<ReliefView> update(WorldPos eye, std::int32_t size, gl::FrameStats& stats);

    [[nodiscard]] CodeRange query(const TexelRect& rect) const override;
    [[nodiscard]] std::uint64_t bytes() const { return window_ ? window_->bytes() : 0; }
    Result<void> reload(gl::ShaderLibrary& shaders);

private:
    /// A tile as the window was last filled from it.
    struct Source {
        TileIndex tile;
        std::uint64_t texture = 0;  ///< serial
        friend bool operator==(const Source&, const Source&) = default;
    };
    Result<void> make(std::int32_t size, gl::StageStats& derive);
    [[nodiscard]] std::vector<Source> sources_in(const TexelRect& square) const;
    [[nodiscard]] CodeRange range_of_page(PageIndex page) const;

    gl::Device* device_;
    gl::ShaderLibrary* shaders_;
    const Ground* ground_;
    const TileCache* cache_;
    GpuTiles* textures_;
    SlopeFormat slopes_;
    std::optional<ReliefPass> pass_;
    std::optional<ReliefWindow> window_;
    std::optional<TexelRect> square_;  ///< what the window shows; empty: nothing yet
    bool all_stale_ = false;
    std::vector<Source> sources_;                    ///< of it
    mutable std::map<PageIndex, CodeRange> ranges_;  ///< of pages of the field, as far as somebody asked
};

}  // namespace tilth
