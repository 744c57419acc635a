// A map's height codes on the GPU: two R16 planes.
#pragma once

#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/objects.h"
#include "tilth/ground/height_field.h"
#include "tilth/world/height_codec.h"
#include "tilth/world/texel.h"

namespace tilth {

/// The codes of one dense map as textures. Texel (i, j) of the textures is post (i, j) of the map; nearest filtering,
/// clamped, one mip level (coarser clipmap levels read every 2^l-th texel, which is the sub-sampled mip).
/// Planes: high = code >> 16, low = code & 0xffff, both R16 unorm, exact. With `bits16` there is no low plane.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class HeightPlanes {
public:
    /// Content undefined until the first upload. Fails when the size exceeds the context's texture limit.
    static Result<HeightPlanes> create(gl::Device& device, std::int32_t width, std::int32_t depth,
                                       HeightPrecision precision);

    [[nodiscard]] TexelRect rect() const { return {{0, 0}, {high().width(), high().height()}}; }
    [[nodiscard]] HeightPrecision precision() const { return precision_; }
    [[nodiscard]] const gl::Texture2D& high() const { return planes_.front(); }
    /// The high plane itself with `bits16`, so that a sampler is never unbound; shaders then ignore it.
    [[nodiscard]] const gl::Texture2D& low() const { return planes_.back(); }
    /// The planes that exist, high first: what a pass that writes codes has as its targets.
    [[nodiscard]] std::vector<const gl::Texture2D*> targets() const;

    /// Copies `rect` of `field` (the same map on the CPU) to the textures. Blocks if a queued draw still reads them on
    /// software GL: call it before the frame's first draw.
    void upload(const HeightField& field, const TexelRect& rect, gl::TransferStats& stats);

    /// Copies `rect` of the textures to `field`. Waits for the GPU: not for a frame.
    void read_back(const TexelRect& rect, HeightField& field, gl::TransferStats& stats) const;

    [[nodiscard]] std::uint64_t bytes() const;

private:
    HeightPlanes(std::vector<gl::Texture2D> planes, gl::Framebuffer reader, HeightPrecision precision);
    std::vector<gl::Texture2D> planes_;  ///< one or two
    gl::Framebuffer reader_;
    HeightPrecision precision_;
};

}  // namespace tilth
