// What does it cost to keep the relief window about the eye? Draws of 64 x 36 pixels of the dented reference ground
// with backend hybrid that had to fill something, against draws that had not, in turn: all of the window after a jump
// beyond it, what comes in on a step of 64 texels, a stamp of 64 texels. Then a walk of 10 m, 5 cm a frame, at 640 x
// 360: longest frame and median.
#include <cmath>

#include "render/relief_scene.h"
#include "support/picture.h"

namespace tilth::bench {
namespace {

constexpr double kTexel_m = kReferenceSpacing_m / 3;

Terrain& dented() {
    static const std::unique_ptr<Terrain> made = [] {
        std::unique_ptr<Terrain> fresh = reference_terrain();
        make_dents(*fresh, Dents::Dense);
        check(fresh->set_detail(detail_preset(DetailBackend::Hybrid, DetailPreset::Medium)));
        return fresh;
    }();
    return *made;
}

void stay(Terrain& terrain, WorldPos at) {
    terrain.set_viewers({&at, 1});
    check(terrain.update(0));
    check(terrain.drain());
}

/// The subject's draw is one from a place where the window is stale, the floor's one from the same place again.
template <class MakeStale>
void relief_window(benchmark::State& state, MakeStale make_stale) {
    Terrain& terrain = dented();
    Picture picture(64, 36);
    stay(terrain, walk_place(0.5));
    Pair pair;
    std::uint64_t texels = 0;
    int turn = 0;
    const auto frame = [&](WorldPos at) { picture.draw(terrain, walk_view(terrain.ground(), at)); };
    for (int i = 0; i < 4; ++i) frame(make_stale(turn++)), check(terrain.update(0));
    std::vector<double> stale_ms, fresh_ms;
    for (auto _ : state) {
        const WorldPos at = make_stale(turn++);
        check(terrain.update(0));
        const std::uint64_t before = terrain.last_frame().derive.texels;
        const auto timed = [&] {
            device().gl().Finish();
            const double began = gl::process_cpu_ms();
            frame(at);
            device().gl().Finish();
            return gl::process_cpu_ms() - began;
        };
        stale_ms.push_back(timed());
        texels = terrain.last_frame().derive.texels - before;
        fresh_ms.push_back(timed());
        state.SetIterationTime(stale_ms.back() / 1000);
    }
    state.counters["p50_ms"] = percentile(stale_ms, 0.5);
    state.counters["p95_ms"] = percentile(stale_ms, 0.95);
    state.counters["fresh_p50_ms"] = percentile(fresh_ms, 0.5);
    state.counters["fill_ms"] = percentile(stale_ms, 0.5) - percentile(fresh_ms, 0.5);
    state.counters["texels"] = static_cast<double>(texels);
    report_hash(state, picture.hash());
}

WorldPos jump(int turn) {  // some 42 m to and fro: more than the window's 34 m
    return walk_place(turn % 2 == 0 ? 0.15 : 0.85);
}
WorldPos step(int turn) {  // along x, there and back
    const WorldPos middle = walk_place(0.5);
    return {middle.x + 64 * kTexel_m * ((turn & 15) < 8 ? turn & 7 : 7 - (turn & 7)), middle.z};
}
WorldPos stamp(int turn) {
    const WorldPos middle = walk_place(0.5);
    static_cast<void>(value(dented().stamp({.shape = {static_cast<std::uint32_t>(BuiltinProfile::Gaussian)},
                                            .centre = {middle.x + 3, middle.z + 0.05 * (turn % 20)},
                                            .radius_m = 32 * kTexel_m,
                                            .amplitude_m = turn % 2 == 0 ? -0.01 : 0.01,
                                            .map = MapChoice::Detail})));
    return middle;
}

void walk(benchmark::State& state, DetailBackend backend) {
    Terrain& terrain = dented();
    check(terrain.set_detail(detail_preset(backend, DetailPreset::Medium)));
    Picture picture(640, 360);
    constexpr int kFrames = 200;
    const auto at = [](int frame) { return walk_place(0.4 + frame * 0.05 / 60); };
    stay(terrain, at(0));
    for (int i = 0; i < 3; ++i) picture.draw(terrain, walk_view(terrain.ground(), at(0)));
    std::vector<double> filled_ms, all_ms, other_ms;
    for (auto _ : state) {
        for (int i = 0; i < kFrames; ++i) {
            device().gl().Finish();
            const double began = gl::process_cpu_ms();
            const WorldPos here = at(i);
            terrain.set_viewers({&here, 1});
            check(terrain.update(1.0 / 60));
            picture.draw(terrain, walk_view(terrain.ground(), here));
            device().gl().Finish();
            all_ms.push_back(gl::process_cpu_ms() - began);
            (terrain.last_frame().derive.passes > 0 ? filled_ms : other_ms).push_back(all_ms.back());
        }
        state.SetIterationTime(percentile(all_ms, 0.5) / 1000);
    }
    state.counters["p50_ms"] = percentile(all_ms, 0.5);
    state.counters["p95_ms"] = percentile(all_ms, 0.95);
    state.counters["longest_ms"] = percentile(all_ms, 1);
    state.counters["longest_over_p50"] = percentile(all_ms, 1) / percentile(all_ms, 0.5);
    state.counters["filling_frames"] = static_cast<double>(filled_ms.size());
    state.counters["filling_p50_ms"] = percentile(filled_ms, 0.5);
    state.counters["other_p50_ms"] = percentile(other_ms, 0.5);
    state.counters["other_longest_ms"] = percentile(other_ms, 1);
    report_hash(state, picture.hash());
    check(terrain.set_detail(detail_preset(DetailBackend::Hybrid, DetailPreset::Medium)));
}

void often(benchmark::internal::Benchmark* bench) {
    bench->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(20);
}
BENCHMARK_CAPTURE(relief_window, jump, jump)->Apply(often);
BENCHMARK_CAPTURE(relief_window, step_of_64, step)->Apply(often);
BENCHMARK_CAPTURE(relief_window, stamp_of_64, stamp)->Apply(often);
BENCHMARK_CAPTURE(walk, none, DetailBackend::None)
    ->Name("relief_walk/none")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);
BENCHMARK_CAPTURE(walk, hybrid, DetailBackend::Hybrid)
    ->Name("relief_walk/hybrid")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

}  // namespace
}  // namespace tilth::bench
