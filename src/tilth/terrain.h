// The facade: owns the stages and fixes the frame's order.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tilth/cache/frame_budget.h"
#include "tilth/cache/nine_regions.h"
#include "tilth/cache/tile_state.h"
#include "tilth/core/result.h"
#include "tilth/derive/slope_rects.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/get_proc.h"
#include "tilth/ground/change_set.h"
#include "tilth/ground/ground.h"
#include "tilth/pool/slope_map.h"
#include "tilth/render/detail_settings.h"
#include "tilth/render/view.h"
#include "tilth/store/tile_store.h"
#include "tilth/store/world_folder.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// Who computes stamps. All leave the same bits.
enum class ExecutorKind : std::uint8_t {
    Gpu,        ///< FBO passes over the stamp's rectangle
    Cpu,        ///< vectorised C++; dirty rectangles are uploaded to the same textures
    Automatic,  ///< whichever a short measurement at creation found faster; see `Terrain::executor`
};

/// How detail tiles come and go. Tile size and texels a post are `GroundSettings`.
struct TileSettings {
    double band = 0.1;       ///< width of the central band as a fraction of a tile, 0.02..0.9: how early tiles load
    std::int32_t apron = 0;  ///< texels round a tile; 0: what filtering and the slope stencil need, at most 16
    BudgetSettings budget;   ///< of transfers in a frame
    /// Most bytes of tile textures; 0: nine tiles a viewer. Less than four tiles is refused. Tiles that find no room
    /// are not drawn; nearer ones displace farther ones.
    std::uint64_t most_gpu_bytes = 0;
    /// Where tiles lie that are not in memory. Empty: the world's folder, and without one a `MemoryStore` of the
    /// terrain's own. A tile is given to it when the viewers leave; what is still in memory when the terrain is
    /// destroyed is not (the destructor waits for saves that were begun). Refused together with a world's folder, and
    /// without a GL context: all detail stays in memory then.
    std::shared_ptr<TileStore> store;
};

/// A world on disk: what was dented stays, over a crash too.
struct WorldSettings {
    /// Opened, or made where its parent exists; locked against a second opening. Empty: all is lost with the object.
    std::string folder;
    /// When a stamp becomes durable, what old journal is kept, bounds of disk space.
    WorldOptions options;
    /// A snapshot is taken in the background when the journal has so many edits that the pages lack: more means fewer
    /// writes, longer ones (the coarse pages that changed are copied in one frame, 16 KiB for 64 x 64 posts), and a
    /// longer opening (about a microsecond an edit, and its stamp when its tile is loaded). At least 1.
    std::uint64_t snapshot_edits = 1u << 14;
};

struct TerrainSettings {
    GroundSettings ground;
    TileSettings tiles;
    WorldSettings world;
    /// Memory for undo, see `UndoHistory`; 0: no undo, and no cost.
    std::uint64_t undo_bytes = 0;
    /// `changes` tells what each frame changed: costs a look at the texels of its stamps.
    bool publish_changes = false;
    ExecutorKind executor = ExecutorKind::Automatic;
    SlopeFormat slopes = SlopeFormat::rg8;
    SlopeStencil stencil = SlopeStencil::Central;
    ClipmapSettings clipmap;
    /// How fine detail is shown at first; see `Terrain::set_detail`.
    DetailSettings detail;
    /// Folder to load shaders from instead of the embedded ones (`reload_shaders` reads them again); empty: embedded.
    std::string shader_folder;
    /// Collects the context's debug messages for `take_debug_messages`. A context has one callback: leave this off
    /// where the host has its own.
    bool collect_debug_messages = false;
};

/// A tile as `Terrain::tiles` reports it.
struct TileReport {
    TileIndex tile;
    TileState state = TileState::Absent;
    Interest interest = Interest::None;  ///< to the viewers
    bool modified = false;               ///< the store does not have its codes yet
    std::uint64_t pending_stamps = 0;    ///< fell on it while it was away; applied when it arrives
};

/// A tile that became resident: how long it took, and how far a viewer could still have walked before it was sampled.
/// Tiles that were first dented where a viewer stood are no arrivals.
struct TileArrival {
    TileIndex tile;
    double lead_m = 0;      ///< 0: it was late, or its viewer was put down beside it
    double loading_ms = 0;  ///< since it was wanted
};

/// The world on disk, as `Terrain::world` reports it.
struct WorldReport {
    std::uint64_t edits = 0;      ///< stamps, undos and redos that the world ever saw
    std::uint64_t durable = 0;    ///< of them, those that a crash cannot take back
    std::uint64_t committed = 0;  ///< of them, those that the pages hold: the rest is replayed when it is opened
    std::uint64_t journal_bytes = 0, page_bytes = 0;
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
    /// In a world on disk the first stamp with a shape of the host's own writes that shape, and waits for the disk;
    /// fails where that does not work.
    Result<StampRecord> stamp(const StampRequest& request);

    /// Queues a record made earlier or elsewhere. It keeps its own sequence number.
    /// Fails with the field's name where it does not fit this world (`Ground::accept`); nothing is queued then.
    Result<void> replay(const StampRecord& record);

    /// Stamps between the two are undone together; any other is a stroke of its own.
    void begin_stroke();
    void end_stroke();
    /// Queues the undoing of the last stroke; bit for bit, whatever it did and wherever its tiles are. Fails where none
    /// can be undone: none was made, or `undo_bytes` did not reach that far. In a world on disk undo reaches back over
    /// its closing, too.
    Result<void> undo();
    /// Queues what the last undo took back.
    Result<void> redo();
    [[nodiscard]] std::size_t undoable() const;
    [[nodiscard]] std::size_t redoable() const;

    /// Waits until every stamp so far is durable (see `FlushPolicy`). Without a world on disk there is nothing to do.
    Result<void> flush();
    /// Waits until the pages on disk are those of the ground now, so that opening the world replays nothing. Fails like
    /// `drain`, and when the disk refuses: nothing is lost then, the journal has it.
    Result<void> save();
    /// The same in the background, of the state after the next `update`. Errors come by `take_errors`; it is tried
    /// again.
    void begin_save();
    [[nodiscard]] bool is_saving() const;
    /// Empty without a world on disk.
    [[nodiscard]] std::optional<WorldReport> world() const;
    /// Closes the world as a crash would: what is not durable now never will be. Nothing may be stamped afterwards. To
    /// rehearse crashes.
    void abandon_world();

    /// Whose surroundings are kept resident: places on the ground, for all frames until the next call. None: nothing is
    /// resident. Before the first call the eye of the last `draw` (at first the map's middle) is the only viewer.
    void set_viewers(std::span<const WorldPos> viewers);

    /// Detail tiles that hold anything or are on their way, in the order of their indices. Untouched tiles share one
    /// zero tile and are not listed.
    [[nodiscard]] std::vector<TileReport> tiles() const;
    [[nodiscard]] TileGrid tile_grid() const;
    /// Tiles that became resident since the last call.
    [[nodiscard]] std::vector<TileArrival> take_arrivals();
    /// What the store could not do since the last call; each trouble is reported once, until it went well again.
    /// Nothing is lost: loads and saves are tried again, with growing pauses, and edits stay in memory until then.
    /// After `create`: what opening the world found damaged, each with its file and offset, and what became of it.
    [[nodiscard]] std::vector<Error> take_errors();
    /// Bytes of the textures of tiles that exist now, planes and slopes; 0 on untouched ground.
    [[nodiscard]] std::uint64_t tile_gpu_bytes() const;

    /// Applies the queued stamps in order, then slopes and mips over what changed. Never waits for the GPU.
    /// `dt_s` is the frame's time step; negative or NaN counts as 0. Starts the next frame's statistics.
    /// Saturated texels on the GPU are counted by queries that arrive some frames later, in that frame's statistics.
    /// Where only a read-back can tell whether a stamp saturates (the bounds of ground that was stamped again and again
    /// widen), one is done, waits, and counts as a fallback.
    /// Fails with ShaderCompile or OutOfMemory when a pass cannot be made, and with Unsupported when a stamp's image
    /// exceeds what the GPU can hold. Nothing is lost: those stamps are applied by the CPU executor and count as
    /// fallbacks.
    Result<void> update(double dt_s);

    /// What the last `update` changed on both maps, with `publish_changes`; for physics (bounds to widen, bodies to
    /// wake), navigation, plants. A stamp on a detail tile that is not in memory counts when it is issued; `smooth` and
    /// undo when they are done, which for them may be some frames later.
    [[nodiscard]] const std::vector<Change>& changes() const;

    /// Draws the ground into the bound draw framebuffer, inside its viewport (0, 0, width, height). The host has bound
    /// a complete one with a depth attachment and cleared both (depth to 1, or 0 with `DepthConvention::Reversed`);
    /// depth test, culling and masks are set here. Colours are linear RGB; GL encodes them where the host enabled
    /// GL_FRAMEBUFFER_SRGB. Near the eye the detail map's slopes are added for shading, and its heights are shown as
    /// `set_detail` says. Fails without GL, with settings
    /// out of range, with no complete framebuffer bound, and where a backend's programs or textures cannot be made
    /// (ShaderCompile, OutOfMemory): nothing is drawn then, and it is tried again, until `set_detail` takes another. 0
    /// x 0 pixels draw nothing.
    Result<void> draw(const View& view, const Shading& shading, const BrushCursor* cursor = nullptr);

    /// How fine detail is shown from the next `draw` on: backend, method, knobs. At any time, from any of them to any
    /// other; what a backend needs (programs, the window of heights about the eye: 9 to 11 bytes a texel, at most
    /// 2 048 x 2 048) is made when it first draws detail. Fails with InvalidArgument naming the field, or Unsupported
    /// where the context lacks what it takes: nothing changes then, and nothing else is shown in its place.
    Result<void> set_detail(const DetailSettings& settings);
    [[nodiscard]] const DetailSettings& detail() const;

    /// Waits until everything queued is in the ground, the CPU's coarse copy is current, and all tiles that the viewers
    /// want are resident. Counted outside the frame. Fails like `update`, and when the store cannot give a tile.
    Result<void> drain();

    /// Height of the surface, metres. Waits where the GPU holds newer codes or the place's detail tile is not in
    /// memory; NaN where the store cannot give it (`take_errors` says why).
    [[nodiscard]] double height_m(WorldPos at, MapSelect select = MapSelect::Sum);
    /// First hit of a ray with the drawn surface (coarse + detail), metres along `direction` normalised; empty: a miss,
    /// or a detail tile on the way that the store cannot give. Waits like `height_m`, only for tiles that the ray
    /// reaches.
    [[nodiscard]] std::optional<double> raycast(const Vec3d& from, const Vec3d& direction, double max_m);
    /// State of both maps, wherever their tiles are (`Ground::hash` has the layout). Waits. Fails when the store cannot
    /// give a tile.
    Result<StateHash> hash();

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
