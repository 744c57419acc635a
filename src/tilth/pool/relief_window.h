// Detail heights about the viewer in one texture, whatever tiles they come from: what the detail backends read.
#pragma once

#include <cstdint>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/objects.h"
#include "tilth/pool/slope_map.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Textures over a square of detail texels that follows the viewer. Texel (i, j) of the map lies at (i mod size,
/// j mod size), so moving the square touches only what came in, a ray needs no look at borders of tiles, and linear
/// filtering goes on across the seam (wrap is repeat). The content follows from the tiles' codes and slopes; it is for
/// the eye only, and nothing persistent reads it.
///
///   heights   R32F    metres of detail, exactly 0 on untouched ground; linear filtering
///   slopes    RG8 companded or RG16F, as the tiles' (pool/slope_map.h); linear filtering
///   pyramid   RG32F   (highest, lowest) metre in nodes of 2^(l+1) x 2^(l+1) cells at level l: the texels from the
///                     node's first to the next node's first, both included, so that the surface within a node's cells
///                     never leaves the range; nearest filtering, `kLevels` levels
///   range     RG32F   (highest, lowest) of 3 x 3 nodes of the coarsest level, linear filtering: what a ray at a texel
///                     may meet within 32 texels at least; texel of the texture = coarsest node
/// Memory: 9 to 11 bytes a texel of the square. Content is 0 everywhere from the beginning: never NaN.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class ReliefWindow {
public:
    static constexpr std::int32_t kLevels = 6;     ///< of the pyramid
    static constexpr std::int32_t kTopCells = 64;  ///< cells a side of a node of its coarsest level: 2^kLevels
    static constexpr std::int32_t kLeastSize = 256, kMostSize = 4096;

    /// `size`: texels a side, a power of two in [kLeastSize, kMostSize]. Fails with InvalidArgument (size), OutOfMemory
    /// or Unsupported.
    static Result<ReliefWindow> create(gl::Device& device, std::int32_t size, SlopeFormat format);

    [[nodiscard]] std::int32_t size() const { return heights_.width(); }
    [[nodiscard]] SlopeFormat format() const { return format_; }
    [[nodiscard]] const gl::Texture2D& heights() const { return heights_; }
    [[nodiscard]] const gl::Texture2D& slopes() const { return slopes_; }
    [[nodiscard]] const gl::Texture2D& pyramid() const { return pyramid_; }
    [[nodiscard]] const gl::Texture2D& range() const { return range_; }
    [[nodiscard]] gl::Texture2D& pyramid() { return pyramid_; }
    [[nodiscard]] std::uint64_t bytes() const {
        return heights_.bytes() + slopes_.bytes() + pyramid_.bytes() + range_.bytes();
    }

private:
    ReliefWindow(gl::Texture2D heights, gl::Texture2D slopes, gl::Texture2D pyramid, gl::Texture2D range,
                 SlopeFormat format);
    gl::Texture2D heights_, slopes_, pyramid_, range_;
    SlopeFormat format_;
};

}  // namespace tilth
