#include "demo/sandbox.h"

#include <filesystem>
#include <fstream>
#include <iostream>

#include "demo/gl/gl_route.h"
#include "demo/player/player.h"
#include "demo/scenario/read_scenario.h"
#include "demo/window/sandbox_window.h"
#include "demo/world/open_world.h"
#include "demo/world/stamp_folder.h"
#include "demo/world/world_session.h"

namespace tilth::demo {

namespace {

constexpr int kDone = 0, kStepFailed = 1, kNotStarted = 2;

/// The world without a scenario: real elevation where the build prepared it, else ridged hills.
Scenario default_scenario(const Arguments& arguments) {
    const std::string real = TILTH_DATA_DIR "/jacksboro.tif";
    Scenario scenario;
    scenario.file = "default world";
    scenario.terrain.heights = !arguments.heights.empty()      ? arguments.heights
                               : std::filesystem::exists(real) ? real
                                                               : "ridged:seed=7,size=1025,relief=200";
    scenario.view.fog_per_m = 0.0004;
    scenario.terrain.settings.ground.texels_per_post =
        30;  // 1/30 m, as in the reference configuration: boots have soles
    return scenario;
}

int not_started(const Problems& problems, const Scenario& scenario) {
    std::cerr << problems.report(scenario.file.string());
    return kNotStarted;
}

int not_started(const Error& error) {
    std::cerr << error.message << std::endl;
    return kNotStarted;
}

bool write_stats(const std::string& path, const RunReport& report) {
    std::ofstream file(path);
    file << to_json(report).dump(2) << '\n';
    file.close();
    if (file) return true;
    std::cerr << "--stats: cannot write " << path << std::endl;
    return false;
}

/// What stands before the first step: context, world, screen. Members die in reverse, the context last.
struct Session {
    std::optional<GlRoute> route;
    std::unique_ptr<WorldSession> world;
    std::optional<Screen> screen;
};

/// Exit status if it cannot start.
std::optional<int> open_session(const Arguments& arguments, const std::string& stamps, const Scenario& scenario,
                                std::shared_ptr<const HeightSource> heights, Session& session) {
    auto route = arguments.headless ? GlRoute::offscreen(arguments.context)
                                    : GlRoute::window("tilth", scenario.view.width, scenario.view.height);
    if (!route) return not_started(route.error());
    session.route = std::move(*route);
    Problems problems;
    session.world = WorldSession::open({scenario.terrain, std::move(heights), stamps, session.route->get_proc()},
                                       problems, std::cerr);
    if (!session.world) return not_started(problems, scenario);
    auto screen = Screen::create(session.route->get_proc(), scenario.view);
    if (!screen) return not_started(screen.error());
    session.screen = std::move(*screen);
    return {};
}

}  // namespace

int run_sandbox(const Arguments& arguments) {
    const std::string stamps = arguments.stamps.empty() ? TILTH_STAMP_DIR : arguments.stamps;
    Scenario scenario = default_scenario(arguments);
    Problems problems;
    if (!arguments.scenario.empty()) {
        auto read = read_scenario(arguments.scenario, {shape_names(stamps), has_stat}, problems);
        scenario.file = arguments.scenario;
        if (!read) return not_started(problems, scenario);
        scenario = std::move(*read);
    }
    override_scenario(arguments, scenario);
    const auto heights = load_heights(scenario.terrain, problems);
    if (!heights) return not_started(problems, scenario);
    if (!arguments.headless && !has_display()) {
        std::cerr << "no display: DISPLAY and WAYLAND_DISPLAY are empty; use --headless --scenario FILE\n";
        return kNotStarted;
    }
    const double low_m = heights->min_m(), high_m = heights->max_m();
    std::error_code error;
    std::filesystem::create_directories(arguments.out, error);
    if (error) {
        std::cerr << "--out: cannot make " << arguments.out << ": " << error.message() << std::endl;
        return kNotStarted;
    }

    Session session;
    if (const auto status = open_session(arguments, stamps, scenario, heights, session)) return *status;
    Player player(*session.world, scenario, &*session.screen, {arguments.out, session.route->name(), low_m, high_m},
                  std::cerr);
    bool good = player.play();
    if (!arguments.stats.empty()) good = write_stats(arguments.stats, player.report(true)) && good;
    if (!arguments.headless && session.world->is_open()) {
        const WindowSettings window{scenario.view,  low_m,         high_m,           player.viewer(),
                                    player.shown(), arguments.out, arguments.frames, arguments.script};
        if (const auto run = run_window(session.route->window(), session.world->terrain(), window); !run) {
            std::cerr << run.error().message << std::endl;
            good = false;
        }
    }
    if (const auto flushed = session.world->flush(); !flushed) {
        std::cerr << flushed.error().message << std::endl;
        good = false;
    }
    for (const std::string& message : session.world->take_debug_messages()) std::cerr << "GL: " << message << '\n';
    return good ? kDone : kStepFailed;
}

}  // namespace tilth::demo
