// The shader files that the build put into the library (cmake/EmbedShaders.cmake).
#pragma once

#include <span>
#include <string_view>

namespace tilth::gl {

struct EmbeddedShader {
    std::string_view path;  ///< below shaders/, e.g. "deform/stamp.frag"
    std::string_view text;
};

/// All of them, sorted by path.
std::span<const EmbeddedShader> embedded_shaders();

}  // namespace tilth::gl
