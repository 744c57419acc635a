// What does a stamp cost among many of its frame? 1 to 1 000 stamps of 16 texels' radius a frame, scattered over 1 024
// x 1 024 texels, with slopes.
#include "support/bench_map.h"

namespace tilth::bench {
namespace {

void stamps_per_frame(benchmark::State& state, Column column) {
    BenchMap map(1024);
    SplitMix64 random{1};
    std::vector<PreparedStamp> up, down;
    for (std::int64_t i = 0; i < state.range(0); ++i) {
        const double x = random.between(20, 1000), z = random.between(20, 1000);
        up.push_back(map.stamp(16, x, z));
        down.push_back(map.stamp(16, x, z, BuiltinProfile::Gaussian, StampRule::Add, true));
    }
    map.apply(column, up);
    Single single;
    bool lower = true;
    for (auto _ : state) {
        single.run(state, [&] { map.apply(column, lower ? down : up); });
        lower = !lower;
    }
    if (!lower) map.apply(column, up);
    single.report(state);
    const auto count = static_cast<double>(state.range(0));
    state.counters["us_per_stamp"] = single.subject().p50 * 1000 / count;
    state.counters["stamps_per_s"] = count / (single.subject().p50 / 1000);
    report_hash(state, map.hash(column));
}

void counts(benchmark::internal::Benchmark* bench) {
    for (const int count : {1, 10, 100, 1000}) bench->Arg(count);
    bench->ArgName("stamps")->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.3);
}
BENCHMARK_CAPTURE(stamps_per_frame, gpu, Column::Gpu)->Apply(counts);
BENCHMARK_CAPTURE(stamps_per_frame, cpu, Column::Cpu)->Apply(counts);

}  // namespace
}  // namespace tilth::bench
