// A world over its openings: the sandbox's own, which scenarios close, crash and open again.
#pragma once

#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "demo/scenario/problems.h"
#include "demo/scenario/scenario.h"
#include "tilth/source/height_source.h"
#include "tilth/terrain.h"

namespace tilth::demo {

/// How a world is opened, the first time and again.
struct WorldPlace {
    TerrainPart terrain;
    std::shared_ptr<const HeightSource> heights;
    std::string stamp_folder;
    gl::GetProc get_proc = nullptr;  ///< null: no GL
};

/// Owns the `Terrain`, which is another object after each opening.
///
/// What opening found damaged is written to `messages`, one line each: the world is as whole as it can be then.
/// Thread: the one that owns the context.
class WorldSession {
public:
    /// Nullptr, and a problem at the line of its key, where the world cannot be opened. `messages` outlives it.
    static std::unique_ptr<WorldSession> open(WorldPlace place, Problems& problems, std::ostream& messages);

    /// Only while it is open.
    [[nodiscard]] Terrain& terrain() { return *terrain_; }
    /// False where opening it again failed.
    [[nodiscard]] bool is_open() const { return terrain_ != nullptr; }
    [[nodiscard]] bool is_on_disk() const { return !place_.terrain.settings.world.folder.empty(); }

    /// Flushes, closes and opens again. What cannot be flushed stays open, and is the error. The executor stays the one
    /// that was measured, and detail is shown as it was.
    Result<void> reopen();
    /// The same as after a crash: what is not durable is gone.
    Result<void> crash();
    /// Waits until everything is durable, at the end of a program. Nothing to do for a world in memory.
    Result<void> flush();

    /// Of all openings.
    [[nodiscard]] gl::FrameStats total() const;
    /// Why this executor: as measured at the first opening.
    [[nodiscard]] const std::string& executor_reason() const { return executor_reason_; }
    /// The context's debug messages since the last call, of all openings.
    [[nodiscard]] std::vector<std::string> take_debug_messages();

private:
    WorldSession(WorldPlace place, std::unique_ptr<Terrain> terrain, std::ostream& messages);
    Result<void> open_again();
    void tell_damage();

    WorldPlace place_;
    std::unique_ptr<Terrain> terrain_;
    std::ostream& messages_;
    gl::FrameStats before_;  ///< of earlier openings
    std::string executor_reason_;
    std::vector<std::string> debug_messages_;  ///< of earlier openings
};

}  // namespace tilth::demo
