// Heights, codes and slopes into files: images, raw files with their sidecar, and CSV.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tilth/io/height_encoding.h"
#include "tilth/world/grid.h"

// All writers: arrays lie row by row, the first row is z = 0, a row runs along +x. A file appears under its name only
// when it is complete. The ending of the path chooses the format. Any thread; they block on the disk.
// They fail with `InvalidArgument` (ending, number of values) or `FileWrite` (file system), naming the file.
namespace tilth::io {

/// 16-bit heights into .tif or .png, with the encoding in the description, where `read_heights` finds it.
Result<void> write_heights_u16(const std::string& path, std::span<const std::uint16_t> values, std::int32_t width,
                               std::int32_t depth, const HeightEncoding& encoding);

/// Floats into .tif, .exr or .r32f, exact; into .r16, quantised to 65 536 steps from the least to the greatest (which
/// must be finite). `channels` values a texel (2 for slopes), interleaved; the raw formats have one.
Result<void> write_floats(const std::string& path, std::span<const float> values, std::int32_t width,
                          std::int32_t depth, std::int32_t channels = 1);

/// Height codes into .tif (32-bit unsigned), exact; into .r16, the high plane alone (code >> 16, sidecar range 0 to
/// 65535). .exr and .r32f are refused: a float holds 24 bits of the 32.
Result<void> write_codes(const std::string& path, std::span<const std::uint32_t> codes, std::int32_t width,
                         std::int32_t depth);

/// Where the texels of a CSV file lie: texel (i, j) is written as x = first.x + spacing * i, z = first.z + spacing * j.
struct CsvFrame {
    WorldPos first;
    double spacing = 1;
};

/// One line a texel, "x,z,value", row by row; with `channels` values a texel, "x,z,value,value". No header and no
/// spaces; 17 significant digits, so every double reads back to the same bits (32-bit codes are exact as well).
Result<void> write_csv(const std::string& path, const CsvFrame& frame, std::span<const double> values,
                       std::int32_t width, std::int32_t depth, std::int32_t channels = 1);

}  // namespace tilth::io
