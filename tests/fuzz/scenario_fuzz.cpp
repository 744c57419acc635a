// Scenarios: one is read, or there are problems, each with a line that exists; nothing is thrown.
#include "demo/scenario/read_scenario.h"
#include "fuzz/fuzz_input.h"

namespace tilth::fuzz {
namespace {

void run(Input input) {
    static const demo::ScenarioContext context{{"gaussian", "cone", "paraboloid", "cosine", "crater", "disc", "boot"},
                                               [](std::string_view path) { return path.size() % 2 == 0; }};
    const std::string_view content = text_of(input.rest());
    demo::Problems problems;
    const std::optional<demo::Scenario> scenario =
        demo::parse_scenario(content, "no/such/folder/made_up.toml", context, problems);
    check(scenario.has_value() == problems.empty(), "a scenario, or problems");
    const auto lines = std::ranges::count(content, '\n') + 1;
    for (const demo::Problem& problem : problems.list())
        check(problem.line >= 1 && problem.line <= lines && !problem.text.empty(), "a problem has a line, and words");
    check(problems.report("FILE").find_first_of(std::string_view("\0\x1b\x7f", 3)) == std::string::npos,
          "control characters do not reach the terminal");
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
