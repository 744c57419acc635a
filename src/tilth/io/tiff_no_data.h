// The no-data value that GDAL leaves in a GeoTIFF, which OpenImageIO does not hand on.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace tilth::io {

/// The text of tag 42113 (GDAL_NODATA) in the first directory of the TIFF or BigTIFF `file`, trimmed; nothing if the
/// tag is absent, or if the bytes are no TIFF or damaged before it is found. Never reads outside of `file`.
std::optional<std::string> gdal_no_data_text(std::span<const std::byte> file);

}  // namespace tilth::io
