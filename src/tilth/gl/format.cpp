#include "tilth/gl/format.h"

#include <array>

#include "tilth/core/checks.h"
#include "tilth/gl/api.h"

namespace tilth::gl {
namespace {

// In the order of `Format`.
constexpr std::array kFormats{
    FormatInfo{GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 1, 1, true, false, "R8"},
    FormatInfo{GL_R16, GL_RED, GL_UNSIGNED_SHORT, 1, 2, 2, true, false, "R16"},
    FormatInfo{GL_R16_SNORM, GL_RED, GL_SHORT, 1, 2, 2, true, false, "R16_SNORM"},
    FormatInfo{GL_R16F, GL_RED, GL_HALF_FLOAT, 1, 2, 2, true, false, "R16F"},
    FormatInfo{GL_R32F, GL_RED, GL_FLOAT, 1, 4, 4, true, false, "R32F"},
    FormatInfo{GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, 1, 2, 2, false, false, "R16UI"},
    FormatInfo{GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 1, 4, 4, false, false, "R32UI"},
    FormatInfo{GL_R32I, GL_RED_INTEGER, GL_INT, 1, 4, 4, false, false, "R32I"},
    FormatInfo{GL_RG8, GL_RG, GL_UNSIGNED_BYTE, 2, 2, 2, true, false, "RG8"},
    FormatInfo{GL_RG8_SNORM, GL_RG, GL_BYTE, 2, 2, 2, true, false, "RG8_SNORM"},
    FormatInfo{GL_RG16, GL_RG, GL_UNSIGNED_SHORT, 2, 4, 4, true, false, "RG16"},
    FormatInfo{GL_RG16F, GL_RG, GL_HALF_FLOAT, 2, 4, 4, true, false, "RG16F"},
    FormatInfo{GL_RG32F, GL_RG, GL_FLOAT, 2, 8, 8, true, false, "RG32F"},
    FormatInfo{GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 4, 4, true, false, "RGBA8"},
    FormatInfo{GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 4, 4, true, false, "SRGB8_ALPHA8"},
    FormatInfo{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 4, 8, 8, true, false, "RGBA16F"},
    FormatInfo{GL_RGBA32F, GL_RGBA, GL_FLOAT, 4, 16, 16, true, false, "RGBA32F"},
    FormatInfo{GL_RGBA32I, GL_RGBA_INTEGER, GL_INT, 4, 16, 16, false, false, "RGBA32I"},
    FormatInfo{GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 4, 16, 16, false, false, "RGBA32UI"},
    FormatInfo{GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, 1, 4, 4, true, true, "DEPTH_COMPONENT24"},
    FormatInfo{GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 1, 4, 4, true, true, "DEPTH_COMPONENT32F"},
};
static_assert(kFormats.size() == static_cast<std::size_t>(Format::Depth32F) + 1);

}  // namespace

const FormatInfo& info_of(Format format) {
    TILTH_ASSERT(static_cast<std::size_t>(format) < kFormats.size(), "not a Format");
    return kFormats[static_cast<std::size_t>(format)];
}

}  // namespace tilth::gl
