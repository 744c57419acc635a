// The sandbox's command line.
#pragma once

#include <optional>
#include <string>

#include "demo/scenario/scenario.h"

namespace tilth::demo {

/// What the flags said. Absent optionals leave the scenario's value.
struct Arguments {
    bool headless = false;
    std::string scenario;  ///< empty: the default world
    std::string heights;   ///< of the default world; empty: what the build prepared, else ridged hills
    std::optional<std::array<int, 2>> size;  ///< pixels
    std::optional<std::string> backend, preset, executor, precision;
    std::string context = "egl";  ///< "egl" | "osmesa" | "glfw"
    std::string out = ".";        ///< where relative outputs go; made if it is not there
    std::string store;            ///< the world's folder; empty: the scenario's, or none
    std::string stats;            ///< JSON; empty: none
    std::string stamps;           ///< folder of stamp images
    std::string shaders;          ///< folder; empty: the embedded ones
    long frames = 0;              ///< window: leave after so many; 0: when the user does
    bool script = false;          ///< window: plays a short input script, for smoke tests
};

/// Either arguments, or the exit status the program should leave with (0 after --help, 2 after a mistake; the message
/// is already on its stream).
struct ParsedArguments {
    Arguments arguments;
    std::optional<int> exit_status;
};

ParsedArguments parse_arguments(int argc, const char* const* argv);

/// Flags override the file.
void override_scenario(const Arguments& arguments, Scenario& scenario);

}  // namespace tilth::demo
