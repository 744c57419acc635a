// Heights to partial-derivative maps, over dirty rectangles only.
#pragma once

#include <span>

#include "tilth/core/result.h"
#include "tilth/derive/slope_rects.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/texel_pass.h"
#include "tilth/ground/height_field.h"
#include "tilth/pool/height_planes.h"
#include "tilth/pool/slope_map.h"

namespace tilth {

/// What turns codes into slopes, metres per metre.
struct SlopeSettings {
    SlopeStencil stencil = SlopeStencil::Central;
    double code_quantum_m = 0;  ///< `HeightCodec::code_quantum_m`
    double spacing_m = 1;       ///< between posts
};

/// Recomputes the slopes that changed heights make stale, on the GPU, from the height planes.
/// One pass a mip level, whatever the number of rectangles; mips are sub-sampled, not filtered. With nothing changed it
/// does nothing at all. Slopes are always a function of the heights, never accumulated.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class SlopePass {
public:
    static Result<SlopePass> create(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                    SlopeFormat format, const SlopeSettings& settings);

    /// `changed`: rectangles of posts. `derive` counts level 0, `mips` the levels above.
    void run(std::span<const TexelRect> changed, const HeightPlanes& planes, SlopeMap& slopes, gl::StageStats& derive,
             gl::StageStats& mips);

    /// Reads the shader again; on failure the last good one stays in use.
    Result<void> reload(gl::ShaderLibrary& shaders) { return shaders.reload(pass_.program()); }

private:
    SlopePass(gl::TexelPass pass, const SlopeSettings& settings) : pass_(std::move(pass)), settings_(settings) {}
    gl::TexelPass pass_;
    SlopeSettings settings_;
};

/// The same on the CPU, uploaded to the same texture: for the CPU executor. Values agree with the GPU's to one step of
/// the storage. Counts bytes of the slopes in `derive` and of the mips in `mips`, no passes.
void upload_slopes(std::span<const TexelRect> changed, const HeightField& heights, const SlopeSettings& settings,
                   SlopeMap& slopes, gl::StageStats& derive, gl::StageStats& mips, gl::TransferStats& transfer);

/// Slope (dh/dx, dh/dz) at a post of a dense map, metres per metre: the formula of both executors.
struct Slope {
    float x = 0, z = 0;
};
Slope slope_at(const HeightField& heights, Texel post, const SlopeSettings& settings);

}  // namespace tilth
