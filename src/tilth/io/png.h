// Pictures: screenshots out, golden images in, and the depth that belongs to a screenshot.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tilth/core/result.h"

namespace tilth::io {

/// An 8-bit RGB picture, top row first, 3 bytes a pixel, as stored (no colour transform).
struct Rgb8Picture {
    std::int32_t width = 0, height = 0;
    std::vector<std::uint8_t> pixels;
};

/// Writes an 8-bit PNG, not interlaced, top row first; `pixels` has width * height * 3 (or 4) bytes. Alpha is stored
/// as it is, not multiplied into the colour. Errors as in height_writer.h. 1 600 x 900 takes about 0.1 s.
Result<void> write_png_rgb8(const std::string& path, std::int32_t width, std::int32_t height,
                            std::span<const std::uint8_t> pixels);
Result<void> write_png_rgba8(const std::string& path, std::int32_t width, std::int32_t height,
                             std::span<const std::uint8_t> pixels);

/// Reads an 8-bit RGB or RGBA PNG (alpha is dropped). Fails as `read_heights` does; other types are `FileFormat`.
Result<Rgb8Picture> read_png_rgb8(const std::string& path);

/// Writes one float a pixel (depth, in whatever unit the caller has) as the channel "Z" of an OpenEXR file, top row
/// first. Fails with `InvalidArgument` unless the path ends in .exr.
Result<void> write_depth_exr(const std::string& path, std::int32_t width, std::int32_t height,
                             std::span<const float> depth);

}  // namespace tilth::io
