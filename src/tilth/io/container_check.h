// Lengths that a PNG or OpenEXR file states about its own parts, checked before a decoder believes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace tilth::io {

/// What is wrong with the lengths in a PNG (chunks, the closing one included) or OpenEXR file (header attributes, the
/// sides of the data window), or nothing. The decoders take memory for what a length says before they find that the
/// file ends: one flipped bit costs gigabytes. TIFF needs no such check, libtiff makes it. Other bytes: nothing.
/// `max_side`: of an image, texels. Never reads outside of `file`.
std::optional<std::string> wrong_length(std::span<const std::byte> file, std::int64_t max_side);

}  // namespace tilth::io
