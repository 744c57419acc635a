#include "tilth/terrain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tilth/coarse_stage.h"
#include "tilth/core/log.h"
#include "tilth/detail_stage.h"
#include "tilth/executor_choice.h"
#include "tilth/gl/api.h"
#include "tilth/gl/debug_group.h"
#include "tilth/gl/device.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/stage_clock.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/apply_edit.h"
#include "tilth/ground/before_image.h"
#include "tilth/ground/raycast.h"
#include "tilth/render/relief_reach.h"
#include "tilth/render/terrain_renderer.h"
#include "tilth/store/editor.h"
#include "tilth/store/world_folder.h"
#include "tilth/world_stage.h"

namespace tilth {
namespace {

/// The stages that need a context, in the order of the data's journey. `device` dies last.
struct GpuStages {
    std::unique_ptr<gl::Device> device;
    std::unique_ptr<gl::ShaderLibrary> shaders;
    std::unique_ptr<CoarseStage> coarse;
    std::optional<TerrainRenderer> renderer;
    std::unique_ptr<DetailStage> detail;  ///< worlds with a detail map
};

/// Whether there is ground about the eye in which a backend can show relief.
Result<void> has_room(const TerrainSettings& terrain, const DetailSettings& detail) {
    if (detail.backend == DetailBackend::None || !terrain.ground.detail || !check_clipmap(terrain.clipmap)) return {};
    const std::int32_t texels = terrain.ground.texels_per_post;
    if (relief_reach(terrain.clipmap, 1, texels, 1, 1e9).reach_m >= 1) return {};
    return Error{
        ErrorCode::InvalidArgument,
        text("detail.backend: ", name_of(detail.backend), " has not even a post about the eye to show relief in, with ",
             texels, " texels a post and clipmap { n = ", terrain.clipmap.n, ", blend = ", terrain.clipmap.blend,
             " }; take fewer texels a post, a larger n or a smaller blend")};
}

/// Whether a context has what a way of showing detail takes.
Result<void> can_show(const gl::Capabilities& capabilities, const DetailSettings& settings) {
    const bool backend = settings.backend == DetailBackend::Tessellation || settings.backend == DetailBackend::Hybrid;
    if (capabilities.tessellation || !(backend || settings.phong.on)) return {};
    return Error{ErrorCode::Unsupported,
                 text(backend ? text("detail.backend: ", name_of(settings.backend)) : std::string("detail.phong.on"),
                      " needs hardware tessellation (GL 4.0), which ", capabilities.renderer,
                      " has not; take geometry or parallax, or leave it out")};
}

}  // namespace

struct Terrain::Impl {
    std::unique_ptr<Ground> ground;
    TerrainSettings settings;
    ExecutorKind executor = ExecutorKind::Cpu;
    std::string executor_reason = "cpu: no GL context";
    std::unique_ptr<Editor> editor;
    std::optional<GpuStages> gpu;
    std::unique_ptr<WorldStage> world;  ///< worlds on disk
    gl::FrameStats frame, before;       ///< the current frame; all frames before it
    ChangeSet changes;                  ///< of the current frame; of the detail map only where all of it is in memory
    std::vector<Change> published;

    Result<void> create_gpu(gl::GetProc get_proc);
    Result<void> choose_executor();
    Result<void> create_stages();

    Result<void> open_world(RecoveredWorld& recovered);
    Result<void> recover(RecoveredWorld& recovered);

    Result<void> apply_queue(gl::FrameStats& stats);
    void publish();
    Result<void> apply_detail(std::span<const GroundEdit> edits, gl::FrameStats& stats);
    Result<void> apply_coarse(std::span<const GroundEdit> edits, gl::FrameStats& stats);
    void apply_to_ground(MapKind map, std::span<const GroundEdit> edits, gl::FrameStats& stats);
    void read_back(gl::FrameStats& stats);
    Result<void> drain();

    /// Holds the context's state while `action()` runs, where there is a context.
    template <class Action>
    auto guarded(const char* label, const Action& action) {
        std::optional<gl::StateGuard> guard;
        std::optional<gl::DebugGroup> group;
        if (gpu) {
            guard.emplace(*gpu->device);
            group.emplace(*gpu->device, label);
        }
        return action();
    }
    /// Calls `action(detail stage, statistics outside frames)` where there is one.
    template <class Action>
    auto with_detail(const Action& action) -> decltype(action(*gpu->detail)) {
        if (!gpu || !gpu->detail) return {};
        const gl::StateGuard guard(*gpu->device);
        const gl::DebugGroup group(*gpu->device, "tilth: detail");
        return action(*gpu->detail);
    }
};

// ---- creation ----

Result<void> Terrain::Impl::create_gpu(gl::GetProc get_proc) {
    gpu.emplace();
    Result<std::unique_ptr<gl::Device>> device =
        gl::Device::create(get_proc, {.collect_debug_messages = settings.collect_debug_messages});
    if (!device) return device.error();
    gpu->device = std::move(*device);
    const gl::StateGuard guard(*gpu->device);
    const gl::DebugGroup group(*gpu->device, "tilth: create");
    gpu->shaders = std::make_unique<gl::ShaderLibrary>(
        *gpu->device, settings.shader_folder.empty() ? gl::ShaderSource::embedded()
                                                     : gl::ShaderSource::folder(settings.shader_folder));
    if (const Result<void> chosen = choose_executor(); !chosen) return chosen.error();
    return create_stages();
}

Result<void> Terrain::Impl::choose_executor() {
    executor = settings.executor;
    executor_reason = executor == ExecutorKind::Gpu ? "gpu: as asked for" : "cpu: as asked for";
    if (executor != ExecutorKind::Automatic) return {};
    const std::uint64_t linked_before = gpu->shaders->programs_linked();
    const Result<ExecutorTimes> times =
        measure_executors(*gpu->device, *gpu->shaders, settings.ground.precision, settings.slopes);
    before.deform.programs += gpu->shaders->programs_linked() - linked_before;
    if (!times) return times.error();
    executor = times->gpu_is_faster() ? ExecutorKind::Gpu : ExecutorKind::Cpu;
    executor_reason = times->reason();
    log(LogLevel::Info, executor_reason);
    return {};
}

Result<void> Terrain::Impl::create_stages() {
    gl::Device& device = *gpu->device;
    if (const Result<void> able = can_show(device.capabilities(), settings.detail); !able) return able.error();
    const HeightField& field = ground->coarse();
    const MapGeometry& map = ground->map(MapKind::Coarse);
    Result<std::unique_ptr<CoarseStage>> coarse =
        CoarseStage::create(device, *gpu->shaders, *ground, settings, executor, before);
    if (!coarse) return coarse.error();
    gpu->coarse = std::move(*coarse);
    if (settings.publish_changes) gpu->coarse->publish_to(&changes);

    const MapInfo info{.grid = {.origin = map.grid.origin,
                                .spacing_m = map.grid.spacing_m,
                                .width = field.width(),
                                .depth = field.depth()},
                       .codec = map.codec,
                       .precision = map.precision,
                       .slopes = settings.slopes,
                       .mirrored = settings.ground.mirror};
    const std::uint64_t linked_before = gpu->shaders->programs_linked();
    Result<TerrainRenderer> renderer = TerrainRenderer::create(device, *gpu->shaders, settings.clipmap, info);
    if (!renderer) return renderer.error();
    gpu->renderer = std::move(*renderer);
    before.render.programs += gpu->shaders->programs_linked() - linked_before;

    if (settings.ground.detail) {
        Result<std::unique_ptr<DetailStage>> detail =
            DetailStage::create(device, *gpu->shaders, *ground, settings, gpu->coarse->deformer());
        if (!detail) return detail.error();
        gpu->detail = std::move(*detail);
    }
    return {};
}

/// Before there are any stages: the pages of the coarse map, and without GL those of the detail map.
Result<void> Terrain::Impl::open_world(RecoveredWorld& recovered) {
    std::shared_ptr<WorldFolder> folder;
    if (!settings.world.folder.empty()) {
        Result<std::shared_ptr<WorldFolder>> opened =
            WorldFolder::open(settings.world.folder, *ground, settings.world.options, recovered);
        if (!opened) return opened.error();
        folder = std::move(*opened);
        for (const Page& page : recovered.coarse) put_page(ground->mutable_coarse(), page.index, *page.codes);
    }
    editor = std::make_unique<Editor>(*ground, folder, settings.undo_bytes);
    return {};
}

/// The rest: what waits for tiles, undo, and the edits that the pages do not hold.
Result<void> Terrain::Impl::recover(RecoveredWorld& recovered) {
    DetailStage* const detail = gpu ? gpu->detail.get() : nullptr;
    world = std::make_unique<WorldStage>(*ground, *editor, settings.world, gpu ? gpu->coarse.get() : nullptr, detail);
    if (const Result<void> queued = editor->recover(recovered); !queued) return queued.error();
    if (detail != nullptr) {
        detail->cache().restore_waiting(recovered.waiting, editor->history());
    } else if (const Result<void> restored = world->restore_detail(recovered); !restored) {
        return restored.error();
    }
    world->report(std::move(recovered.reports));
    if (recovered.repaired > 0) world->begin_save();  // or the next opening would have to do it again
    // What the GPU refuses, the CPU has done: told, and no reason to leave the world closed.
    if (const Result<void> applied = apply_queue(before); !applied) world->report({applied.error()});
    return {};
}

Result<std::unique_ptr<Terrain>> Terrain::create(std::shared_ptr<const HeightSource> source,
                                                 const TerrainSettings& settings, gl::GetProc get_proc) {
    auto impl = std::make_unique<Impl>();
    impl->settings = settings;
    if (const Result<void> checked = check_detail(settings.detail); !checked) return checked.error();
    if (const Result<void> fits = has_room(settings, settings.detail); !fits) return fits.error();
    Result<std::unique_ptr<Ground>> ground = Ground::create(std::move(source), settings.ground);
    if (!ground) return ground.error();
    impl->ground = std::move(*ground);
    if (settings.tiles.store && !settings.world.folder.empty())
        return Error{
            ErrorCode::InvalidArgument,
            "tiles.store: a world's folder keeps its own tiles; leave one of the two out (a store for worlds is "
            "world.options.blobs)"};
    if (settings.world.snapshot_edits == 0)
        return Error{ErrorCode::InvalidArgument, "world.snapshot_edits: 0 is not at least 1"};
    if (get_proc == nullptr && settings.tiles.store)
        return Error{
            ErrorCode::Unsupported,
            "tiles.store: without a GL context all detail is kept in memory; pass a get-proc function, or no store"};
    RecoveredWorld recovered;
    if (const Result<void> opened = impl->open_world(recovered); !opened) return opened.error();
    if (impl->editor->world() != nullptr && settings.ground.detail) impl->settings.tiles.store = impl->editor->world();
    if (get_proc != nullptr) {
        if (const Result<void> created = impl->create_gpu(get_proc); !created) return created.error();
    } else if (settings.executor == ExecutorKind::Gpu) {
        return Error{ErrorCode::Unsupported,
                     "executor: gpu needs a GL context; pass its get-proc function, or take cpu"};
    }
    if (impl->editor->world() != nullptr) {
        const Result<void> recovering = impl->guarded("tilth: open world", [&] { return impl->recover(recovered); });
        if (!recovering) return recovering.error();
    }
    return std::unique_ptr<Terrain>(new Terrain(std::move(impl)));
}

Terrain::Terrain(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Terrain::~Terrain() = default;

// ---- stamps ----

ShapeLibrary& Terrain::shapes() { return impl_->ground->shapes(); }
const Ground& Terrain::ground() const { return *impl_->ground; }

Result<StampRecord> Terrain::stamp(const StampRequest& request) { return impl_->editor->stamp(request); }
Result<void> Terrain::replay(const StampRecord& record) { return impl_->editor->replay(record); }
void Terrain::begin_stroke() { impl_->editor->begin_stroke(); }
void Terrain::end_stroke() { impl_->editor->end_stroke(); }
Result<void> Terrain::undo() { return impl_->editor->undo(); }
Result<void> Terrain::redo() { return impl_->editor->redo(); }
std::size_t Terrain::undoable() const { return impl_->editor->history().undoable(); }
std::size_t Terrain::redoable() const { return impl_->editor->history().redoable(); }

Result<void> Terrain::update(double /*dt_s*/) {
    Impl& impl = *impl_;
    impl.before += impl.frame;
    impl.frame = {};
    DetailStage* const detail = impl.gpu ? impl.gpu->detail.get() : nullptr;
    std::optional<gl::StateGuard> guard;
    std::optional<gl::DebugGroup> group;
    if (impl.gpu && ((detail != nullptr && detail->uses_gl()) || !impl.editor->is_empty())) {
        guard.emplace(*impl.gpu->device);
        group.emplace(*impl.gpu->device, "tilth: update");
    }
    if (detail != nullptr) detail->begin(impl.frame);
    Result<void> applied = impl.apply_queue(impl.frame);
    impl.publish();
    if (detail != nullptr) detail->transfer(impl.frame);
    if (impl.world) impl.world->update(impl.frame);
    return applied;
}

const std::vector<Change>& Terrain::changes() const { return impl_->published; }

void Terrain::Impl::publish() {
    if (!settings.publish_changes) return;
    published = changes.changes();
    changes.clear();
    if (!gpu || !gpu->detail) return;
    const std::vector<Change>& of_tiles = gpu->detail->cache().changes().changes();
    published.insert(published.end(), of_tiles.begin(), of_tiles.end());
    gpu->detail->cache().forget_changes();
}

Result<void> Terrain::Impl::apply_queue(gl::FrameStats& stats) {
    if (gpu) gpu->coarse->collect(stats.deform);
    const std::vector<GroundEdit> edits = editor->take_queue();
    if (world) world->note(edits);
    std::vector<GroundEdit> coarse, detail;
    for (const GroundEdit& edit : edits) {
        if (concerns(edit, MapKind::Coarse)) coarse.push_back(edit);
        if (concerns(edit, MapKind::Detail)) detail.push_back(edit);
    }
    const Result<void> dented = apply_detail(detail, stats);
    const Result<void> applied = apply_coarse(coarse, stats);
    editor->applied();
    return applied ? dented : applied;
}

Result<void> Terrain::Impl::apply_detail(std::span<const GroundEdit> edits, gl::FrameStats& stats) {
    if (edits.empty() && !(gpu && gpu->detail && gpu->detail->cache().has_waiting_edits())) return {};
    if (gpu && gpu->detail) return gpu->detail->apply(edits, stats);
    apply_to_ground(MapKind::Detail, edits, stats);  // without GL all of the map is in memory
    return {};
}

Result<void> Terrain::Impl::apply_coarse(std::span<const GroundEdit> edits, gl::FrameStats& stats) {
    if (edits.empty()) return {};
    if (gpu) return gpu->coarse->apply(edits, stats);
    apply_to_ground(MapKind::Coarse, edits, stats);
    return {};
}

void Terrain::Impl::apply_to_ground(MapKind map, std::span<const GroundEdit> edits, gl::FrameStats& stats) {
    const gl::StageClock clock(stats.deform);
    const TileGrid grid{.size = settings.ground.tile_size, .map = ground->map(MapKind::Detail).grid.rect()};
    const auto range = [&](const TexelRect& rect) {
        return map == MapKind::Coarse ? range_in(ground->coarse(), rect) : range_in(ground->detail(), rect);
    };
    const auto note = [&](const ChangedRect& changed) {
        if (changed.map == MapKind::Coarse)
            return changes.note(map, {}, changed.rect, range(changed.rect), changed.sequence, changed.sequence);
        for_each_tile(tiles_of(grid, changed.rect), [&](TileIndex tile) {
            const TexelRect part = intersection(changed.rect, grid.inside(tile));
            changes.note(map, tile, part, range(part), changed.sequence, changed.sequence);
        });
    };
    for (const GroundEdit& edit : edits) {
        if (settings.publish_changes)
            for (const ChangedRect& changed : changed_by(*ground, edit))
                if (changed.map == map) note(changed);
        const ApplyResult result = apply_edit(*ground, map, edit);
        stats.deform.texels += result.texels;
        stats.deform.saturated += result.saturated;
    }
    changes.finish(map, [&](const Change& change) { return range(change.rect); });
}

void Terrain::Impl::read_back(gl::FrameStats& stats) {
    if (gpu && gpu->coarse->is_ahead()) guarded("tilth: read back", [&] { gpu->coarse->read_back(stats); });
}

Result<void> Terrain::Impl::drain() {
    if (const Result<void> applied = apply_queue(before); !applied) return applied.error();
    read_back(before);
    return with_detail([&](DetailStage& detail) { return detail.settle(before); });
}

Result<void> Terrain::drain() {
    return impl_->guarded("tilth: drain", [&] { return impl_->drain(); });
}

// ---- the world on disk ----

Result<void> Terrain::flush() { return impl_->editor->world() ? impl_->editor->world()->flush() : Result<void>(); }

Result<void> Terrain::save() {
    Impl& impl = *impl_;
    return impl.guarded("tilth: save", [&]() -> Result<void> {
        if (const Result<void> drained = impl.drain(); !drained) return drained.error();
        return impl.world ? impl.world->save(impl.before) : Result<void>();
    });
}

void Terrain::begin_save() {
    if (impl_->world) impl_->world->begin_save();
}

bool Terrain::is_saving() const { return impl_->world && impl_->world->is_saving(); }

std::optional<WorldReport> Terrain::world() const {
    const std::shared_ptr<WorldFolder>& folder = impl_->editor->world();
    if (folder == nullptr) return std::nullopt;
    const WorldFolder::Size size = folder->size();
    return WorldReport{.edits = impl_->editor->edits(),
                       .durable = folder->durable(),
                       .committed = folder->committed(),
                       .journal_bytes = size.journal_bytes,
                       .page_bytes = size.page_bytes};
}

void Terrain::abandon_world() {
    if (impl_->editor->world()) impl_->editor->world()->abandon();
}

// ---- drawing ----

Result<void> Terrain::draw(const View& view, const Shading& shading, const BrushCursor* cursor) {
    if (!impl_->gpu) return Error{ErrorCode::Unsupported, "draw: this terrain was created without a GL context"};
    GpuStages& gpu = *impl_->gpu;
    if (gpu.device->gl().CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        return Error{
            ErrorCode::InvalidArgument,
            "draw: the bound draw framebuffer is not complete (a surfaceless context has none of its own); bind one "
            "with colour and depth"};
    const DetailSettings& settings = impl_->settings.detail;
    DetailView detail;
    detail.settings = settings;
    if (gpu.detail) {
        const WorldPos eye{view.eye.x, view.eye.z};
        gpu.detail->set_default_viewer(eye);
        // The relief window has framebuffers of its own: what the host has bound is put back before it is drawn to.
        std::optional<gl::StateGuard> guard;
        if (settings.backend != DetailBackend::None && gpu.detail->uses_gl()) guard.emplace(*gpu.device);
        Result<DetailView> shown = gpu.detail->view_from(eye, settings, impl_->frame);
        if (!shown) return shown.error();
        detail = std::move(*shown);
    }
    const gl::StateGuard guard(*gpu.device);
    const gl::DebugGroup group(*gpu.device, "tilth: draw");
    return gpu.renderer->draw(view, shading, cursor, gpu.coarse->planes(), gpu.coarse->slopes(), gpu.coarse->bounds(),
                              impl_->frame.render, &detail);
}

Result<void> Terrain::set_detail(const DetailSettings& settings) {
    if (const Result<void> checked = check_detail(settings); !checked) return checked.error();
    if (const Result<void> fits = has_room(impl_->settings, settings); !fits) return fits.error();
    if (impl_->gpu)
        if (const Result<void> able = can_show(impl_->gpu->device->capabilities(), settings); !able)
            return able.error();
    impl_->settings.detail = settings;
    return {};
}

const DetailSettings& Terrain::detail() const { return impl_->settings.detail; }

Result<void> Terrain::reload_shaders() {
    if (!impl_->gpu) return {};
    GpuStages& gpu = *impl_->gpu;
    const gl::StateGuard guard(*gpu.device);
    Result<void> result = gpu.renderer->reload(*gpu.shaders);
    if (Result<void> reloaded = gpu.coarse->reload(*gpu.shaders); !reloaded) result = std::move(reloaded);
    if (gpu.detail)
        if (Result<void> reloaded = gpu.detail->reload(*gpu.shaders); !reloaded) result = std::move(reloaded);
    return result;
}

// ---- queries ----

double Terrain::height_m(WorldPos at, MapSelect select) {
    Impl& impl = *impl_;
    impl.read_back(impl.before);
    const DetailStage* const detail = impl.gpu ? impl.gpu->detail.get() : nullptr;
    if (detail != nullptr && select != MapSelect::Coarse && !detail->is_in_field(at)) {
        const Result<void> here = impl.with_detail([&](DetailStage& stage) { return stage.require(at, impl.before); });
        if (!here) return std::numeric_limits<double>::quiet_NaN();
    }
    return impl.ground->height_m(at, select);
}

std::optional<double> Terrain::raycast(const Vec3d& from, const Vec3d& direction, double max_m) {
    Impl& impl = *impl_;
    impl.read_back(impl.before);
    DetailStage* const detail = impl.gpu ? impl.gpu->detail.get() : nullptr;
    if (detail == nullptr) return tilth::raycast(*impl.ground, from, direction, max_m);
    // As far as the ground is in memory, then one tile more. The tiles before it are asked for again with it: else they
    // might go while it comes.
    std::vector<TileIndex> needed;
    for (const auto& [distance_m, tile] : detail->tiles_along(from, direction, max_m)) {
        needed.push_back(tile);
        if (detail->cache().is_in_field(tile)) continue;
        if (distance_m > 0)
            if (const auto hit = tilth::raycast(*impl.ground, from, direction, distance_m)) return hit;
        const Result<void> here =
            impl.with_detail([&](DetailStage& stage) { return stage.require(needed, impl.before); });
        if (!here) return std::nullopt;
    }
    return tilth::raycast(*impl.ground, from, direction, max_m);
}

Result<StateHash> Terrain::hash() {
    Impl& impl = *impl_;
    impl.read_back(impl.before);
    if (!impl.gpu || !impl.gpu->detail) return impl.ground->hash();
    const gl::StateGuard guard(*impl.gpu->device);
    const gl::DebugGroup group(*impl.gpu->device, "tilth: hash");
    const Result<std::uint64_t> detail = impl.gpu->detail->hash(impl.before);
    if (!detail) return detail.error();
    return StateHash{impl.ground->coarse_hash(), *detail};
}

// ---- tiles ----

void Terrain::set_viewers(std::span<const WorldPos> viewers) {
    if (impl_->gpu && impl_->gpu->detail) impl_->gpu->detail->set_viewers(viewers);
}

std::vector<TileReport> Terrain::tiles() const {
    std::vector<TileReport> reports;
    if (!impl_->gpu || !impl_->gpu->detail) return reports;
    for (const CachedTile& tile : impl_->gpu->detail->cache().tiles())
        reports.push_back({tile.tile, tile.state, tile.interest, tile.modified, tile.pending});
    return reports;
}

TileGrid Terrain::tile_grid() const {
    if (impl_->gpu && impl_->gpu->detail) return impl_->gpu->detail->cache().grid();
    return {.size = impl_->ground->settings().tile_size,
            .apron = impl_->settings.tiles.apron,
            .map = impl_->ground->map(MapKind::Detail).grid.rect()};
}

std::vector<TileArrival> Terrain::take_arrivals() {
    std::vector<TileArrival> arrivals;
    if (!impl_->gpu || !impl_->gpu->detail) return arrivals;
    const double spacing_m = impl_->ground->map(MapKind::Detail).grid.spacing_m;
    for (const CachedArrival& arrival : impl_->gpu->detail->cache().take_arrivals())
        arrivals.push_back({arrival.tile, arrival.lead_texels * spacing_m, arrival.loading_ms});
    return arrivals;
}

std::vector<Error> Terrain::take_errors() {
    std::vector<Error> errors;
    if (impl_->world) errors = impl_->world->take_errors();
    if (impl_->gpu && impl_->gpu->detail)
        for (Error& error : impl_->gpu->detail->cache().take_errors()) errors.push_back(std::move(error));
    return errors;
}

std::uint64_t Terrain::tile_gpu_bytes() const {
    return impl_->gpu && impl_->gpu->detail ? impl_->gpu->detail->tile_bytes() : 0;
}

// ---- reports ----

ExecutorKind Terrain::executor() const { return impl_->executor; }
const std::string& Terrain::executor_reason() const { return impl_->executor_reason; }

std::string Terrain::renderer() const {
    return impl_->gpu ? impl_->gpu->device->capabilities().renderer : std::string();
}

std::string Terrain::gl_version() const {
    if (!impl_->gpu) return {};
    const gl::Version version = impl_->gpu->device->capabilities().version;
    return text(version.major, ".", version.minor);
}

const gl::FrameStats& Terrain::last_frame() const { return impl_->frame; }

gl::FrameStats Terrain::total() const {
    gl::FrameStats sum = impl_->before;
    sum += impl_->frame;
    return sum;
}

std::uint64_t Terrain::gpu_bytes() const { return impl_->gpu ? impl_->gpu->device->resident_bytes() : 0; }
std::uint64_t Terrain::cpu_bytes() const {
    const bool pages = impl_->gpu && impl_->gpu->detail;  // the ground counts its pages, the cache what waits for them
    return impl_->ground->bytes() + impl_->editor->history().bytes() +
           (pages ? impl_->gpu->detail->waiting_bytes() : 0);
}

std::vector<std::string> Terrain::take_debug_messages() {
    std::vector<std::string> messages;
    if (impl_->gpu)
        for (const gl::DebugMessage& message : impl_->gpu->device->take_debug_messages())
            messages.push_back(message.text);
    return messages;
}

}  // namespace tilth
