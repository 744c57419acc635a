#include "demo/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <iostream>

#include "demo/scenario/names.h"
#include "demo/scenario/read_scenario.h"

namespace tilth::demo {

namespace {

std::optional<int> side_of(std::string_view digits) {
    int value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || value < 1 || value > kMaxPictureSide) return {};
    return value;
}

std::optional<std::array<int, 2>> size_of(const std::string& value) {
    const std::size_t x = value.find('x');
    if (x == std::string::npos) return {};
    const auto width = side_of(std::string_view(value).substr(0, x)),
               height = side_of(std::string_view(value).substr(x + 1));
    if (!width || !height) return {};
    return std::array<int, 2>{*width, *height};
}

std::string joined(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names) out += (out.empty() ? "" : "|") + name;
    return out;
}

/// Refuses values that are not in the list. The message follows the flag's name, which CLI11 puts before it.
CLI::Validator one_of_these(const std::vector<std::string>& names) {
    return CLI::Validator(
        [names](std::string& value) {
            if (std::find(names.begin(), names.end(), value) != names.end()) return std::string();
            return "'" + value + "' is not known; allowed: " + joined(names);
        },
        joined(names));
}

std::string check_folder_name(std::string& value) {
    return value.empty() ? "is empty; allowed: the path of a folder" : std::string();
}

std::string check_size(std::string& value) {
    return size_of(value) ? std::string()
                          : "'" + value + "' is not a size; allowed: WIDTHxHEIGHT, each from 1 to 16384";
}

}  // namespace

ParsedArguments parse_arguments(int argc, const char* const* argv) {
    ParsedArguments parsed;
    Arguments& a = parsed.arguments;
    CLI::App app("tilth-sandbox: ground that can be dented, in a window or by a scenario", "tilth-sandbox");
    std::string size;
    app.add_flag("--headless", a.headless, "no window; needs --scenario");
    app.add_option("--scenario", a.scenario, "what to play (TOML)");
    app.add_option("--heights", a.heights, "of the default world: a file, or ridged:..., flat:..., hill:...");
    app.add_option("--size", size, "of the picture, pixels")->check(CLI::Validator(check_size, "WIDTHxHEIGHT"));
    app.add_option("--backend", a.backend, "how fine detail is shown")->check(one_of_these(kBackendNames));
    app.add_option("--preset", a.preset, "quality")->check(one_of_these(kPresetNames));
    app.add_option("--executor", a.executor, "who computes stamps")->check(one_of_these(kExecutorNames));
    app.add_option("--context", a.context, "where GL comes from without a window")->check(one_of_these(kContextNames));
    app.add_option("--precision", a.precision, "of heights")->check(one_of_these(kPrecisionNames));
    app.add_option("--store", a.store, "the world's folder; what was dented there stays")
        ->check(CLI::Validator(check_folder_name, "DIR"));
    app.add_option("--out", a.out, "folder for relative outputs");
    app.add_option("--stats", a.stats, "statistics as JSON");
    app.add_option("--stamps", a.stamps, "folder of stamp images")->check(CLI::ExistingDirectory);
    app.add_option("--shaders", a.shaders, "folder of shaders instead of the built-in ones")
        ->check(CLI::ExistingDirectory);
    app.add_option("--frames", a.frames, "window: leave after so many frames")->check(CLI::Range(0L, 1'000'000'000L));
    app.add_flag("--script", a.script, "window: play a short input script (smoke test)");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const int status = app.exit(error);
        parsed.exit_status = status == 0 ? 0 : 2;
        return parsed;
    }
    if (!size.empty()) a.size = size_of(size);
    if (a.headless && a.scenario.empty()) {
        std::cerr << "--headless: there is nothing to play; give --scenario FILE\n";
        parsed.exit_status = 2;
    }
    return parsed;
}

void override_scenario(const Arguments& arguments, Scenario& scenario) {
    if (arguments.size) scenario.view.width = (*arguments.size)[0], scenario.view.height = (*arguments.size)[1];
    const auto index = [](const std::vector<std::string>& names, const std::string& name) {
        return std::find(names.begin(), names.end(), name) - names.begin();
    };
    TerrainSettings& settings = scenario.terrain.settings;
    ShownDetail& shown = scenario.view.shown;
    if (arguments.backend) {
        shown.backend = static_cast<DetailBackend>(index(kBackendNames, *arguments.backend));
        scenario.terrain.lines.erase("backend");  // what is wrong with it is not the file's
    }
    if (arguments.preset) shown.preset = static_cast<DetailPreset>(index(kPresetNames, *arguments.preset));
    settings.detail = settings_of(shown);
    if (arguments.executor) settings.executor = static_cast<ExecutorKind>(index(kExecutorNames, *arguments.executor));
    if (arguments.precision)
        settings.ground.precision =
            *arguments.precision == "bits32" ? HeightPrecision::bits32 : HeightPrecision::bits16;
    settings.shader_folder = arguments.shaders;
    if (!arguments.store.empty()) {
        settings.world.folder = without_last_slash(arguments.store);
        scenario.terrain.lines.erase("store");  // as above
    }
}

}  // namespace tilth::demo
