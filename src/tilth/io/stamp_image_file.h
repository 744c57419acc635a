// Stamp images from files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tilth/core/result.h"

namespace tilth::io {

/// A grey image of weights: 65 535 is weight 1, 0 is weight 0. Row by row; a column is +x, a row +z of the stamp.
struct StampImageData {
    std::int32_t width = 0, height = 0;
    std::vector<std::uint16_t> texels;
};

/// Longest side of a stamp image, texels.
inline constexpr std::int32_t kMaxStampSide = 4096;

struct StampImageOptions {
    /// 8-bit images have 256 weights: a stamp 0.5 m deep gets steps of 2 mm. Values are widened by 257 exactly.
    bool allow_8bit = false;
};

/// Reads a PNG or TIFF with 16-bit unsigned samples, one channel or several equal ones without alpha. The data is
/// linear: colour-space and gamma notes in the file are ignored. Any size from 1 x 1 to kMaxStampSide a side.
/// Fails with `NotFound` or `FileFormat`; the message names the file, what is wrong and what is allowed.
Result<StampImageData> read_stamp_image(const std::string& path, const StampImageOptions& options = {});

}  // namespace tilth::io
