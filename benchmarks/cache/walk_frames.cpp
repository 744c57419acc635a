// Does a walker notice paging? The longest frame of a walk across tile borders over dented ground against the median
// frame, with the default budget (wanted: at most 1.25), and beside it the same of as many frames in which nothing
// pages: what the machine itself does. Reference layout and clipmap, eye at 2 m, walking pace; the row of tiles that is
// walked along is dented all over, its neighbours in part. The walk goes out, so that tiles are saved and evicted, and
// back, so that they page in; stretches of the way where nothing happens are skipped. A frame is an update, a draw and
// glFinish. Last, with the gpu executor: how long the frame waits that begins a read-back, against a plain glReadPixels
// of the same bytes after the same draw.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>

#include "support/bench_terrain.h"
#include "support/picture.h"
#include "tilth/gl/pixel_store.h"
#include "tilth/source/ridged_source.h"
#include "tilth/store/memory_store.h"

namespace tilth::bench {
namespace {

constexpr double kPace = 0.038 * 30;  // texels a frame: 2.28 m/s at 60 frames a second
constexpr double kBand = 0.1;         // as `TileSettings` has it
constexpr int kLead = 4;              // frames before the place where something begins

/// What happened in a frame, the most costly first.
enum class Event : std::uint8_t { Loaded, Left, Slices, Nothing };
constexpr std::array kEvents{"loaded", "left", "slices", "no_event"};

struct Frame {
    double wall_ms = 0, cpu_ms = 0;
    Event event = Event::Nothing;
};

std::shared_ptr<const HeightSource> ridged_ground() {
    static const std::shared_ptr<const HeightSource> made =
        make_ridged_source({.seed = 7, .size = 4096, .relief_m = 40});
    return made;
}

/// Three rows of six tiles, dented all over; the walk goes along the middle of the middle row.
class DentedWalk {
public:
    explicit DentedWalk(ExecutorKind executor)
        : ground(ridged_ground(), executor, dented_store(executor)), size_(ground.tile_texels()) {
        if (executor == ExecutorKind::Gpu) return;
        // Each tile is dented with its viewer on it, so that the stamps are in it before it leaves.
        for (int x = 0; x < kColumns; ++x) {
            ground.put_viewer(middle_of(x));
            ground.settle();
            ground.stamp(middle_of(x), 1.45 * size_, 0.05);  // reaches all over the tiles round it
            ground.settle();
        }
        ground.leave();
    }

    [[nodiscard]] PostPos middle_of(int column) const { return {(column + 0.5) * size_, 1.5 * size_}; }

    /// `frames` frames from `x` on, one pace each along `direction`.
    void walk(Picture& picture, double x, int frames, double direction, std::vector<Frame>& out) {
        const gl::Api& gl = device().gl();
        for (int i = 0; i < frames; ++i) {
            const PostPos at{x + direction * kPace * i, 1.5 * size_};
            gl.Finish();
            const double wall = wall_ms(), cpu = gl::process_cpu_ms();
            ground.put_viewer(at);
            ground.frame();
            picture.draw(*ground, at_eye_height(*ground, ground.place(at), direction));
            gl.Finish();
            Frame frame{.wall_ms = wall_ms() - wall, .cpu_ms = gl::process_cpu_ms() - cpu};
            const gl::FrameStats& stats = ground->last_frame();
            if (stats.cache.loads > 0)
                frame.event = Event::Loaded;
            else if (stats.cache.evictions > 0 || stats.transfer.bytes_down > 0)
                frame.event = Event::Left;
            else if (stats.transfer.bytes_up > 0)
                frame.event = Event::Slices;
            missing += stats.cache.missing_active;
            out.push_back(frame);
        }
    }
    /// Frames about the places where a tile of column `column` makes the walker want the next, and where he leaves it:
    /// first those across the border into it, then those from before the band's edge until all has come.
    void cross(Picture& picture, int column, double direction, std::vector<Frame>& paging, std::vector<Frame>& quiet) {
        const double border = (direction > 0 ? column : column + 1) * size_;
        walk(picture, border - direction * kLead * kPace, kBorderFrames, direction, paging);
        // The way between is skipped; nothing pages there once what left has been saved.
        ground.put_viewer({border + direction * size_ / 4, 1.5 * size_});
        ground.settle();
        const double band = border + direction * (1 - kBand) / 2 * size_;
        walk(picture, band - direction * kLead * kPace, kBandFrames, direction, paging);
        const double rest = band + direction * (kBandFrames - kLead) * kPace;
        ground.put_viewer({rest, 1.5 * size_});
        ground.settle();
        walk(picture, rest, kBorderFrames + kBandFrames, direction, quiet);
    }

    /// Once through all that is drawn, so that the driver compiles what it does for each number of tiles in sight.
    void warm_up(Picture& picture, int column, double direction) {
        const double border = (direction > 0 ? column : column + 1) * size_;
        const double band = border + direction * (1 - kBand) / 2 * size_;
        std::vector<Frame> unwanted;
        for (const double x : {border - direction * kLead * kPace, band - direction * kLead * kPace}) {
            ground.put_viewer({x, 1.5 * size_});
            ground.settle();
            walk(picture, x, 3 * kLead, direction, unwanted);
        }
    }

    static constexpr int kColumns = 5, kBorderFrames = 2 * kLead, kBandFrames = 8 * kLead;
    BenchTerrain ground;
    std::uint64_t missing = 0;

private:
    /// The cpu executor dents for both: it is the faster one here.
    static std::shared_ptr<TileStore> dented_store(ExecutorKind executor);
    double size_;
};

DentedWalk& walk_of(ExecutorKind executor) {
    static std::map<ExecutorKind, std::unique_ptr<DentedWalk>> all;
    std::unique_ptr<DentedWalk>& made = all[executor];
    if (!made) made = std::make_unique<DentedWalk>(executor);
    return *made;
}

std::shared_ptr<TileStore> DentedWalk::dented_store(ExecutorKind executor) {
    static const std::shared_ptr<TileStore> made = std::make_shared<MemoryStore>();
    if (executor == ExecutorKind::Gpu) walk_of(ExecutorKind::Cpu).ground.leave();
    return made;
}

void report(benchmark::State& state, const char* clock, const std::vector<Frame>& paging,
            const std::vector<Frame>& quiet, double Frame::*time) {
    const auto samples = [&](const std::vector<Frame>& frames) {
        std::vector<double> times;
        for (const Frame& frame : frames) times.push_back(frame.*time);
        return times;
    };
    const std::string prefix = clock;
    const std::vector<double> all = samples(paging), still = samples(quiet);
    for (const auto& [name, share] :
         {std::pair{"p50_ms", 0.5}, {"p95_ms", 0.95}, {"p99_ms", 0.99}, {"longest_ms", 1.0}})
        state.counters[prefix + name] = percentile(all, share);
    state.counters[prefix + "longest_over_p50"] = percentile(all, 1) / percentile(all, 0.5);
    state.counters[prefix + "p99_over_p50"] = percentile(all, 0.99) / percentile(all, 0.5);
    // Less the machine's noise: what the most costly kind of frame takes on the median.
    double worst = 0;
    state.counters[prefix + "quiet_p50_ms"] = percentile(still, 0.5);
    state.counters[prefix + "quiet_longest_over_p50"] = percentile(still, 1) / percentile(still, 0.5);
    for (std::size_t i = 0; i < kEvents.size(); ++i) {
        std::vector<double> times;
        for (const Frame& frame : paging)
            if (frame.event == static_cast<Event>(i)) times.push_back(frame.*time);
        worst = std::max(worst, percentile(times, 0.5));
        state.counters[prefix + kEvents[i] + "_p50_ms"] = percentile(times, 0.5);
        state.counters[prefix + kEvents[i] + "_longest_ms"] = percentile(times, 1);
        if (prefix == "cpu_") state.counters[std::string(kEvents[i]) + "_frames"] = static_cast<double>(times.size());
    }
    state.counters[prefix + "worst_kind_over_quiet"] = worst / percentile(still, 0.5);
}

void walk_frames(benchmark::State& state, ExecutorKind executor) {
    DentedWalk& walk = walk_of(executor);
    Picture picture(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
    walk.ground.put_viewer(walk.middle_of(DentedWalk::kColumns - 1));
    walk.ground.settle();
    constexpr int first = DentedWalk::kColumns - 2;
    walk.warm_up(picture, first, -1);
    walk.ground.put_viewer(walk.middle_of(DentedWalk::kColumns - 1));
    walk.ground.settle();
    walk.missing = 0;
    std::vector<Frame> paging, quiet;
    for (auto _ : state) {
        const double began = wall_ms();
        for (int x = first; x > first - state.range(2); --x) walk.cross(picture, x, -1, paging, quiet);
        state.SetIterationTime((wall_ms() - began) / 1000);
    }
    report(state, "cpu_", paging, quiet, &Frame::cpu_ms);
    report(state, "wall_", paging, quiet, &Frame::wall_ms);
    state.counters["frames"] = static_cast<double>(paging.size());
    state.counters["missing_active"] = static_cast<double>(walk.missing);
    walk.ground.leave();
    report_hash(state, walk.ground.hash());
}

/// Wall time of the update that begins read-backs while the last frame's draw is still queued, as a host without
/// glFinish has it.
void read_back_stall(benchmark::State& state) {
    const BenchTerrain ground(make_ridged_source({.seed = 7, .size = 1400, .relief_m = 40}), ExecutorKind::Gpu);
    const gl::Api& gl = device().gl();
    const std::int32_t size = ground.tile_texels();
    const PostPos middle{0.5 * size, 0.5 * size};
    Picture picture(640, 360);
    // The floor: the same number of bytes out of a texture of a tile's size, whose framebuffer is bound for reading
    // alone: Mesa's software renderer waits for all draws where it is bound for drawing too.
    const gl::Texture2D plane = value(gl::Texture2D::create(device(), "bench plane", {gl::Format::R16, size, size}));
    gl::Framebuffer reader = value(gl::Framebuffer::create(device(), "bench read-back"));
    gl::Buffer buffer = value(
        gl::Buffer::create(device(), "bench read-back", static_cast<std::size_t>(8) << 20, gl::BufferUsage::ReadBack));
    const gl::Texture2D* const planes[] = {&plane};
    reader.attach(planes);
    const auto read_pixels = [&](std::uint64_t bytes) {
        reader.bind_read();
        gl::set_pack(gl);
        buffer.bind(gl::BufferTarget::PixelPack);
        gl.ReadPixels(0, 0, size, static_cast<std::int32_t>(bytes / 2) / size, GL_RED, GL_UNSIGNED_SHORT, nullptr);
        gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    };
    const auto timed_behind_draw = [&](bool drawn, const auto& work) {
        gl.Finish();
        if (drawn) picture.draw(*ground, at_eye_height(*ground, ground.place(middle)));
        const double began = wall_ms(), cpu = gl::process_cpu_ms();
        work();
        const std::pair<double, double> taken{wall_ms() - began, gl::process_cpu_ms() - cpu};
        gl.Finish();
        return taken;
    };
    std::vector<double> stall, plain, alone, wait, stall_cpu, plain_cpu;
    std::uint64_t most_bytes = 0;
    for (auto _ : state) {
        ground.put_viewer(middle);
        ground.settle();
        ground.stamp(middle, 0.48 * size, 0.01);
        ground.settle();
        ground->set_viewers({});
        const double began = wall_ms();
        for (int frame = 0; frame < 12; ++frame) {
            const auto [ms, cpu] = timed_behind_draw(true, [&] { ground.frame(); });
            const std::uint64_t bytes = ground->last_frame().transfer.bytes_down;
            if (bytes == 0) continue;
            most_bytes = std::max(most_bytes, bytes);
            stall.push_back(ms), stall_cpu.push_back(cpu);
            const auto [plain_ms, plain_cpu_ms] = timed_behind_draw(true, [&] { read_pixels(bytes); });
            plain.push_back(plain_ms), plain_cpu.push_back(plain_cpu_ms);
            alone.push_back(timed_behind_draw(false, [&] { read_pixels(bytes); }).first);
            wait.push_back(timed_behind_draw(true, [&] { gl.Finish(); }).first);
        }
        state.SetIterationTime((wall_ms() - began) / 1000);
        ground.leave();
    }
    state.counters["stall_p50_ms"] = percentile(stall, 0.5);
    state.counters["stall_longest_ms"] = percentile(stall, 1);
    state.counters["read_pixels_p50_ms"] = percentile(plain, 0.5);
    state.counters["read_pixels_longest_ms"] = percentile(plain, 1);
    state.counters["ratio"] = percentile(stall, 0.5) / percentile(plain, 0.5);
    state.counters["cpu_ratio"] = percentile(stall_cpu, 0.5) / percentile(plain_cpu, 0.5);
    state.counters["read_pixels_without_draw_p50_ms"] = percentile(alone, 0.5);
    state.counters["draw_alone_p50_ms"] = percentile(wait, 0.5);
    state.counters["frames"] = static_cast<double>(stall.size());
    state.counters["most_MiB_a_frame"] = static_cast<double>(most_bytes) / 1048576;
    report_hash(state, ground.hash());
}

void once(benchmark::internal::Benchmark* bench) {
    bench->ArgNames({"width", "height", "crossings"})->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);
}
BENCHMARK_CAPTURE(walk_frames, cpu, ExecutorKind::Cpu)->Args({640, 360, 3})->Args({1600, 900, 1})->Apply(once);
BENCHMARK_CAPTURE(walk_frames, gpu, ExecutorKind::Gpu)->Args({640, 360, 2})->Apply(once);
BENCHMARK(read_back_stall)
    ->Name("walk_frames/read_back_stall/gpu")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(5);

}  // namespace
}  // namespace tilth::bench
