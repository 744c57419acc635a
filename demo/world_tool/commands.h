// What tilth-world does, one function a command. Each prints its findings; what stops it comes back as an error.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "tilth/core/result.h"
#include "tilth/ground/ground.h"

namespace tilth::demo {

/// Whether what was asked for was found to be in order; false: exit status 1.
using Outcome = Result<bool>;

/// These open journal and store as a game would, which cuts a torn tail and puts aside what cannot be read; the heights
/// are not needed.
Outcome print_info(const std::string& folder);
Outcome verify(const std::string& folder);
Outcome compact(const std::string& folder);

/// `heights`: what the world was made on, as a scenario names it; empty: what the world itself notes.
struct ExportArguments {
    std::string folder, heights, out;
    std::array<double, 4> region{};  ///< x0, z0, x1, z1, metres
    MapSelect map = MapSelect::Sum;
};
Outcome export_heights(const ExportArguments& arguments);

struct ImportArguments {
    std::string folder, heights, file;
    std::array<double, 2> at{};  ///< x, z of the file's first texel, metres; the nearest texel of the map is taken
    MapKind map = MapKind::Coarse;
};
Outcome import_heights(const ImportArguments& arguments);

Outcome replay(const std::string& folder, const std::string& heights);

/// The ground that a world was made on, untouched.
Result<std::unique_ptr<Ground>> ground_of(const std::string& folder, const std::string& heights);

}  // namespace tilth::demo
