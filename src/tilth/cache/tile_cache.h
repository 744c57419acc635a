// Fine detail everywhere, in bounded memory: which tiles are in memory and in textures, and how they come and go.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "tilth/cache/disk_worker.h"
#include "tilth/cache/frame_budget.h"
#include "tilth/cache/nine_regions.h"
#include "tilth/cache/tile_state.h"
#include "tilth/cache/tile_textures.h"
#include "tilth/core/result.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/ground/change_set.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/undo_history.h"
#include "tilth/store/snapshot.h"
#include "tilth/store/tile_store.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

struct TileCacheSettings {
    double band = 0.1;           ///< of a tile's width, see nine_regions.h
    bool gpu_executor = false;   ///< stamps are drawn into the textures, which are then ahead of the codes in memory
    std::size_t most_tiles = 0;  ///< with textures; 0: as many as the viewers want
    std::uint64_t bytes_a_texel = 6;                    ///< of textures, for the budget
    double least_retry_ms = 250, most_retry_ms = 8000;  ///< pauses after a failed request, doubled each time
    /// Stamps that wait for an absent tile before it is fetched, brought up to date and saved in the background.
    std::size_t most_pending = 16384;
    /// The same for all absent tiles together: beyond it those with the most are fetched.
    std::size_t most_pending_in_all = 1u << 18;
    bool publish_changes = false;  ///< see `changes`
};

/// A tile as it stands now.
struct CachedTile {
    TileIndex tile;
    TileState state = TileState::Absent;
    Interest interest = Interest::None;
    bool modified = false;
    std::uint64_t pending = 0;
};

/// A tile that became resident; those that were first dented where a viewer stood are no arrivals.
struct CachedArrival {
    TileIndex tile;
    double lead_texels = 0;  ///< how far the nearest viewer still was from making it active
    double loading_ms = 0;   ///< since it was wanted
};

/// The detail map of a world larger than memory.
///
/// A tile is *hot* while its codes are in the ground's `DetailField`. Cold tiles keep their codes in the store, and the
/// stamps that fell on them since in a list; when such a tile is wanted, its pages are loaded, the list is applied to
/// them in order, and it is hot. A tile that no stamp ever reached has no entry here, no pages and no textures.
///
///     cold: store + pending   -- load, apply -->   hot: pages in the field   -- fill -->   textures
///                             <-- save ---------
///
/// Beside hot tiles the field holds *guests*: pages of cold neighbours that reach into a hot tile's apron, kept up to
/// date with every stamp, so that aprons, slopes and `smooth` see what one big map would give. With the gpu executor
/// stamps on resident tiles are drawn into their textures, aprons included; the pages that the field then lacks are
/// remembered (`newer`) and read back before the tile is saved.
/// Whatever comes and goes, the codes are those that a ground which applies every record at once would have.
///
/// What the store has not been given is lost with the cache: stamps that wait, and codes of tiles that are in memory.
/// `snapshot` collects both, for a store that commits.
///
/// Threads: all members are for one thread; the store has a worker of its own. Nothing waits but `settle`, `require`
/// and `hash`. GL: through `TileTextures` alone.
class TileCache {
public:
    /// `ground` and `textures` outlive the cache. Asks the store which tiles it has. Fails when that fails.
    static Result<std::unique_ptr<TileCache>> create(Ground& ground, const TileGrid& grid,
                                                     std::shared_ptr<TileStore> store, TileTextures& textures,
                                                     const TileCacheSettings& settings);

    // A frame: viewers, update, stamp, transfer.

    void set_viewers(std::span<const WorldPos> viewers);
    /// Takes in what the worker finished, and starts what the viewers' places ask for. `now_ms`: a clock that never
    /// goes back.
    void update(double now_ms, gl::CacheStats& stats);
    /// Applies edits of the detail map in order: stamps at once where tiles are hot, else when they arrive. `smooth`,
    /// which reads neighbours, and the undoing of a stroke wait until all their tiles are hot, and later edits on those
    /// tiles wait behind them; a stroke that still waits everywhere is taken off the lists instead.
    /// Stamps of strokes keep what their undo needs. With the gpu executor that may take a read-back, which waits and
    /// counts as a fallback: for rules other than `add`, where the GPU is ahead of the field.
    /// Fails when the gpu executor cannot run; the edits are then applied by the CPU, nothing is lost, and it counts as
    /// a fallback.
    Result<void> apply(std::span<const GroundEdit> edits, gl::StageStats& deform);
    /// Fills textures of tiles that arrive, nearest first, as far as the budget allows.
    void transfer(FrameBudget& budget, gl::CacheStats& stats, gl::StageStats& deform);

    // Outside frames.

    /// Waits until no record is waiting for a tile that has to be loaded first, and until every tile that the viewers
    /// want is resident. Fails with the store's error when it cannot be had; nothing is lost.
    Result<void> settle(gl::CacheStats& stats, gl::StageStats& deform);
    /// Waits until the field holds the codes of `tiles` as they are now. They stay there until the next `update`.
    Result<void> require(std::span<const TileIndex> tiles, gl::CacheStats& stats, gl::StageStats& deform);
    /// Whether `require` would have nothing to do for a tile.
    [[nodiscard]] bool is_in_field(TileIndex tile) const;
    /// State hash of the whole detail map, wherever its tiles are. Cost: one tile in memory at a time.
    Result<std::uint64_t> hash(gl::CacheStats& stats, gl::StageStats& deform);

    // Durability.

    /// Stamps that waited for tiles when the world was saved last. Before the first frame. What does not fit this world
    /// is left out and reported.
    void restore_waiting(const std::map<TileIndex, std::vector<WaitingStamp>>& waiting, const UndoHistory& history);
    /// Everything that changed since the last snapshot, of one moment. Empty while an edit waits for tiles: ask again
    /// next frame. With the gpu executor what the field lacks is read back, which waits; less so if `prepare_snapshot`
    /// was called in the frames before.
    std::optional<std::vector<TileSnapshot>> snapshot(gl::StageStats& deform);
    /// With the gpu executor: begins to read back what a snapshot will need.
    void prepare_snapshot();
    /// A snapshot did not become durable: its tiles are in the next one again.
    void snapshot_failed(std::span<const TileSnapshot> tiles);
    /// Has the disk worker do something between the saves, see `DiskRequest::work`. Done when `take_finished` gives it
    /// back.
    void submit(const std::shared_ptr<DiskRequest>& work) { worker_.submit(work); }
    [[nodiscard]] std::vector<std::shared_ptr<DiskRequest>> take_finished() { return std::exchange(finished_, {}); }
    /// Waits until what was submitted is done.
    void wait_for(const std::shared_ptr<DiskRequest>& work, gl::CacheStats& stats);

    // Reports.

    [[nodiscard]] std::vector<CachedTile> tiles() const;
    /// Tiles that hold anything, in the order of their indices.
    [[nodiscard]] std::vector<TileIndex> touched() const;
    [[nodiscard]] std::vector<CachedArrival> take_arrivals();
    [[nodiscard]] std::vector<Error> take_errors();
    /// What the edits applied since `forget_changes` changed: each when it was applied, or began to wait for its tile
    /// to be loaded.
    [[nodiscard]] const ChangeSet& changes() const { return changes_; }
    void forget_changes() { changes_.clear(); }
    [[nodiscard]] const TileGrid& grid() const { return grid_; }
    [[nodiscard]] TileState state(TileIndex tile) const;
    /// Whether the tile's textures hold its codes, so that a frame may sample them.
    [[nodiscard]] bool can_be_drawn(TileIndex tile) const;
    /// Edits that wait for tiles and are tried again by `apply`.
    [[nodiscard]] bool has_waiting_edits() const { return !deferred_.empty(); }
    /// With the gpu executor: pages that the next snapshot needs and the field lacks, those on their way included.
    [[nodiscard]] std::size_t pages_ahead() const;
    /// Nothing is in memory or on its way.
    [[nodiscard]] bool is_idle() const { return live_.empty() && worker_.outstanding() == 0; }
    /// Nothing was ever stamped: a frame has nothing to do here.
    [[nodiscard]] bool is_untouched() const { return tiles_.empty(); }
    [[nodiscard]] std::size_t textured_tiles() const { return textured_.size(); }
    /// Stamps that wait for absent tiles, and pages of tiles that are not in the field yet.
    [[nodiscard]] std::uint64_t waiting_bytes() const;

private:
    /// What came for a tile, not in the field yet.
    struct Arrival {
        struct Guest {
            TileIndex owner;  ///< a cold neighbour
            std::uint64_t version = 0;
            PageRect pages;           ///< of it, those that reach into the tile's apron
            std::size_t applied = 0;  ///< of the owner's pending stamps
        };
        DetailField own, guests;
        std::size_t applied = 0;  ///< of the tile's pending stamps
        std::vector<Guest> neighbours;
    };
    /// A stamp for one map, ready to be applied.
    struct Stamp {
        GroundEdit edit;
        PreparedStamp prepared;
    };
    struct Tile {
        TileState state = TileState::Absent;
        bool hot = false;
        bool has_textures = false;
        bool yielding = false;      ///< gives its textures up for a nearer tile, as soon as they are read back
        bool stored = false;        ///< the store has it
        bool modified = false;      ///< the store does not have all of it
        bool changed = false;       ///< since the save on its way, if one is, was handed to the worker
        bool unsaved = false;       ///< since the last snapshot
        bool current = false;       ///< its textures hold its codes (with the gpu executor: and are the truth)
        std::uint64_t version = 0;  ///< saves of it that are done
        bool suspected =
            false;           ///< known to the store's list alone, beside a stored tile: its apron may hold something
        bool clean = false;  ///< it was, and it does not: as if there were no entry
        std::vector<Stamp> pending;            ///< while cold: since it was last hot
        std::unique_ptr<Arrival> arriving;     ///< loaded; until all that fell on it since is applied
        std::shared_ptr<DiskRequest> request;  ///< with the worker
        std::set<PageIndex> to_fill;           ///< where its textures are behind the field
        std::set<PageIndex> newer;             ///< where they are ahead of it
        std::set<PageIndex> reading;           ///< of `newer`, on the way
        double retry_at_ms = 0, pause_ms = 0, wanted_ms = -1;
        Error trouble;          ///< the last, while `pause_ms` is not 0
        bool reported = false;  ///< it

        void went_well() { pause_ms = retry_at_ms = 0, reported = false; }
        void was_changed() { modified = changed = unsaved = true; }
    };
    struct Task {
        Stamp stamp;                              ///< or only `stamp.edit`, of an undo
        TileWindow window;                        ///< tiles that it reads or changes, aprons included
        std::map<TileIndex, std::size_t> undone;  ///< tiles whose interior an undo changes, and by how many stamps
    };

    TileCache(Ground& ground, const TileGrid& grid, std::shared_ptr<TileStore> store, TileTextures& textures,
              const TileCacheSettings& settings);

    // tile_cache.cpp: coming and going
    void deliver(const std::shared_ptr<DiskRequest>& done, gl::CacheStats& stats);
    void send(TileIndex index, Tile& tile, TileEvent event, gl::CacheStats& stats);
    void start_wanted(gl::CacheStats& stats);
    void let_go_unwanted(gl::CacheStats& stats);
    void fetch_the_crowded();
    void suspect_neighbours(TileIndex index);
    void start_load(TileIndex index, Tile& tile);
    template <class Visit>
    void for_each_cold_neighbour(TileIndex of, const Visit& visit) const;
    [[nodiscard]] std::vector<LoadPiece> pieces_for(TileIndex index, const Tile& tile) const;
    void begin_arrival(TileIndex index, Tile& tile, std::span<LoadPiece> loaded);
    [[nodiscard]] bool is_current(TileIndex index, const Arrival& arrival) const;
    [[nodiscard]] bool apron_is_untouched(TileIndex index, const Arrival& arrival) const;
    bool arrive(TileIndex index, Tile& tile, std::size_t most_stamps, gl::CacheStats& stats, gl::StageStats& deform);
    void make_hot(TileIndex index, Tile& tile);
    void drop(TileIndex index, Tile& tile, gl::CacheStats& stats);
    void start_save(TileIndex index, Tile& tile, gl::CacheStats& stats);
    void begin_read_back(TileIndex index, Tile& tile);
    void poll_read_back(TileIndex index, Tile& tile, gl::CacheStats& stats);
    void refill_neighbours(TileIndex index, const std::set<PageIndex>& read);
    void release_textures(TileIndex index, Tile& tile, gl::CacheStats& stats);
    [[nodiscard]] bool is_full() const;
    [[nodiscard]] std::optional<TileIndex> makes_way_for(TileIndex index) const;
    bool make_room(TileIndex index, gl::CacheStats& stats);
    bool give_up_textures(TileIndex index, Tile& tile, gl::CacheStats& stats);
    bool acquire(TileIndex index, Tile& tile, gl::CacheStats& stats);
    bool fill(TileIndex index, Tile& tile, FrameBudget& budget);
    void finish_fill(TileIndex index, Tile& tile, gl::CacheStats& stats);
    void fail(Tile& tile, const Error& error, gl::CacheStats& stats);
    [[nodiscard]] Interest interest(TileIndex index) const;
    [[nodiscard]] bool held(TileIndex index) const;
    [[nodiscard]] std::vector<TileIndex> by_nearness() const;
    [[nodiscard]] bool is_hot(TileIndex index) const;
    [[nodiscard]] bool is_hot(PageIndex page) const;
    [[nodiscard]] bool on_gpu(const Tile& tile) const;
    [[nodiscard]] Tile* find(TileIndex index);
    [[nodiscard]] const Tile* find(TileIndex index) const;

    // tile_cache_stamps.cpp
    [[nodiscard]] Task task_of(const GroundEdit& edit) const;
    void run_or_wait(Task task, gl::StageStats& deform);
    template <class Visit>
    void for_each_tile_of(const Task& task, const Visit& visit) const;
    [[nodiscard]] bool must_wait(const Task& task);
    bool smooth_is_ready(const Task& task);
    void execute(const Task& task, gl::StageStats& deform);
    [[nodiscard]] bool execute_smooth(const Task& task, gl::StageStats& deform);
    void smooth_on_cpu(const Task& task, gl::StageStats& deform);
    Tile& touched(TileIndex index, bool inside);
    void make_fresh(TileIndex index, Tile& tile);
    void apply_to_guests(const PreparedStamp& stamp, TileIndex cold);
    void refill(TileIndex index, Tile& tile, const TexelRect& rect);
    void flush_gpu(gl::StageStats& deform);
    void apply_batch_on_cpu(std::size_t first, gl::StageStats& deform);
    void flush_fills();
    [[nodiscard]] CodeRange range_now(TileIndex index, const TexelRect& rect) const;
    void note_change(const StampRecord& record, const TexelRect& rect, const TileWindow& window);

    // tile_cache_undo.cpp
    [[nodiscard]] Task undo_task_of(const GroundEdit& edit) const;
    void keep_images_of(const Stamp& stamp, TileIndex index, gl::StageStats& deform);
    [[nodiscard]] bool wants_images(const Stamp& stamp) const;
    void keep_saturating_images(const Stamp& stamp, gl::StageStats& deform);
    [[nodiscard]] bool waits_with_all(const Stroke& stroke, std::size_t stamps, TileIndex index) const;
    bool cancel_waiting(const Task& undo);
    void note_undo(const Task& undo);
    void execute_undo(const Task& undo, gl::StageStats& deform);

    // tile_cache_settle.cpp
    Result<void> step(gl::CacheStats& stats, gl::StageStats& deform);
    enum class Waited : std::uint8_t { Reached, NoTextures };
    Result<Waited> wait_until(const std::function<bool()>& reached, const std::set<TileIndex>& tiles,
                              gl::CacheStats& stats, gl::StageStats& deform);
    void read_back_now(TileIndex index, Tile& tile);

    Ground& ground_;
    DetailField& field_;
    TileGrid grid_;
    TileTextures& textures_;
    TileCacheSettings settings_;
    std::map<TileIndex, Tile> tiles_;  ///< those that a stamp ever reached
    std::set<TileIndex> live_;         ///< of them, those that are not absent
    std::set<TileIndex> crowded_;      ///< absent ones with too many stamps waiting
    std::size_t pending_ = 0;          ///< stamps that wait, of all tiles
    std::set<TileIndex> textured_;
    std::set<TileIndex> required_;  ///< by `require`
    std::vector<ViewerTiles> viewers_;
    std::vector<PostPos> viewer_texels_;
    std::deque<Task> deferred_;     ///< smooth that waits for tiles, and what waits behind it
    std::set<TileIndex> awaited_;   ///< tiles of `deferred_`
    std::vector<Stamp> gpu_batch_;  ///< own-texel stamps for the tiles of `gpu_tiles_`, in order
    std::set<TileIndex> gpu_tiles_;
    std::map<TileIndex, std::vector<TexelRect>> fills_;  ///< of this frame's stamps, textures that exist
    std::vector<CachedArrival> arrivals_;
    std::vector<Error> errors_;
    std::vector<std::shared_ptr<DiskRequest>> finished_;  ///< work that was submitted
    ChangeSet changes_;
    Result<void> gpu_outcome_;
    double now_ms_ = 0;
    DiskWorker worker_;  ///< last: it stops before anything it works on goes
};

}  // namespace tilth
