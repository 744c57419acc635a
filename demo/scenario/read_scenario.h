// Reads scenarios: TOML in the form of SCENARIO.md to checked data. Everything wrong is reported before anything runs.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "demo/scenario/problems.h"
#include "demo/scenario/scenario.h"

namespace tilth::demo {

/// What a scenario may refer to that only the program knows.
struct ScenarioContext {
    std::vector<std::string> shapes;                      ///< names of all shapes, in the library's order
    std::function<bool(std::string_view path)> has_stat;  ///< whether statistics have this path; empty: not checked
};

/// Reads and checks a file. Nothing is returned if anything is wrong; `problems` then says what.
/// Files it names must exist; heights are not opened. No exceptions leave it.
std::optional<Scenario> read_scenario(const std::filesystem::path& file, const ScenarioContext& context,
                                      Problems& problems);

/// The same from text that came from `file`.
std::optional<Scenario> parse_scenario(std::string_view text, const std::filesystem::path& file,
                                       const ScenarioContext& context, Problems& problems);

/// The path of a folder as the library names its files: without slashes at its end.
std::string without_last_slash(std::string folder);

}  // namespace tilth::demo
