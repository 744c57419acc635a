// What do curved triangles cost, and what do they gain at the outline? Frames at 1 600 x 900 with and without, in turn,
// at six places about a smooth hill and about ridged mountains (posts 1 m apart), and the pixels between the drawn
// outline and that of a mesh of all posts. Rows: flat (refinement of rough rings off), refined (the library without
// curves), curved by a half, as is usual, and by 0.75.
#include <map>
#include <numbers>

#include "render/support/outline.h"
#include "support/bench_device.h"
#include "support/picture.h"

namespace tilth::bench {
namespace {

constexpr std::int32_t kPosts = 1025;
enum class Hills { Smooth, Ridged };

struct Row {
    const char* name;
    double refine_above_px;
    double shape;  ///< 0: not curved
};
constexpr Row kRows[] = {{"flat", 1e6, 0}, {"refined", 1, 0}, {"curved_0.5", 1e6, 0.5}, {"curved_0.75", 1e6, 0.75}};

struct Result {
    std::vector<double> ms, ratio;
    double off_px = 0, primitives = 0;
    std::uint64_t hash = 0;
};

std::map<std::string, Result> measured(Hills hills, std::int32_t n) {
    gl::Device& gpu = test::device();
    const test::Mountains ground = hills == Hills::Smooth ? test::smooth_hill(kPosts) : test::mountains(kPosts, 200);
    test::Scene refined(ground.field, ground.codec, {.clipmap = {.n = n, .levels = 5, .blend = 0.1}});
    test::Scene plain(ground.field, ground.codec,
                      {.clipmap = {.n = n, .levels = 5, .blend = 0.1, .refine_above_px = 1e6}});
    test::BruteForceMesh reference(plain);
    const test::Target target(1600, 900);
    gl::Query generated = test::value(gl::Query::create(gpu, "generated", gl::QueryKind::PrimitivesGenerated));
    gl::GpuTimer timer = test::value(gl::GpuTimer::create(gpu, "phong", gl::TimerPolicy::MayFinish));
    std::map<std::string, Result> results;
    constexpr int kPlaces = 6;
    for (int place = -1; place < kPlaces; ++place) {
        const double turn = std::max(place, 0) * std::numbers::pi / 3 + 0.2, far = 200 + 40 * std::max(place, 0);
        View view = plain.view_from(512 + far * std::cos(turn), 512 + far * std::sin(turn), 2,
                                    {-std::cos(turn), 0.1, -std::sin(turn)});
        view.width = target.width(), view.height = target.height();
        const std::vector<std::uint8_t> truth = reference.picture(target, view);
        double flat_ms = 0;
        for (const Row& row : kRows) {
            test::Scene& scene = row.refine_above_px > 1 ? plain : refined;
            const DetailView curved = test::curved(row.shape);
            const DetailView* const detail = row.shape > 0 ? &curved : nullptr;
            target.clear(1, 0, 1);
            generated.begin();
            timer.begin();
            check(scene.draw(view, {}, nullptr, detail));
            timer.end();
            generated.end();
            const double ms = timer.finish_samples_ms().back();
            if (place < 0) continue;
            if (flat_ms == 0) flat_ms = ms;
            Result& result = results[row.name];
            result.ms.push_back(ms);
            result.ratio.push_back(ms / flat_ms);
            result.primitives += static_cast<double>(generated.result()) / kPlaces;
            const std::vector<std::uint8_t> pixels = target.pixels();
            result.off_px += static_cast<double>(test::outline_difference(pixels, truth)) / kPlaces;
            if (place == 0) result.hash = hash_bytes(std::as_bytes(std::span(pixels)));
        }
    }
    make_current();
    return results;
}

void phong_frame(benchmark::State& state, Hills hills, std::int32_t n, std::string name) {
    static std::map<std::pair<Hills, std::int32_t>, std::map<std::string, Result>> all;
    if (!all.contains({hills, n})) all[{hills, n}] = measured(hills, n);
    const Result& result = all[{hills, n}].at(name);
    for (auto _ : state) state.SetIterationTime(percentile(result.ms, 0.5) / 1000);
    state.counters["p50_ms"] = percentile(result.ms, 0.5);
    state.counters["ratio"] = percentile(result.ratio, 0.5);
    state.counters["ratio_p95"] = percentile(result.ratio, 0.95);
    state.counters["outline_off_px"] = result.off_px;
    state.counters["primitives"] = result.primitives;
    report_hash(state, result.hash);
}

const bool kAdded = [] {
    for (const auto& [hills, name] : {std::pair{Hills::Smooth, "smooth"}, {Hills::Ridged, "ridged"}})
        for (const std::int32_t n : {255, 63})
            for (const Row& row : kRows)
                benchmark::RegisterBenchmark(text("phong_frame/", name, "/n", n, "/", row.name).c_str(), phong_frame,
                                             hills, n, std::string(row.name))
                    ->UseManualTime()
                    ->Unit(benchmark::kMillisecond)
                    ->Iterations(1);
    return true;
}();

}  // namespace
}  // namespace tilth::bench
