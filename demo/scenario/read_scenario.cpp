#include "demo/scenario/read_scenario.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "demo/scenario/read_parts.h"
#include "tilth/core/result.h"

namespace tilth::demo {

namespace {

constexpr std::size_t kMaxScenarioBytes = 64u << 20;

int line_in(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

void read_steps(TableReader& root, const toml::table& table, const ScenarioContext& context, Scenario& scenario,
                Problems& problems) {
    const toml::node* node = table.get("step");
    if (node == nullptr) return;
    const toml::array* steps = node->as_array();
    if (steps == nullptr) {
        root.wrong("step", "is not a list of tables; allowed: [[step]] before each step");
        return;
    }
    const StepRules rules{context, scenario.terrain};
    int number = 0;
    for (const toml::node& entry : *steps) {
        ++number;
        const toml::table* one = entry.as_table();
        if (one == nullptr)
            problems.add(line_in(entry), "step", "is not a table; allowed: [[step]] before each step");
        else if (auto step = read_step(*one, number, line_in(entry), rules, problems))
            scenario.steps.push_back(std::move(*step));
    }
}

Scenario read_root(const toml::table& table, const std::filesystem::path& file, const ScenarioContext& context,
                   Problems& problems) {
    Scenario scenario;
    scenario.file = file;
    TableReader root(table, "the file", 1, problems);
    if (const toml::table* terrain = root.table("terrain", "a table [terrain]")) {
        TableReader reader(*terrain, "[terrain]", root.line_of("terrain"), problems);
        read_terrain(reader, file.parent_path(), scenario.terrain);
    } else if (!root.has("terrain")) {
        root.missing("terrain", "a table [terrain] with at least heights");
    }
    if (const toml::table* view = root.table("view", "a table [view]")) {
        TableReader reader(*view, "[view]", root.line_of("view"), problems);
        read_view(reader, scenario.view, scenario.terrain);
    }
    root.known("step");
    read_steps(root, table, context, scenario, problems);
    root.finish();
    return scenario;
}

}  // namespace

std::optional<Scenario> parse_scenario(std::string_view text, const std::filesystem::path& file,
                                       const ScenarioContext& context, Problems& problems) {
    try {
        const toml::table table = toml::parse(text, file.string());
        Scenario scenario = read_root(table, file, context, problems);
        if (!problems.empty()) return {};
        return scenario;
    } catch (const toml::parse_error& error) {
        std::string what(error.description());
        for (char& c : what)
            if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
        problems.add(static_cast<int>(error.source().begin.line), "toml", what + "; allowed: TOML 1.0");
    } catch (const std::exception& error) {
        problems.add(1, "toml", std::string("cannot be read: ") + error.what());
    }
    return {};
}

std::optional<Scenario> read_scenario(const std::filesystem::path& file, const ScenarioContext& context,
                                      Problems& problems) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) {
        problems.add(1, "scenario", "no such file; allowed: the path of a TOML file");
        return {};
    }
    if (const auto bytes = std::filesystem::file_size(file, error); error || bytes > kMaxScenarioBytes) {
        problems.add(1, "scenario", "is over 64 MiB; allowed: a smaller file");
        return {};
    }
    std::ifstream in(file, std::ios::binary);
    std::ostringstream content;
    content << in.rdbuf();
    if (!in) {
        problems.add(1, "scenario", std::string("cannot be read: ") + std::strerror(errno));
        return {};
    }
    return parse_scenario(content.str(), file, context, problems);
}

}  // namespace tilth::demo
