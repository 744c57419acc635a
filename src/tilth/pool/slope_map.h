// Partial derivatives on the GPU over a rectangle of a map, with sub-sampled mips.
#pragma once

#include <string_view>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/objects.h"
#include "tilth/pool/texture_fill.h"
#include "tilth/world/texel.h"

namespace tilth {

/// How slopes are stored. Errors in degrees rms for normals spread evenly up to slopes of 60 degrees.
enum class SlopeFormat : std::uint8_t {
    rg8,    ///< p / (1 + |p|) in two bytes: 0.28 degrees, cliffs saturate without turning
    rg16f,  ///< p as half floats: about 0.02 degrees, twice the memory
};

/// What a slope map holds.
struct SlopeSpec {
    std::string_view label = "coarse slopes";
    TexelRect rect;  ///< texels of the map; a tile's stored rectangle
    SlopeFormat format = SlopeFormat::rg8;
    std::int32_t levels = 8;  ///< 8 for the coarse map, 1 for a tile, whose texture is then not padded
};

/// dh/dx and dh/dz at every texel of the map, metres per metre, in (R, G).
/// Mip level l, texel (i, j) is the slope at `rect().min` + (i << l, j << l): sub-sampled, so that a clipmap level
/// shades with the posts it draws. Level 0's size is padded to a multiple of 2^(levels - 1): texture coordinate of post
/// p of the coarse map at level l is (p / 2^l + 0.5) / (padded size >> l). Linear filtering within a level, clamped.
class SlopeMap {
public:
    static constexpr std::int32_t kLevels = 8;  ///< of the coarse map

    /// Flat until the slope pass has run. Fails when the size exceeds the context's limit or cannot be drawn to, or
    /// with OutOfMemory.
    static Result<SlopeMap> create(gl::Device& device, const SlopeSpec& spec);
    /// Of a whole coarse map.
    static Result<SlopeMap> create(gl::Device& device, std::int32_t width, std::int32_t depth, SlopeFormat format) {
        return create(device, {.rect = {{0, 0}, {width, depth}}, .format = format, .levels = kLevels});
    }

    [[nodiscard]] TexelRect rect() const { return {origin_, {origin_.x + width_, origin_.z + depth_}}; }
    [[nodiscard]] Texel origin() const { return origin_; }
    [[nodiscard]] SlopeFormat format() const { return format_; }
    [[nodiscard]] std::int32_t levels() const { return texture_.levels(); }
    [[nodiscard]] gl::Texture2D& texture() { return texture_; }
    [[nodiscard]] const gl::Texture2D& texture() const { return texture_; }
    [[nodiscard]] std::int32_t padded_width() const { return texture_.width(); }
    [[nodiscard]] std::int32_t padded_depth() const { return texture_.height(); }
    [[nodiscard]] std::uint64_t bytes() const;

    /// The same texture for another part of the map; its content stays.
    void move_to(Texel origin) { origin_ = origin; }
    /// Every texel of every level, padding included, becomes flat; on the GPU, exact.
    void clear(TextureFill& fill);

private:
    SlopeMap(gl::Texture2D texture, const SlopeSpec& spec);
    gl::Texture2D texture_;
    Texel origin_;
    std::int32_t width_, depth_;
    SlopeFormat format_;
};

}  // namespace tilth
