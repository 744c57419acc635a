// A map's partial derivatives on the GPU, with sub-sampled mips.
#pragma once

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/objects.h"
#include "tilth/world/texel.h"

namespace tilth {

/// How slopes are stored. Errors in degrees rms for normals spread evenly up to slopes of 60 degrees.
enum class SlopeFormat : std::uint8_t {
    rg8,    ///< p / (1 + |p|) in two bytes: 0.28 degrees, cliffs saturate without turning
    rg16f,  ///< p as half floats: about 0.02 degrees, twice the memory
};

/// dh/dx and dh/dz at every post, metres per metre, in (R, G).
/// Mip level l, texel (i, j) is the slope at post (i << l, j << l): sub-sampled, so that a clipmap level shades with
/// the posts it draws. Level 0's size is padded to a multiple of 2^(levels - 1): texture coordinate of post p at level
/// l is (p / 2^l + 0.5) / (padded size >> l). Linear filtering within a level, clamped.
class SlopeMap {
public:
    static constexpr std::int32_t kLevels = 8;

    /// Flat until the slope pass has run. Fails when the size exceeds the context's limit or cannot be drawn to.
    static Result<SlopeMap> create(gl::Device& device, std::int32_t width, std::int32_t depth, SlopeFormat format);

    [[nodiscard]] TexelRect rect() const { return {{0, 0}, {width_, depth_}}; }
    [[nodiscard]] SlopeFormat format() const { return format_; }
    [[nodiscard]] gl::Texture2D& texture() { return texture_; }
    [[nodiscard]] const gl::Texture2D& texture() const { return texture_; }
    [[nodiscard]] std::int32_t padded_width() const { return texture_.width(); }
    [[nodiscard]] std::int32_t padded_depth() const { return texture_.height(); }
    [[nodiscard]] std::uint64_t bytes() const;

private:
    SlopeMap(gl::Texture2D texture, std::int32_t width, std::int32_t depth, SlopeFormat format);
    gl::Texture2D texture_;
    std::int32_t width_, depth_;
    SlopeFormat format_;
};

}  // namespace tilth
