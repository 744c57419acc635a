// Does a walker notice that the world is being saved? Frames while a save runs against frames of the same walk while
// nothing is written (wanted: at most 1.1 times as long): median, 95th percentile, longest, of wall time and of the CPU
// time of the frame's thread. 1 025 posts 0.1 m apart over 2 x 2 tiles, all dented, all resident; a walker leaves a
// print each fourth frame, a crater on the detail map each seventh and one on the coarse map each 31st. A save is begun
// each 40 frames: with what those frames dented, or with every page of the map changed. A frame is its stamps, an
// update, a draw of 640 x 360 and glFinish; those in which all pages are changed or the store gives space back, and the
// ones after them, count as neither. What only the GPU has is held against a plain glReadPixels of the same number of
// bytes; `stall` once more as a host without glFinish has it: behind a draw that is still queued.
//
// The CPU time of the frame's thread is all of a frame only where it draws too: LP_NUM_THREADS=0 in the environment
// makes llvmpipe do that. Otherwise its own threads draw, and share the cores with the thread that writes.
//
// The stamps depend on the frame's number alone: all rows of one kind leave the hash that a ground without GL, without
// a world on disk and without saves has after the same stamps, or the program ends.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numbers>
#include <set>

#include "store/engines.h"
#include "store/sample_pages.h"
#include "support/bench_device.h"
#include "support/picture.h"
#include "tilth/core/hash.h"
#include "tilth/gl/pixel_store.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth::bench {
namespace {

constexpr std::int32_t kPosts = 1025, kTexelsPerPost = 3, kTile = 2048;
constexpr double kSpacing_m = 0.1, kTexel_m = kSpacing_m / kTexelsPerPost;
constexpr int kWidth = 640, kHeight = 360;
constexpr int kPeriod = 40;  // frames from save to save
constexpr int kBatter = 8;   // of a period: every page is changed
constexpr int kSave = 24;    // of a period: the save is begun
constexpr int kRest = 3;     // frames that still feel what went before
constexpr double kPace_m = 0.038;

double thread_cpu_ms() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

std::shared_ptr<const HeightSource> heights() {
    static const std::shared_ptr<const HeightSource> made =
        make_ridged_source({.seed = 7, .size = kPosts, .relief_m = 8});
    return made;
}

GroundSettings ground_settings() {
    return {.spacing_m = kSpacing_m, .texels_per_post = kTexelsPerPost, .tile_size = kTile};
}

/// What is dented, by number of frame.
class Plan {
public:
    /// `batter`: once a period every page of the detail map is changed.
    explicit Plan(bool batter) : batter_(batter) {}

    /// A circle about the map's middle, well within the region that wants all four tiles.
    [[nodiscard]] static WorldPos walker(int frame) {
        constexpr double middle_m = (kPosts - 1) * kSpacing_m / 2, radius_m = 10;
        const double turn = frame * kPace_m / radius_m;
        return {middle_m + radius_m * std::cos(turn), middle_m + radius_m * std::sin(turn)};
    }
    [[nodiscard]] bool batters(int frame) const { return batter_ && frame % kPeriod == kBatter; }

    [[nodiscard]] std::vector<StampRequest> stamps(int frame, ShapeId boot) const {
        std::vector<StampRequest> all;
        const WorldPos at = walker(frame);
        const auto add = [&](ShapeId shape, WorldPos centre, double radius_m, double amplitude_m, MapChoice map) {
            all.push_back({.shape = shape,
                           .centre = centre,
                           .radius_m = radius_m,
                           .amplitude_m = amplitude_m,
                           .map = map,
                           .rotation_rad = 0.1 * frame,
                           .key = static_cast<std::uint32_t>(frame)});
        };
        const ShapeId bowl{static_cast<std::uint32_t>(BuiltinProfile::Gaussian)};
        if (frame < 0) add(bowl, middle(), 80, -0.1, MapChoice::Detail);
        if (batters(frame)) add(bowl, middle(), 80, frame % 80 < kPeriod ? 0.01 : -0.01, MapChoice::Detail);
        if (frame % 4 == 0) add(boot, at, 0.17, -0.03, MapChoice::Detail);
        const double angle = 2.4 * frame, far_m = 2 + frame % 8;
        const WorldPos near{at.x + far_m * std::cos(angle), at.z + far_m * std::sin(angle)};
        if (frame % 7 == 0) add(bowl, near, 1.5, -0.2, MapChoice::Detail);
        if (frame % 31 == 0) add(bowl, near, 3, -0.3, MapChoice::Coarse);
        return all;
    }

private:
    [[nodiscard]] static WorldPos middle() { return {(kPosts - 1) * kSpacing_m / 2, (kPosts - 1) * kSpacing_m / 2}; }
    bool batter_;
};

/// XXH3-64 of both maps' hashes.
std::uint64_t hash_of(const StateHash& state) {
    const std::uint64_t both[] = {state.coarse, state.detail};
    return hash_bytes(std::as_bytes(std::span(both)));
}

/// What the stamps leave where nothing is drawn and nothing is saved.
std::uint64_t planned_hash(const Plan& plan, int frames) {
    const std::unique_ptr<Ground> ground = value(Ground::create(heights(), ground_settings()));
    const ShapeId boot = value(ground->shapes().bake("boot", kBootTexels, boot_weight));
    for (int frame = -1; frame < frames; ++frame)
        for (const StampRequest& request : plan.stamps(frame, boot)) ground->apply(value(ground->issue(request)));
    return hash_of(ground->hash());
}

/// The floor of a read-back: so many bytes out of a texture of a tile's size into memory, bound for reading alone.
class BareReadBack {
public:
    BareReadBack()
        : plane_(value(gl::Texture2D::create(device(), "bench plane", {gl::Format::R16, kTile, kTile}))),
          reader_(value(gl::Framebuffer::create(device(), "bench read-back"))) {
        const gl::Texture2D* const planes[] = {&plane_};
        reader_.attach(planes);
    }
    void run(std::uint64_t bytes) {
        const gl::Api& gl = device().gl();
        memory_.resize(std::max<std::size_t>(memory_.size(), bytes));
        reader_.bind_read();
        gl::set_pack(gl);
        for (std::uint64_t done = 0; done + 2 <= bytes;) {
            const std::uint64_t texels = (bytes - done) / 2;
            const auto columns = static_cast<std::int32_t>(std::min<std::uint64_t>(texels, kTile));
            const auto rows = static_cast<std::int32_t>(std::min<std::uint64_t>(texels / kTile, kTile));
            gl.ReadPixels(0, 0, columns, std::max(rows, 1), GL_RED, GL_UNSIGNED_SHORT, memory_.data() + done);
            done +=
                std::uint64_t{2} * static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(std::max(rows, 1));
        }
    }

private:
    gl::Texture2D plane_;
    gl::Framebuffer reader_;
    std::vector<std::byte> memory_;
};

enum class Kind : std::uint8_t { Still, Saving, Neither };

struct Frame {
    Kind kind = Kind::Neither;
    double wall_ms = 0, cpu_ms = 0;  ///< of the whole frame; CPU of its thread
    double update_ms = 0;            ///< wall time of `Terrain::update` alone
    double update_cpu_ms = 0;
    gl::FrameStats stats;
};

class SavedWalk {
public:
    SavedWalk(ExecutorKind executor, bool batter) : plan_(batter) {
        TerrainSettings settings{.ground = ground_settings(), .executor = executor};
        settings.world.folder = folder_.make("world");
        terrain_ = value(Terrain::create(heights(), settings, get_proc()));
        boot_ = value(terrain_->shapes().bake("boot", kBootTexels, boot_weight));
        const WorldPos at = Plan::walker(0);
        terrain_->set_viewers({&at, 1});
        for (const StampRequest& request : plan_.stamps(-1, boot_)) value(terrain_->stamp(request));
        check(terrain_->update(1.0 / 60));
        check(terrain_->save());
        while (number_ < 2 * kPeriod) step(false);  // the driver compiles, the store gets its size
        check(terrain_->save());
    }

    /// The next frame. `behind_draw`: its update finds a picture still queued, and nothing is drawn after it.
    Frame step(bool behind_draw) {
        const gl::Api& gl = device().gl();
        const WorldPos at = Plan::walker(number_);
        const bool is_first = number_ % kPeriod == kSave;
        if (is_first) pages_a_save_.push_back(static_cast<double>(pages_.size())), pages_.clear();
        gl.Finish();
        if (behind_draw) picture_.draw(*terrain_, at_eye_height(*terrain_, at));
        Frame frame;
        const double wall = wall_ms(), cpu = thread_cpu_ms();
        terrain_->set_viewers({&at, 1});
        for (const StampRequest& request : plan_.stamps(number_, boot_)) note(value(terrain_->stamp(request)), request);
        if (is_first) terrain_->begin_save();
        const bool saving = terrain_->is_saving();
        const double update = wall_ms(), update_cpu = thread_cpu_ms();
        check(terrain_->update(1.0 / 60));
        frame.update_ms = wall_ms() - update;
        frame.update_cpu_ms = thread_cpu_ms() - update_cpu;
        if (!behind_draw) picture_.draw(*terrain_, at_eye_height(*terrain_, at));
        if (!behind_draw) gl.Finish();
        frame.wall_ms = wall_ms() - wall;
        frame.cpu_ms = thread_cpu_ms() - cpu;
        gl.Finish();
        frame.stats = terrain_->last_frame();
        frame.kind = kind_of(saving, frame.stats);
        ++number_;
        return frame;
    }

    /// Wall time of `work`, and of the same behind a picture that is still queued.
    template <class Work>
    double timed(bool behind_draw, const Work& work) {
        device().gl().Finish();
        if (behind_draw) picture_.draw(*terrain_, at_eye_height(*terrain_, Plan::walker(number_)));
        const double began = wall_ms();
        work();
        const double taken = wall_ms() - began;
        device().gl().Finish();
        return taken;
    }

    /// The hash of what is there; it is that of the plan, also on the disk.
    std::uint64_t finish() {
        check(terrain_->save());
        const std::uint64_t planned = planned_hash(plan_, number_), here = hash_of(value(terrain_->hash()));
        for (const Error& error : terrain_->take_errors()) std::fprintf(stderr, "%s\n", error.message.c_str());
        if (here != planned) {
            std::fprintf(stderr, "tilth-bench: save_frames: the hash is %s, of the same stamps without saves %s\n",
                         hex16(here).c_str(), hex16(planned).c_str());
            std::exit(1);
        }
        return here;
    }

    [[nodiscard]] int number() const { return number_; }
    [[nodiscard]] const std::vector<double>& pages_a_save() const { return pages_a_save_; }

private:
    Kind kind_of(bool saving, const gl::FrameStats& stats) {
        if (stats.store.snapshots > 0) gives_back_ = true;  // until the store says that it has
        if (stats.store.compactions > 0) gives_back_ = false;
        if (saving || gives_back_ || stats.store.compactions > 0 || plan_.batters(number_)) rest_ = kRest;
        if (plan_.batters(number_)) return Kind::Neither;
        if (saving) return Kind::Saving;
        return rest_-- > 0 ? Kind::Neither : (rest_ = 0, Kind::Still);
    }
    void note(const StampRecord& record, const StampRequest& request) {
        if (record.map == MapKind::Coarse) return;
        const auto texel = [](double at_m) { return static_cast<std::int32_t>(std::floor(at_m / kTexel_m)); };
        const TexelRect rect{
            {texel(request.centre.x - request.radius_m), texel(request.centre.z - request.radius_m)},
            {texel(request.centre.x + request.radius_m) + 1, texel(request.centre.z + request.radius_m) + 1}};
        const TexelRect map = terrain_->ground().map(MapKind::Detail).grid.rect();
        for_each_page(pages_of(intersection(rect, map)), [&](PageIndex page) { pages_.insert(page); });
    }

    BenchFolder folder_;
    Plan plan_;
    std::unique_ptr<Terrain> terrain_;
    ShapeId boot_;
    Picture picture_{kWidth, kHeight};
    std::set<PageIndex> pages_;  ///< dented since the last save
    std::vector<double> pages_a_save_;
    int number_ = 0, rest_ = 0;
    bool gives_back_ = false;
};

template <class Value>
std::vector<double> values(const std::vector<Frame>& frames, Kind kind, const Value& of) {
    std::vector<double> found;
    for (const Frame& frame : frames)
        if (frame.kind == kind) found.push_back(of(frame));
    return found;
}

/// Counters `<name>_still_...`, `<name>_saving_...` and their ratios.
template <class Value>
void report(benchmark::State& state, const std::string& name, const std::vector<Frame>& frames, const Value& of) {
    const std::vector<double> still = values(frames, Kind::Still, of), saving = values(frames, Kind::Saving, of);
    for (const auto& [share_name, share] : {std::pair{"p50", 0.5}, {"p95", 0.95}, {"longest", 1.0}}) {
        state.counters[name + "_still_" + share_name + "_ms"] = percentile(still, share);
        state.counters[name + "_saving_" + share_name + "_ms"] = percentile(saving, share);
        state.counters[name + "_ratio_" + share_name] = percentile(saving, share) / percentile(still, share);
    }
}

void report_saves(benchmark::State& state, const std::vector<Frame>& frames, SavedWalk& walk) {
    std::vector<double> snapshot;
    double saves = 0, down = 0, fallbacks = 0, still_fallbacks = 0;
    for (const Frame& frame : frames) {
        saves += static_cast<double>(frame.stats.store.snapshots);
        if (frame.stats.store.snapshot_ms > 0) snapshot.push_back(frame.stats.store.snapshot_ms);
        const bool saving = frame.kind == Kind::Saving;
        if (saving) down += static_cast<double>(frame.stats.transfer.bytes_down);
        (saving ? fallbacks : still_fallbacks) += static_cast<double>(frame.stats.fallbacks());
    }
    const std::vector<double> all = values(frames, Kind::Saving, [](const Frame&) { return 1.0; });
    state.counters["saves"] = saves;
    state.counters["frames_a_save"] = static_cast<double>(all.size()) / saves;
    state.counters["pages_a_save"] = percentile(walk.pages_a_save(), 0.5);
    state.counters["snapshot_p50_ms"] = percentile(snapshot, 0.5);
    state.counters["snapshot_longest_ms"] = percentile(snapshot, 1);
    state.counters["fallbacks_a_save"] = fallbacks / saves;
    state.counters["fallbacks_without"] = still_fallbacks;
    state.counters["read_back_KiB_a_save"] = down / saves / 1024;
}

/// Updates that read back for a save, and what reading so many bytes costs by itself.
struct ReadBacks {
    std::vector<double> update_ms, floor_ms, bytes;

    void report(benchmark::State& state, const std::string& name) const {
        if (update_ms.empty()) return;
        state.counters[name + "_update_p50_ms"] = percentile(update_ms, 0.5);
        state.counters[name + "_update_longest_ms"] = percentile(update_ms, 1);
        state.counters[name + "_read_pixels_p50_ms"] = percentile(floor_ms, 0.5);
        state.counters[name + "_read_pixels_longest_ms"] = percentile(floor_ms, 1);
        state.counters[name + "_KiB_p50"] = percentile(bytes, 0.5) / 1024;
    }
};

/// Frames of `saves` periods. Of those that read back for a save, the floor in turn: *ahead* of the snapshot what
/// the GPU alone has begins to come; the frame that takes it reads the *rest*, and waits for it.
void run(benchmark::State& state, ExecutorKind executor, bool batter, bool behind_draw) {
    SavedWalk walk(executor, batter);
    BareReadBack bare;
    std::vector<Frame> frames;
    ReadBacks ahead, rest;
    std::vector<double> wait;
    const int first = walk.number(), count = static_cast<int>(state.range(0)) * kPeriod;
    for (auto _ : state) {
        const double began = wall_ms();
        while (walk.number() < first + count) {
            frames.push_back(walk.step(behind_draw));
            const Frame& frame = frames.back();
            const std::uint64_t bytes = frame.stats.transfer.bytes_down;
            if (frame.kind != Kind::Saving || bytes == 0) continue;
            ReadBacks& kind = frame.stats.store.snapshot_ms > 0 ? rest : ahead;
            kind.update_ms.push_back(frame.update_ms);
            kind.bytes.push_back(static_cast<double>(bytes));
            kind.floor_ms.push_back(walk.timed(behind_draw, [&] { bare.run(bytes); }));
            if (behind_draw) wait.push_back(walk.timed(true, [] { device().gl().Finish(); }));
        }
        state.SetIterationTime((wall_ms() - began) / 1000);
    }
    if (!behind_draw) {
        report(state, "wall", frames, [](const Frame& frame) { return frame.wall_ms; });
        report(state, "cpu", frames, [](const Frame& frame) { return frame.cpu_ms; });
    }
    report(state, "update_wall", frames, [](const Frame& frame) { return frame.update_ms; });
    report(state, "update_cpu", frames, [](const Frame& frame) { return frame.update_cpu_ms; });
    report_saves(state, frames, walk);
    ahead.report(state, "ahead");
    rest.report(state, "rest");
    if (!wait.empty()) state.counters["draw_alone_p50_ms"] = percentile(wait, 0.5);
    report_hash(state, walk.finish());
}

void save_frames(benchmark::State& state, ExecutorKind executor, bool batter) { run(state, executor, batter, false); }
void stall(benchmark::State& state, bool batter) { run(state, ExecutorKind::Gpu, batter, true); }

void once(benchmark::internal::Benchmark* bench) {
    bench->ArgName("saves")->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);
}
BENCHMARK_CAPTURE(save_frames, cpu_walk, ExecutorKind::Cpu, false)->Arg(12)->Apply(once);
BENCHMARK_CAPTURE(save_frames, cpu_all_pages, ExecutorKind::Cpu, true)->Arg(8)->Apply(once);
BENCHMARK_CAPTURE(save_frames, gpu_walk, ExecutorKind::Gpu, false)->Arg(12)->Apply(once);
BENCHMARK_CAPTURE(save_frames, gpu_all_pages, ExecutorKind::Gpu, true)->Arg(8)->Apply(once);
BENCHMARK_CAPTURE(stall, gpu_walk, false)->Name("save_frames/stall_gpu_walk")->Arg(12)->Apply(once);
BENCHMARK_CAPTURE(stall, gpu_all_pages, true)->Name("save_frames/stall_gpu_all_pages")->Arg(8)->Apply(once);

}  // namespace
}  // namespace tilth::bench
