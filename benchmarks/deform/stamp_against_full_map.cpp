// Does a small stamp pay for the map's size? A 64-texel stamp with its slopes against one pass of the same shader over
// the whole 4 096 x 4 096 map, taken in turn. The ratio is to be at most 1/100.
#include "support/bench_map.h"

namespace tilth::bench {
namespace {

void small_stamp_against_full_map(benchmark::State& state, Column column) {
    BenchMap map(4096);
    const PreparedStamp small = map.stamp(32, 2048, 2048);  // 64 texels across
    const PreparedStamp whole = map.stamp(2900, 2048, 2048);
    map.apply(column, {&whole, 1}, false);
    map.apply(column, {&small, 1});
    Pair pair;
    for (auto _ : state)
        pair.run(
            state,
            [&] {
                map.apply(column, {&small, 1});
            },
            [&] {
                map.apply(column, {&whole, 1}, false);
            });
    pair.report(state, "full_map");
    state.counters["texels"] = static_cast<double>(small.rect().count());
    state.counters["full_map_texels"] = static_cast<double>(whole.rect().count());
    state.counters["texels_per_s"] = static_cast<double>(small.rect().count()) / (pair.subject().p50 / 1000);
    report_hash(state, map.hash(column));
}
BENCHMARK_CAPTURE(small_stamp_against_full_map, gpu, Column::Gpu)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(9);
BENCHMARK_CAPTURE(small_stamp_against_full_map, cpu, Column::Cpu)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(9);

}  // namespace
}  // namespace tilth::bench
