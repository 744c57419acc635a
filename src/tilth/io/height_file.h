// Height maps from files: PNG, TIFF, GeoTIFF, OpenEXR, and raw .r16 / .r32f.
#pragma once

#include <optional>

#include "tilth/source/height_source.h"

namespace tilth::io {

struct HeightFileOptions {
    /// 8-bit images have 256 heights: 40 m of relief become steps of 16 cm, which no later filter takes away again.
    bool allow_8bit = false;

    /// The stored value that means "no height here"; NaN is allowed. Wins over the file's own (GDAL_NODATA in a
    /// GeoTIFF, `no_data` in a sidecar). No value is ever guessed to be one.
    std::optional<double> no_data;

    /// Height given to posts without data, metres, finite. Without it, a file with such posts is refused.
    std::optional<double> no_data_replacement_m;

    /// height = stored value * scale + offset. Each one wins over the file's own; the default is 1 and 0: a 16-bit
    /// file holds whole metres. Not allowed for .r16, whose range stands in its sidecar. scale is not 0.
    std::optional<double> scale_m;
    std::optional<double> offset_m;
};

/// Reads the heights of `path`. The first row of the file is z = 0, a row runs along +x.
///
/// - PNG, TIFF, GeoTIFF (told by content, not by name): 16-bit unsigned or signed, 32-bit float; OpenEXR: half, float.
///   One channel, or several without alpha that are all equal. Only the first image of a file is read.
///   A description that starts with "tilth:" gives scale and offset: "tilth: scale=0.0127 offset=249", in the TIFF tag
///   ImageDescription or the PNG text Description; our writers write it, and what follows (a source) is ignored.
/// - `.r16`, `.r32f`, told by the name: as their sidecar says (RAW_SIDECAR.md).
///
/// Fails, always with the file's name: `NotFound`; `FileFormat` for damage, wrong type, 8 bits unless allowed,
/// channels that differ, sides above 16 384 or claims beyond the file's size (both before memory is taken), no-data
/// without replacement (count and first texel), NaN or infinity (texel); `InvalidArgument` for options, and for sides
/// below 2.
/// Cost: about 8 bytes a post while reading, 4 afterwards. Any thread; blocks on the disk.
Result<std::unique_ptr<HeightSource>> read_heights(const std::string& path, const HeightFileOptions& options = {});

}  // namespace tilth::io
