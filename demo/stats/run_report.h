// The statistics of a run, and their JSON form (demo/scenario/SCENARIO.md, "Statistics").
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "demo/stats/frame_times.h"
#include "demo/stats/walk_leads.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/ground/ground.h"
#include "tilth/terrain.h"

namespace tilth::demo {

using Json = nlohmann::ordered_json;

/// Everything that `--stats` writes.
struct RunReport {
    std::string route, renderer, gl_version;  ///< "egl" | "osmesa" | "glfw", GL_RENDERER, "4.5"
    std::string executor, executor_reason;    ///< "gpu" | "cpu": the one that ran, and why
    StateHash hash;
    FrameTimes frames;                 ///< of `walk` and `wait`; screenshots are not timed
    FrameTimes walk_frames;            ///< of them, those of `walk`
    gl::FrameStats total, last_frame;  ///< `total`: also of the world's earlier openings
    std::optional<WorldReport> world;  ///< where there is one on disk
    WalkStats walk;
    std::uint64_t tiles = 0,
                  tile_bytes = 0;  ///< resident detail tiles, and bytes of the textures of all that have some
    std::uint64_t gpu_bytes = 0, cpu_bytes = 0;
    Json queries = Json::array();
    std::vector<std::string> failures;
};

/// All keys of SCENARIO.md. Effects, which this build does not have, are zeros; `world` stands only where there is one.
/// What was not measured (a lead when no tile had to come, a frame when none was timed) is null.
Json to_json(const RunReport& report);

/// The value at a path like "last_frame.deform.passes" or "queries.0.1"; nothing if there is none.
std::optional<Json> value_at(const Json& statistics, std::string_view path);

/// Whether `path` can lead to a number or text in some run's statistics. Queries are only known once they ran.
bool has_stat(std::string_view path);

}  // namespace tilth::demo
