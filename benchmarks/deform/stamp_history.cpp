// Does ground that was stamped before cost more to stamp? A stamp of 32 texels' radius where 0, 10^3 and 10^6 stamps
// lie already, against the same stamp on an untouched map, taken in turn. The ratio is to be 1.
#include "support/bench_map.h"

namespace tilth::bench {
namespace {

void stamp_after(benchmark::State& state, Column column) {
    BenchMap map(512), fresh(512);
    const PreparedStamp up = map.stamp(32, 256.25, 256.75);
    const PreparedStamp down = map.stamp(32, 256.25, 256.75, BuiltinProfile::Gaussian, StampRule::Add, true);
    // The history: small stamps at and round the same place, up and down in turn.
    const PreparedStamp dab[] = {map.stamp(3, 256.25, 256.75),
                                 map.stamp(3, 257.5, 256.75, BuiltinProfile::Gaussian, StampRule::Add, true)};
    for (std::int64_t i = 0; i < state.range(0); ++i) apply_stamp(dab[i & 1], map.field);
    map.planes.upload(map.field, map.field.rect(), map.transfer);
    for (BenchMap* each : {&map, &fresh}) {
        each->apply(column, {&up, 1});
        each->apply(column, {&down, 1});
    }
    Pair pair;
    for (auto _ : state)
        pair.run(
            state,
            [&] {
                map.apply(column, {&up, 1});
                map.apply(column, {&down, 1});
            },
            [&] {
                fresh.apply(column, {&up, 1});
                fresh.apply(column, {&down, 1});
            });
    pair.report(state, "untouched");
    state.counters["stamps_per_s"] = 2 / (pair.subject().p50 / 1000);
    report_hash(state, map.hash(column));
}

void histories(benchmark::internal::Benchmark* bench) {
    for (const int before : {0, 1000, 1000000}) bench->Arg(before);
    bench->ArgName("stamps_before")->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.3);
}
BENCHMARK_CAPTURE(stamp_after, gpu, Column::Gpu)->Apply(histories);
BENCHMARK_CAPTURE(stamp_after, cpu, Column::Cpu)->Apply(histories);

}  // namespace
}  // namespace tilth::bench
