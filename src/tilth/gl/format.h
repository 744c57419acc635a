// Texture formats the library uses, and what GL calls them.
#pragma once

namespace tilth::gl {

enum class Format {
    R8,
    R16,
    R16Snorm,
    R16F,
    R32F,
    R16UI,
    R32UI,
    R32I,
    Rg8,
    Rg8Snorm,
    Rg16,
    Rg16F,
    Rg32F,
    Rgba8,
    Rgba8Srgb,
    Rgba16F,
    Rgba32F,
    Rgba32I,
    Rgba32UI,
    Depth24,
    Depth32F,
};

/// How a format is stored and how its texels look in client memory (the transfer format).
struct FormatInfo {
    unsigned internal = 0;  ///< GL internal format, e.g. GL_R16
    unsigned layout = 0;    ///< GL transfer format, e.g. GL_RED
    unsigned type = 0;      ///< GL transfer type, e.g. GL_UNSIGNED_SHORT
    int components = 0;
    int transfer_bytes = 0;   ///< of one texel in client memory
    int stored_bytes = 0;     ///< of one texel in GL, as far as GL says
    bool filterable = false;  ///< linear filtering is allowed
    bool depth = false;
    const char* name = "";
};

const FormatInfo& info_of(Format format);

}  // namespace tilth::gl
