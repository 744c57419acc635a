// Fills the relief window from detail tiles, and derives its max-mip pyramid, over dirty rectangles only.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/derive/relief_rects.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/texel_pass.h"
#include "tilth/pool/height_planes.h"
#include "tilth/pool/relief_window.h"
#include "tilth/pool/slope_map.h"

namespace tilth {

/// A tile whose textures a window may be filled from, and the texels of the map that are to be taken from it: its
/// interior, as far as the map has it. What no source shows is untouched ground.
struct ReliefSource {
    const HeightPlanes* planes = nullptr;
    const SlopeMap* slopes = nullptr;
    TexelRect interior;
};

/// Heights are decoded from both planes to metres in R32F (a multiple of the code quantum; 24 bits of mantissa are
/// exact up to 2^-4 m at 2^-28 m, and good to a ten-millionth beyond); slopes are copied as they are stored; then each
/// level of the pyramid from the level before, and the range from the coarsest. A level is a pass over the stale nodes
/// of all rectangles together: 2 + kLevels passes however many rectangles, none for none. Thread: the one that owns the
/// context. GL state: the caller holds a `gl::StateGuard`. Never waits.
class ReliefPass {
public:
    static Result<ReliefPass> create(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                     SlopeFormat format, double code_quantum_m);

    /// Brings `changed` (map texels) up to date where they lie in `square`, the part of the map that `window` shows.
    /// Passes, texels and bytes are counted in `derive`.
    void run(std::span<const TexelRect> changed, const TexelRect& square, std::span<const ReliefSource> sources,
             ReliefWindow& window, gl::StageStats& derive);

    /// Reads the shaders again; on failure the last good ones stay in use.
    Result<void> reload(gl::ShaderLibrary& shaders);

private:
    ReliefPass(gl::TexelPass fill, gl::TexelPass pyramid, gl::TexelPass range, double code_quantum_m);
    // `texels`: disjoint texels of the map.
    void fill(std::span<const TexelRect> texels, std::span<const ReliefSource> sources, ReliefWindow& window,
              gl::StageStats& derive);
    void build_pyramid(std::span<const TexelRect> texels, ReliefWindow& window, gl::StageStats& derive);
    void build_range(std::span<const TexelRect> texels, ReliefWindow& window, gl::StageStats& derive);

    gl::TexelPass fill_, pyramid_, range_;
    double code_quantum_m_;
};

}  // namespace tilth
