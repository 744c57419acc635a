// A scenario as plain data: what the TOML form of SCENARIO.md says, checked and with its defaults filled in. No TOML,
// no GL.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "demo/scenario/shown_detail.h"
#include "tilth/core/vec.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/stamp.h"
#include "tilth/terrain.h"

namespace tilth::demo {

/// [terrain]: the world and who computes it.
struct TerrainPart {
    std::string heights;               ///< a path (already joined with the scenario's folder) or "word:key=value"
    TerrainSettings settings;          ///< everything else: ground, tiles, world on disk, executor, slopes, clipmap
    std::map<std::string, int> lines;  ///< line of every key that was given, for errors found later
    int line = 1;                      ///< of the table itself
};

/// [view]: the picture's size and look.
struct ViewPart {
    std::int32_t width = 1600, height = 900;  ///< pixels
    double fov_degrees = 60;                  ///< vertical
    Vec3f clear{0.6f, 0.6f, 0.6f};            ///< background, linear RGB
    ShownDetail shown;                        ///< at first; `TerrainSettings::detail` says the same
    double fog_per_m = 0;                     ///< density of exp(-(density d)^2); the fog has the clear colour
    std::optional<Vec3d> to_light;            ///< direction towards the light; absent: `Shading`'s
    std::optional<double> ambient, diffuse;   ///< factors on the ground's colour; absent: `Shading`'s
    std::optional<std::array<double, 2>>
        tint_m;  ///< heights between which low turns to high; absent: the source's range
};

/// A position on the ground that may leave its height to the ground's: y, or metres above the surface.
struct CameraStep {
    Vec3d eye;  ///< y is not used with `above_ground_m`
    Vec3d look_at;
    std::optional<double> above_ground_m;
};

struct StampStep {
    std::string shape;        ///< a name that the stamp library knows
    StampRequest request;     ///< all but its shape's number; `key` as given
    std::int64_t repeat = 1;  ///< the key counts up
};

struct PathStep {
    StampStep stamp;
    std::vector<WorldPos> points;
    double spacing_m = 0.75, alternate_m = 0;
};

struct RandomStep {
    std::uint64_t seed = 1;
    std::int64_t count = 0;
    std::array<WorldPos, 2> region;
    std::array<double, 2> radius_m{1, 1}, amplitude_m{0, 0};
    MapChoice map = MapChoice::Auto;
    std::vector<std::string> shapes;  ///< in the library's order; never empty
    std::vector<StampRule> rules;     ///< in the order of `StampRule`; never empty
};

struct WalkStep {
    WorldPos to;
    double speed_m_per_s = 1, above_ground_m = 2, dt_s = 0.016667, stride_m = 0.75;
    std::optional<StampStep> print;
    double alternate_m = 0;  ///< of the print: as of a path
};

struct TeleportStep {
    WorldPos to;
};

/// Further viewers beside the camera's own, from now on; they stay where they are.
struct ViewersStep {
    std::vector<WorldPos> at;
};

struct WaitStep {
    std::int64_t frames = 0;
    std::optional<double> seconds;       ///< in place of `frames`: until the steps add up to it
    std::vector<double> dt_s{0.016667};  ///< cycled
};

struct ScreenshotStep {
    std::string file, depth_file;  ///< depth is empty if not asked for
    bool overlay = false;          ///< with the residency map in the picture's corner
};

/// How fine detail is shown from now on; what is absent stays.
struct ShowStep {
    std::optional<DetailBackend> backend;
    std::optional<DetailPreset> preset;
    std::optional<DebugView> debug;
    std::optional<bool> phong;
};

inline ShownDetail shown_after(const ShownDetail& before, const ShowStep& step) {
    return {.backend = step.backend.value_or(before.backend),
            .preset = step.preset.value_or(before.preset),
            .debug = step.debug.value_or(before.debug),
            .phong = step.phong.value_or(before.phong)};
}

/// The world on disk: `save` puts everything into its pages; `reopen` ends the world and opens it again; `crash` does
/// so without closing it first.
struct SaveStep {};
struct ReopenStep {};
struct CrashStep {};

struct UndoStep {
    std::int64_t strokes = 1;
};
struct RedoStep {
    std::int64_t strokes = 1;
};

enum class DumpWhat { Height, Code, Slope };

struct DumpStep {
    MapKind map = MapKind::Coarse;
    std::array<WorldPos, 2> region;
    DumpWhat what = DumpWhat::Height;
    std::string file;
};

struct QueryStep {
    std::vector<WorldPos> at;
    MapSelect map = MapSelect::Sum;
};

struct ExpectHeight {
    WorldPos at;
    double value_m = 0, within_m = 0;
};
struct ExpectHash {
    std::optional<std::string> coarse, detail;  ///< 16 lower-case hexadecimal digits
};
struct ExpectStat {
    std::string path;  ///< "last_frame.deform.passes"
    std::optional<double> equals, at_most, at_least;
    std::optional<std::string> equals_text;
};
struct ExpectStep {
    std::variant<ExpectHeight, ExpectHash, ExpectStat> what;
};

struct Step {
    int number = 0;  ///< from 1
    int line = 0;    ///< in the file
    std::variant<CameraStep, StampStep, PathStep, RandomStep, WalkStep, TeleportStep, ViewersStep, WaitStep, ShowStep,
                 SaveStep, ReopenStep, CrashStep, UndoStep, RedoStep, ScreenshotStep, DumpStep, QueryStep, ExpectStep>
        action;
};

struct Scenario {
    std::filesystem::path file;  ///< where it was read from; empty for the default world
    TerrainPart terrain;
    ViewPart view;
    std::vector<Step> steps;
};

}  // namespace tilth::demo
