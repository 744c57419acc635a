// The words that scenarios and flags share, each list in the order of the enumeration it stands for.
#pragma once

#include <string>
#include <vector>

namespace tilth::demo {

inline const std::vector<std::string> kExecutorNames{"gpu", "cpu", "automatic"};
inline const std::vector<std::string> kPrecisionNames{"bits32", "bits16"};
inline const std::vector<std::string> kSlopeNames{"rg8", "rg16f"};
inline const std::vector<std::string> kMapNames{"auto", "coarse", "detail"};
inline const std::vector<std::string> kSelectNames{"sum", "coarse", "detail"};
inline const std::vector<std::string> kRuleNames{"add", "min", "max", "set", "smooth"};
inline const std::vector<std::string> kBackendNames{"none", "parallax", "geometry", "tessellation", "hybrid"};
inline const std::vector<std::string> kPresetNames{"low", "medium", "high", "exact"};
inline const std::vector<std::string> kDebugNames{"off", "wireframe", "level", "tile", "backend", "fetches", "error"};
inline const std::vector<std::string> kContextNames{"egl", "osmesa", "glfw"};
inline const std::vector<std::string> kDumpNames{"height", "code", "slope"};
inline const std::vector<std::string> kDumpEndings{".csv", ".exr", ".tif", ".r16", ".r32f"};

/// Pixels a side of a picture.
inline constexpr int kMaxPictureSide = 16384;

}  // namespace tilth::demo
