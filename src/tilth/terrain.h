// The facade: owns the stages and fixes the frame's order.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/derive/slope_rects.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/get_proc.h"
#include "tilth/ground/ground.h"
#include "tilth/pool/slope_map.h"
#include "tilth/render/view.h"

namespace tilth {

/// Who computes stamps. All leave the same bits.
enum class ExecutorKind : std::uint8_t {
    Gpu,        ///< FBO passes over the stamp's rectangle
    Cpu,        ///< vectorised C++; dirty rectangles are uploaded to the same textures
    Automatic,  ///< whichever a short measurement at creation found faster; see `Terrain::executor`
};

struct TerrainSettings {
    GroundSettings ground;
    ExecutorKind executor = ExecutorKind::Automatic;
    SlopeFormat slopes = SlopeFormat::rg8;
    SlopeStencil stencil = SlopeStencil::Central;
    ClipmapSettings clipmap;
    /// Folder to load shaders from instead of the embedded ones (`reload_shaders` reads them again); empty: embedded.
    std::string shader_folder;
    /// Collects the context's debug messages for `take_debug_messages`. A context has one callback: leave this off
    /// where the host has its own.
    bool collect_debug_messages = false;
};

/// Ground that can be dented for good, drawn by a geometry clipmap.
///
/// A frame is: `stamp` any number of times, then `update`, then `draw` once per view. Stamps are checked and numbered
/// when they are issued and change the ground in `update`, in order. Queries and hashes see everything up to the last
/// `update`.
/// Units: metres, seconds, radians, +y up. Thread: the one that owns the context. GL state: every public call leaves it
/// as it was; queries, conditional rendering and transform feedback in progress are the host's to end or pause. Errors:
/// `Result`; nothing throws, nothing falls back silently. Without a get-proc function the object has no GL: `draw` is
/// refused and the executor is `Cpu`.
class Terrain {
public:
    /// Loads all coarse heights, computes the whole slope map. `get_proc` is the host's; the host's context is current
    /// now and at every later call (also at destruction).
    static Result<std::unique_ptr<Terrain>> create(std::shared_ptr<const HeightSource> source,
                                                   const TerrainSettings& settings, gl::GetProc get_proc);
    ~Terrain();
    Terrain(const Terrain&) = delete;
    Terrain& operator=(const Terrain&) = delete;

    /// To add profiles and images before stamping with them.
    [[nodiscard]] ShapeLibrary& shapes();
    /// The ground on the CPU. With the gpu executor its coarse codes are those of the last `drain`, `height_m`,
    /// `raycast` or `hash`, which bring them up to date.
    [[nodiscard]] const Ground& ground() const;

    /// Checks and queues one stamp; returns its record. Fails with the field's name and changes nothing.
    Result<StampRecord> stamp(const StampRequest& request);

    /// Queues a record made earlier or elsewhere (undo by `negated`, replay). It keeps its own sequence number.
    /// Fails with the field's name where it does not fit this world (`Ground::accept`); nothing is queued then.
    Result<void> replay(const StampRecord& record);

    /// Applies the queued stamps in order, then slopes and mips over what changed. Never waits for the GPU.
    /// `dt_s` is the frame's time step; negative or NaN counts as 0. Starts the next frame's statistics.
    /// Saturated texels on the GPU are counted by queries that arrive some frames later, in that frame's statistics.
    /// Where only a read-back can tell whether a stamp saturates (the bounds of ground that was stamped again and again
    /// widen), one is done, waits, and counts as a fallback.
    /// Fails with ShaderCompile or OutOfMemory when a pass cannot be made; the stamps that are not applied stay queued.
    /// Fails with Unsupported when a stamp's image exceeds what the GPU can hold; that stamp alone is dropped, and
    /// named.
    Result<void> update(double dt_s);

    /// Draws the ground into the bound draw framebuffer, inside its viewport (0, 0, width, height). The host has bound
    /// a complete one with a depth attachment and cleared both (depth to 1, or 0 with `DepthConvention::Reversed`);
    /// depth test, culling and masks are set here. Colours are linear RGB; GL encodes them where the host enabled
    /// GL_FRAMEBUFFER_SRGB. The detail map is not drawn in this version. Fails without GL, with settings out of range,
    /// and with no complete framebuffer bound. 0 x 0 pixels draw nothing.
    Result<void> draw(const View& view, const Shading& shading, const BrushCursor* cursor = nullptr);

    /// Waits until everything queued is in the ground and the CPU's copy is current. Counted outside the frame.
    Result<void> drain();

    /// Height of the surface, metres; drains first when the GPU holds newer codes.
    [[nodiscard]] double height_m(WorldPos at, MapSelect select = MapSelect::Sum);
    /// First hit of a ray with the drawn surface (coarse + detail), metres along `direction` normalised; empty: a miss.
    [[nodiscard]] std::optional<double> raycast(const Vec3d& from, const Vec3d& direction, double max_m);
    [[nodiscard]] StateHash hash();

    /// Which executor runs (never `Automatic`), and what the measurement was, for reports.
    [[nodiscard]] ExecutorKind executor() const;
    [[nodiscard]] const std::string& executor_reason() const;
    [[nodiscard]] std::string renderer() const;    ///< GL_RENDERER; empty without GL
    [[nodiscard]] std::string gl_version() const;  ///< like "4.5"; empty without GL

    [[nodiscard]] const gl::FrameStats& last_frame() const;
    [[nodiscard]] gl::FrameStats total() const;
    [[nodiscard]] std::uint64_t gpu_bytes() const;
    [[nodiscard]] std::uint64_t cpu_bytes() const;

    /// Reads all shaders again from `TerrainSettings::shader_folder`. A program that fails stays as it was, and the
    /// last error comes back.
    Result<void> reload_shaders();

    /// Messages of the context's debug output since the last call, with `collect_debug_messages`; empty on a good day.
    [[nodiscard]] std::vector<std::string> take_debug_messages();

private:
    struct Impl;
    explicit Terrain(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace tilth
