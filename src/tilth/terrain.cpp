#include "tilth/terrain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tilth/core/log.h"
#include "tilth/deform/deformer.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/detail_stage.h"
#include "tilth/executor_choice.h"
#include "tilth/gl/api.h"
#include "tilth/gl/debug_group.h"
#include "tilth/gl/device.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/stage_clock.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/raycast.h"
#include "tilth/ground/stamp_range.h"
#include "tilth/pool/height_planes.h"
#include "tilth/render/height_bounds.h"
#include "tilth/render/terrain_renderer.h"

namespace tilth {
namespace {

/// The stages that need a context, in the order of the data's journey. `device` dies last.
struct GpuStages {
    std::unique_ptr<gl::Device> device;
    std::unique_ptr<gl::ShaderLibrary> shaders;
    std::optional<HeightPlanes> planes;
    std::optional<Deformer> deformer;     ///< executor gpu only
    std::optional<SlopePass> slope_pass;  ///< executor gpu only
    std::optional<SlopeMap> slopes;
    std::optional<TerrainRenderer> renderer;
    std::unique_ptr<DetailStage> detail;  ///< worlds with a detail map
};

}  // namespace

struct Terrain::Impl {
    std::unique_ptr<Ground> ground;
    TerrainSettings settings;
    ExecutorKind executor = ExecutorKind::Cpu;
    std::string executor_reason = "cpu: no GL context";
    std::optional<GpuStages> gpu;
    std::optional<HeightBounds> bounds;
    std::vector<StampRecord> queue;
    std::vector<TexelRect> newer_on_gpu;  ///< where the CPU's coarse codes are out of date
    gl::FrameStats frame, before;         ///< the current frame; all frames before it

    [[nodiscard]] SlopeSettings slope_settings() const {
        const MapGeometry& map = ground->map(MapKind::Coarse);
        return {settings.stencil, map.codec.code_quantum_m(), map.grid.spacing_m};
    }

    Result<void> create_gpu(gl::GetProc get_proc);
    Result<void> choose_executor();
    Result<void> create_stages();

    Result<void> apply_queue(gl::FrameStats& stats);
    Result<void> apply_detail(std::span<const StampRecord> records, gl::FrameStats& stats);
    Result<void> apply_coarse(std::span<const StampRecord> records, gl::FrameStats& stats);
    void apply_on_cpu(std::span<const StampRecord> records, gl::FrameStats& stats, std::vector<TexelRect>& changed);
    Result<void> apply_on_gpu(std::span<const StampRecord> records, gl::FrameStats& stats,
                              std::vector<TexelRect>& changed);
    [[nodiscard]] bool may_saturate(const PreparedStamp& stamp) const;
    void derive(std::span<const TexelRect> changed, gl::FrameStats& stats);
    void read_back(gl::FrameStats& stats);

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
    const HeightField& field = ground->coarse();
    const MapGeometry& map = ground->map(MapKind::Coarse);

    Result<HeightPlanes> planes = HeightPlanes::create(device, field.width(), field.depth(), map.precision);
    if (!planes) return planes.error();
    gpu->planes = std::move(*planes);
    Result<SlopeMap> slopes = SlopeMap::create(device, field.width(), field.depth(), settings.slopes);
    if (!slopes) return slopes.error();
    gpu->slopes = std::move(*slopes);

    if (executor == ExecutorKind::Gpu) {
        Result<Deformer> deformer = Deformer::create(device, *gpu->shaders);
        if (!deformer) return deformer.error();
        gpu->deformer = std::move(*deformer);
        Result<SlopePass> pass =
            SlopePass::create(device, *gpu->shaders, map.precision, settings.slopes, slope_settings());
        if (!pass) return pass.error();
        gpu->slope_pass = std::move(*pass);
        ++before.derive.programs;
    }

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

    bounds.emplace(field);
    gpu->planes->upload(field, field.rect(), before.transfer);
    const TexelRect whole = field.rect();
    derive({&whole, 1}, before);

    if (settings.ground.detail) {
        Result<std::unique_ptr<DetailStage>> detail =
            DetailStage::create(device, *gpu->shaders, *ground, settings, gpu->deformer ? &*gpu->deformer : nullptr);
        if (!detail) return detail.error();
        gpu->detail = std::move(*detail);
    }
    return {};
}

Result<std::unique_ptr<Terrain>> Terrain::create(std::shared_ptr<const HeightSource> source,
                                                 const TerrainSettings& settings, gl::GetProc get_proc) {
    auto impl = std::make_unique<Impl>();
    impl->settings = settings;
    Result<std::unique_ptr<Ground>> ground = Ground::create(std::move(source), settings.ground);
    if (!ground) return ground.error();
    impl->ground = std::move(*ground);
    if (get_proc == nullptr && settings.tiles.store)
        return Error{
            ErrorCode::Unsupported,
            "tiles.store: without a GL context all detail is kept in memory; pass a get-proc function, or no store"};
    if (get_proc != nullptr) {
        if (const Result<void> created = impl->create_gpu(get_proc); !created) return created.error();
    } else if (settings.executor == ExecutorKind::Gpu) {
        return Error{ErrorCode::Unsupported,
                     "executor: gpu needs a GL context; pass its get-proc function, or take cpu"};
    }
    return std::unique_ptr<Terrain>(new Terrain(std::move(impl)));
}

Terrain::Terrain(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Terrain::~Terrain() = default;

// ---- stamps ----

ShapeLibrary& Terrain::shapes() { return impl_->ground->shapes(); }
const Ground& Terrain::ground() const { return *impl_->ground; }

Result<StampRecord> Terrain::stamp(const StampRequest& request) {
    Result<StampRecord> record = impl_->ground->issue(request);
    if (record) impl_->queue.push_back(*record);
    return record;
}

Result<void> Terrain::replay(const StampRecord& record) {
    Result<void> accepted = impl_->ground->accept(record);
    if (accepted) impl_->queue.push_back(record);
    return accepted;
}

Result<void> Terrain::update(double /*dt_s*/) {
    Impl& impl = *impl_;
    impl.before += impl.frame;
    impl.frame = {};
    DetailStage* const detail = impl.gpu ? impl.gpu->detail.get() : nullptr;
    std::optional<gl::StateGuard> guard;
    std::optional<gl::DebugGroup> group;
    if (detail != nullptr && (detail->uses_gl() || !impl.queue.empty())) {
        guard.emplace(*impl.gpu->device);
        group.emplace(*impl.gpu->device, "tilth: detail tiles");
    }
    if (detail != nullptr) detail->begin(impl.frame);
    Result<void> applied = impl.apply_queue(impl.frame);
    if (detail != nullptr) detail->transfer(impl.frame);
    return applied;
}

Result<void> Terrain::Impl::apply_queue(gl::FrameStats& stats) {
    if (gpu && gpu->deformer) gpu->deformer->collect(stats.deform);
    std::vector<StampRecord> coarse, detail;
    for (const StampRecord& record : std::exchange(queue, {}))
        (record.map == MapKind::Coarse ? coarse : detail).push_back(record);
    const Result<void> dented = apply_detail(detail, stats);
    const Result<void> applied = apply_coarse(coarse, stats);
    return applied ? dented : applied;
}

Result<void> Terrain::Impl::apply_detail(std::span<const StampRecord> records, gl::FrameStats& stats) {
    if (records.empty() && !(gpu && gpu->detail && gpu->detail->cache().has_waiting_stamps())) return {};
    if (gpu && gpu->detail) {
        const gl::DebugGroup group(*gpu->device, "tilth: update detail");
        return gpu->detail->stamp(records, stats);
    }
    const gl::StageClock clock(stats.deform);
    for (const StampRecord& record : records) {  // without GL all of the map is in memory
        const ApplyResult result = ground->apply(record);
        stats.deform.texels += result.texels;
        stats.deform.saturated += result.saturated;
    }
    return {};
}

Result<void> Terrain::Impl::apply_coarse(std::span<const StampRecord> coarse, gl::FrameStats& stats) {
    if (coarse.empty()) return {};
    if (!gpu) {
        std::vector<TexelRect> changed;
        apply_on_cpu(coarse, stats, changed);
        return {};
    }
    const gl::StateGuard guard(*gpu->device);
    const gl::DebugGroup group(*gpu->device, "tilth: update");
    std::vector<TexelRect> changed;
    Result<void> applied;
    if (executor == ExecutorKind::Gpu) {
        applied = apply_on_gpu(coarse, stats, changed);
    } else {
        apply_on_cpu(coarse, stats, changed);
        for (const TexelRect& rect : changed) {
            gpu->planes->upload(ground->coarse(), rect, stats.transfer);
            bounds->widen(rect, ground->coarse());
        }
    }
    derive(changed, stats);  // also of the part that was applied before an error
    return applied;
}

void Terrain::Impl::apply_on_cpu(std::span<const StampRecord> records, gl::FrameStats& stats,
                                 std::vector<TexelRect>& changed) {
    const gl::StageClock clock(stats.deform);
    for (const StampRecord& record : records) {
        const ApplyResult result = ground->apply(record);
        stats.deform.texels += result.texels;
        stats.deform.saturated += result.saturated;
        if (!result.rect.empty()) changed.push_back(result.rect);
    }
    changed = disjoint(changed);
}

bool Terrain::Impl::may_saturate(const PreparedStamp& stamp) const {
    const CodeRange old = bounds->query(expanded(stamp.rect(), 1));
    return range_after(stamp, old.min, old.max).may_saturate;
}

Result<void> Terrain::Impl::apply_on_gpu(std::span<const StampRecord> records, gl::FrameStats& stats,
                                         std::vector<TexelRect>& changed) {
    const gl::StageClock clock(stats.deform);
    const MapGeometry& map = ground->map(MapKind::Coarse);
    std::vector<DeformStamp> stamps;
    std::vector<const StampRecord*> placed;
    for (const StampRecord& record : records) {
        const DeformStamp stamp{.prepared = prepare(record, map, ground->shapes())};
        if (stamp.prepared.rect().empty()) continue;
        stamps.push_back(stamp);
        placed.push_back(&record);
    }
    // Bounds of what only the GPU knows are wider than the truth. Before stamps are counted one by one, look.
    if (!newer_on_gpu.empty() && std::any_of(stamps.begin(), stamps.end(),
                                             [&](const DeformStamp& stamp) { return may_saturate(stamp.prepared); })) {
        read_back(stats);
        ++stats.deform.fallbacks;
    }
    for (DeformStamp& stamp : stamps) {
        const TexelRect rect = stamp.prepared.rect();
        // Smooth reads one post further, whose codes may then spread into the rectangle.
        const CodeRange old = bounds->query(expanded(rect, 1));
        const StampRange range = range_after(stamp.prepared, old.min, old.max);
        stamp.may_saturate = range.may_saturate;
        bounds->widen_by(rect, range.min, range.max);
    }
    std::size_t done = 0;
    Result<void> applied = gpu->deformer->apply(stamps, *gpu->planes, stats.deform, done);
    for (std::size_t i = 0; i < done; ++i) changed.push_back(stamps[i].prepared.rect());
    changed = disjoint(changed);
    newer_on_gpu.insert(newer_on_gpu.end(), changed.begin(), changed.end());
    if (newer_on_gpu.size() > 256) newer_on_gpu = disjoint(newer_on_gpu);
    if (applied) return applied;

    Error error = applied.error();
    if (error.code == ErrorCode::Unsupported) {  // no later frame can do it either
        error.message = text("stamp ", placed[done]->sequence, " is dropped: ", error.message);
        ++done;
    }
    std::vector<StampRecord> rest;
    for (std::size_t i = done; i < placed.size(); ++i) rest.push_back(*placed[i]);
    queue.insert(queue.begin(), rest.begin(), rest.end());
    return error;
}

void Terrain::Impl::derive(std::span<const TexelRect> changed, gl::FrameStats& stats) {
    const gl::StageClock clock(stats.derive);
    if (gpu->slope_pass)
        gpu->slope_pass->run(changed, *gpu->planes, *gpu->slopes, stats.derive, stats.mips);
    else
        upload_slopes(changed, ground->coarse(), slope_settings(), *gpu->slopes, stats.derive, stats.mips,
                      stats.transfer);
}

void Terrain::Impl::read_back(gl::FrameStats& stats) {
    if (!gpu || !gpu->deformer) return;
    gpu->deformer->finish(stats.deform);
    if (newer_on_gpu.empty()) return;
    const gl::StateGuard guard(*gpu->device);
    const gl::DebugGroup group(*gpu->device, "tilth: read back");
    for (const TexelRect& rect : disjoint(newer_on_gpu)) {
        gpu->planes->read_back(rect, ground->mutable_coarse(), stats.transfer);
        bounds->widen(rect, ground->coarse());
    }
    newer_on_gpu.clear();
}

Result<void> Terrain::drain() {
    Impl& impl = *impl_;
    std::optional<gl::StateGuard> guard;
    if (impl.gpu) guard.emplace(*impl.gpu->device);
    if (const Result<void> applied = impl.apply_queue(impl.before); !applied) return applied.error();
    impl.read_back(impl.before);
    return impl.with_detail([&](DetailStage& detail) { return detail.settle(impl.before); });
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
    const gl::StateGuard guard(*gpu.device);
    const gl::DebugGroup group(*gpu.device, "tilth: draw");
    DetailView detail;
    if (gpu.detail) {
        const WorldPos eye{view.eye.x, view.eye.z};
        gpu.detail->set_default_viewer(eye);
        detail = gpu.detail->view_from(eye);
    }
    return gpu.renderer->draw(view, shading, cursor, *gpu.planes, *gpu.slopes, *impl_->bounds, impl_->frame.render,
                              &detail);
}

Result<void> Terrain::reload_shaders() {
    if (!impl_->gpu) return {};
    GpuStages& gpu = *impl_->gpu;
    const gl::StateGuard guard(*gpu.device);
    Result<void> result = gpu.renderer->reload(*gpu.shaders);
    if (gpu.slope_pass)
        if (Result<void> reloaded = gpu.slope_pass->reload(*gpu.shaders); !reloaded) result = std::move(reloaded);
    if (gpu.deformer)
        if (Result<void> reloaded = gpu.deformer->reload(); !reloaded) result = std::move(reloaded);
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
    return impl_->gpu && impl_->gpu->detail ? impl_->gpu->detail->cache().take_errors() : std::vector<Error>();
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
    return impl_->ground->bytes() + (pages ? impl_->gpu->detail->waiting_bytes() : 0);
}

std::vector<std::string> Terrain::take_debug_messages() {
    std::vector<std::string> messages;
    if (impl_->gpu)
        for (const gl::DebugMessage& message : impl_->gpu->device->take_debug_messages())
            messages.push_back(message.text);
    return messages;
}

}  // namespace tilth
