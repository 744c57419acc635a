// Heights to partial-derivative maps, over dirty rectangles only.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/derive/slope_rects.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/texel_pass.h"
#include "tilth/gl/texture_copy.h"
#include "tilth/ground/height_field.h"
#include "tilth/pool/code_view.h"
#include "tilth/pool/height_planes.h"
#include "tilth/pool/slope_map.h"

namespace tilth {

/// What turns codes into slopes, metres per metre.
struct SlopeSettings {
    SlopeStencil stencil = SlopeStencil::Central;
    double code_quantum_m = 0;  ///< `HeightCodec::code_quantum_m`
    double spacing_m = 1;       ///< between posts
};

/// Codes, the slopes to derive from them (of the same texels), and what changed in them: texels of the map.
struct SlopeTarget {
    const HeightPlanes* planes = nullptr;
    SlopeMap* slopes = nullptr;
    std::span<const TexelRect> changed;
};

/// Recomputes the slopes that changed heights make stale, on the GPU, from the height planes.
///
/// One map: one pass a mip level, whatever the number of rectangles; mips are sub-sampled, not filtered. Several tiles
/// at once: their slopes are drawn side by side into a scratch texture and copied, because a draw and a copy cost less
/// than another framebuffer. With nothing changed it does nothing at all. Slopes are always a function of the heights,
/// never accumulated.
/// Differences are one-sided at the map's border only. Of a tile, slopes whose stencil leaves what it holds are not
/// written (`derivable_slopes`): with an apron of `stencil_reach` + 1 the interior and one texel around it are right.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class SlopePass {
public:
    static Result<SlopePass> create(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                    SlopeFormat format, const SlopeSettings& settings);

    /// `changed`: texels of the map. `derive` counts level 0, `mips` the levels above.
    void run(std::span<const TexelRect> changed, const HeightPlanes& planes, SlopeMap& slopes, gl::StageStats& derive,
             gl::StageStats& mips);
    /// Tiles of one map, of one level each. Where the scratch is refused: a pass a tile, counted as fallback.
    void run(std::span<const SlopeTarget> tiles, gl::StageStats& derive);

    /// Reads the shader again; on failure the last good one stays in use.
    Result<void> reload(gl::ShaderLibrary& shaders) { return shaders.reload(pass_.program()); }

    /// Of the scratch texture; 0 before several tiles changed at once.
    [[nodiscard]] std::uint64_t bytes() const { return scratch_ ? scratch_->bytes() : 0; }

private:
    SlopePass(gl::Device& device, gl::TexelPass pass, gl::TextureCopy copy, SlopeFormat format,
              const SlopeSettings& settings);
    void set_up(const TexelRect& map, std::int32_t level);
    void read_from(const HeightPlanes& planes);
    /// The stale slopes of a target, disjoint, clipped to what it holds.
    [[nodiscard]] std::vector<TexelRect> stale(const SlopeTarget& target) const;
    bool reserve_scratch(std::int32_t width, std::int32_t depth);

    gl::Device* device_;
    gl::TexelPass pass_;
    gl::TextureCopy copy_;
    SlopeFormat format_;
    SlopeSettings settings_;
    std::optional<gl::Texture2D> scratch_;
};

/// The same on the CPU, uploaded to the same texture: for the CPU executor. Values agree with the GPU's to one step of
/// the storage. `codes` covers the stale slopes that `slopes`, of the map `map`, holds, and the stencil's reach around
/// them as far as the map goes. Counts bytes of the slopes in `derive` and of the mips in `mips`, no passes.
void upload_slopes(std::span<const TexelRect> changed, const CodeView& codes, const TexelRect& map,
                   const SlopeSettings& settings, SlopeMap& slopes, gl::StageStats& derive, gl::StageStats& mips,
                   gl::TransferStats& transfer);
/// Of a whole dense map.
inline void upload_slopes(std::span<const TexelRect> changed, const HeightField& heights, const SlopeSettings& settings,
                          SlopeMap& slopes, gl::StageStats& derive, gl::StageStats& mips, gl::TransferStats& transfer) {
    upload_slopes(changed, heights, heights.rect(), settings, slopes, derive, mips, transfer);
}

/// Bytes of a slope as `format` stores it.
constexpr std::size_t slope_bytes(SlopeFormat format) { return format == SlopeFormat::rg8 ? 2 : 4; }

/// The slopes of `texels` of a map as `format` stores them, row by row without gaps, to `out`
/// (texels.count() * slope_bytes). `codes` as in `upload_slopes`.
void store_slopes(const TexelRect& texels, const CodeView& codes, const TexelRect& map, const SlopeSettings& settings,
                  SlopeFormat format, void* out);

/// Slope (dh/dx, dh/dz) at a texel, metres per metre: the formula of both executors.
struct Slope {
    float x = 0, z = 0;
};
/// Neighbours beyond `codes` repeat its outermost ones; differences are one-sided at the border of `map`.
Slope slope_at(const CodeView& codes, const TexelRect& map, Texel texel, const SlopeSettings& settings);
inline Slope slope_at(const HeightField& heights, Texel post, const SlopeSettings& settings) {
    return slope_at(heights, heights.rect(), post, settings);
}

}  // namespace tilth
