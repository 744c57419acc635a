// Height codes on the GPU: two R16 planes over a rectangle of a map.
#pragma once

#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/objects.h"
#include "tilth/ground/height_field.h"
#include "tilth/pool/code_view.h"
#include "tilth/pool/texture_fill.h"
#include "tilth/world/height_codec.h"
#include "tilth/world/texel.h"

namespace tilth {

/// What planes hold.
struct PlanesSpec {
    std::string_view label = "coarse heights";
    TexelRect rect;  ///< texels of the map that the textures have; a tile's apron may reach beyond the map
    TexelRect map;   ///< the whole map
    HeightPrecision precision = HeightPrecision::bits32;
};

/// The codes of a dense map, or of one tile of a map, as textures. Texel (0, 0) of the textures is texel `rect().min`
/// of the map; nearest filtering, clamped, one mip level (coarser clipmap levels read every 2^l-th texel, which is the
/// sub-sampled mip).
/// Planes: high = code >> 16, low = code & 0xffff, both R16 unorm, exact. With `bits16` there is no low plane.
/// All rectangles are texels of the map.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class HeightPlanes {
public:
    /// Content undefined until the first upload or `clear`. Fails when the size exceeds the context's texture limit
    /// (InvalidArgument), or with OutOfMemory.
    static Result<HeightPlanes> create(gl::Device& device, const PlanesSpec& spec);
    /// A whole coarse map.
    static Result<HeightPlanes> create(gl::Device& device, std::int32_t width, std::int32_t depth,
                                       HeightPrecision precision) {
        const TexelRect whole{{0, 0}, {width, depth}};
        return create(device, {.rect = whole, .map = whole, .precision = precision});
    }

    [[nodiscard]] TexelRect rect() const {
        return {origin_, {origin_.x + high().width(), origin_.z + high().height()}};
    }
    [[nodiscard]] Texel origin() const { return origin_; }
    [[nodiscard]] const TexelRect& map() const { return map_; }
    /// The texels of the map that the textures have: `rect()` without what lies beyond the map.
    [[nodiscard]] TexelRect held() const { return intersection(rect(), map_); }
    [[nodiscard]] HeightPrecision precision() const { return precision_; }
    [[nodiscard]] const gl::Texture2D& high() const { return planes_.front(); }
    [[nodiscard]] gl::Texture2D& high() { return planes_.front(); }
    /// The high plane itself with `bits16`, so that a sampler is never unbound; shaders then ignore it.
    [[nodiscard]] const gl::Texture2D& low() const { return planes_.back(); }
    [[nodiscard]] gl::Texture2D& low() { return planes_.back(); }
    /// The planes that exist, high first: what a pass that writes codes has as its targets.
    [[nodiscard]] std::vector<const gl::Texture2D*> targets() const;

    /// The same textures for another part of the map; their content stays.
    void move_to(Texel origin) { origin_ = origin; }
    /// Every texel becomes the code of untouched detail, 2^31; on the GPU, exact.
    void clear(TextureFill& fill);

    /// Copies `rect`, a part of `rect()` and of `codes.rect`, to the textures. Blocks if a queued draw still reads them
    /// on software GL: call it before the frame's first draw.
    void upload(const CodeView& codes, const TexelRect& rect, gl::TransferStats& stats);

    /// Copies `rect`, a part of `rect()`, to `out`, rows `stride` codes apart. Waits for the GPU: not for a frame.
    void read_back(const TexelRect& rect, std::uint32_t* out, std::size_t stride, gl::TransferStats& stats) const;
    /// The same to the same texels of a dense map.
    void read_back(const TexelRect& rect, HeightField& field, gl::TransferStats& stats) const;

    [[nodiscard]] std::uint64_t bytes() const;

private:
    HeightPlanes(std::vector<gl::Texture2D> planes, gl::Framebuffer reader, const PlanesSpec& spec);
    std::vector<gl::Texture2D> planes_;  ///< one or two
    gl::Framebuffer reader_;
    Texel origin_;
    TexelRect map_;
    HeightPrecision precision_;
};

}  // namespace tilth
