// Plays a scenario's steps in order on one world.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>

#include "demo/player/screen.h"
#include "demo/player/viewer.h"
#include "demo/scenario/scenario.h"
#include "demo/stats/run_report.h"
#include "demo/stats/walk_leads.h"
#include "demo/world/world_session.h"
#include "tilth/terrain.h"

namespace tilth::demo {

struct PlayerSettings {
    std::filesystem::path out = ".";  ///< where relative outputs go
    std::string route;                ///< of the context, for the statistics
    double low_m = 0, high_m = 100;   ///< range of the original heights, for the tint
};

/// Plays steps. A step that fails is written to `errors` with its number and line, remembered, and the run goes on.
///
/// Stamps are queued and enter the ground with the next frame, or before any step that looks at the ground. Frames of
/// `walk` and `wait` are timed; what looks (query, dump, expect, screenshot) drains first, outside their times. A
/// screenshot also waits for the tiles about the viewers, so that it shows what is there and not how far loading came.
/// Each step that stamps is one stroke of undo.
/// What the store refuses makes the step fail during which it was told; a damaged page that could be made again is a
/// message. Where a world cannot be opened again, that step and all later ones fail.
/// Without a screen frames are not drawn and screenshots fail. Thread: the one that owns the context.
class Player {
public:
    /// `world` is open.
    Player(WorldSession& world, const Scenario& scenario, Screen* screen, PlayerSettings settings,
           std::ostream& errors);

    /// All steps. True if every one did what it says.
    bool play();

    [[nodiscard]] const Viewer& viewer() const { return viewer_; }
    [[nodiscard]] const ShownDetail& shown() const { return shown_; }
    /// Statistics as of now. `with_hash` costs a pass over all codes, and drains.
    [[nodiscard]] RunReport report(bool with_hash);

private:
    using Outcome = std::optional<std::string>;  ///< why a step failed

    Outcome run(const CameraStep& step);
    Outcome run(const StampStep& step);
    Outcome run(const PathStep& step);
    Outcome run(const RandomStep& step);
    Outcome run(const WalkStep& step);
    Outcome run(const TeleportStep& step);
    Outcome run(const ViewersStep& step);
    Outcome run(const WaitStep& step);
    Outcome run(const ShowStep& step);
    Outcome run(const SaveStep& step);
    Outcome run(const ReopenStep& step);
    Outcome run(const CrashStep& step);
    Outcome run(const UndoStep& step);
    Outcome run(const RedoStep& step);
    Outcome run(const ScreenshotStep& step);
    Outcome run(const DumpStep& step);
    Outcome run(const QueryStep& step);
    Outcome run(const ExpectStep& step);

    [[nodiscard]] Terrain& terrain() { return world_.terrain(); }
    /// What only an open world has.
    void add_world(bool with_hash, RunReport& report);
    Outcome queue(StampRequest request, std::int64_t repeat);
    /// Fails for a world in memory; `step` is the key.
    Outcome needs_a_folder(const char* step) const;
    /// What the world's last opening still had to tell, before it is closed; the viewers go on in the new one.
    Outcome opened_again(const std::function<Result<void>()>& open);
    Outcome timed_frame(double dt_s);
    /// `overlay`: with the residency map.
    Outcome draw_frame(bool overlay);
    /// Drains, and waits until the tiles about the viewers are resident.
    Outcome bring_tiles();
    /// The detail codes that a dump reads, into memory.
    Outcome bring_codes(const DumpStep& step);
    /// What the store could not do since the last call; empty: nothing. Repairs are told as messages.
    Outcome store_trouble();
    /// Places of the camera's viewer and of the further ones.
    [[nodiscard]] std::vector<WorldPos> viewers() const;
    /// Runs a step's action; a failure, returned or thrown, is reported and remembered.
    void attempt(int number, int line, const std::function<Outcome()>& action);
    /// Everything queued enters the ground. Returns what the library could not do.
    Outcome drained();
    /// The same; throws it.
    void settle();
    [[nodiscard]] double ground_m(WorldPos at);
    [[nodiscard]] std::string output_path(const std::string& file) const;
    [[nodiscard]] View view_now();

    WorldSession& world_;
    const Scenario& scenario_;
    Screen* screen_;
    PlayerSettings settings_;
    std::ostream& errors_;
    Shading shading_;
    ShownDetail shown_;
    Viewer viewer_;
    std::vector<WorldPos> further_viewers_;
    std::int64_t queued_ = 0;          ///< stamps since the last frame or drain
    FrameTimes frames_, walk_frames_;  ///< of walks and waits; of walks alone
    WalkStats walk_;
    Json queries_ = Json::array();
    std::vector<std::string> failures_;
};

}  // namespace tilth::demo
