// The stamp images of a folder, as shapes.
#pragma once

#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/shape_library.h"

namespace tilth::demo {

/// Names of the images in `folder`: its *.png without their ending, sorted bytewise. Empty if there is no folder.
std::vector<std::string> stamp_names(const std::string& folder);

/// The six built-in profiles, then `stamp_names`: every name a scenario may use, in the library's order.
std::vector<std::string> shape_names(const std::string& folder);

/// Reads every image of the folder into the library, in the order of `stamp_names`.
Result<void> add_stamps(const std::string& folder, ShapeLibrary& library);

}  // namespace tilth::demo
