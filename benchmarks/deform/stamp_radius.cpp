// Does a stamp cost what its texels cost? One stamp a frame with its slopes on a 4 096 x 4 096 map, radius 16 to 1 024
// texels, executor and precision in their own rows. The last row fits milliseconds against texels.
#include <cmath>
#include <map>

#include "support/bench_map.h"

namespace tilth::bench {
namespace {

/// Median milliseconds by texels, of every row that ran, for the fit.
std::map<std::pair<int, int>, std::map<double, double>>& medians() {
    static std::map<std::pair<int, int>, std::map<double, double>> all;
    return all;
}

BenchMap& map_of(HeightPrecision precision) {
    static std::map<HeightPrecision, std::unique_ptr<BenchMap>> maps;
    std::unique_ptr<BenchMap>& map = maps[precision];
    if (!map) map = std::make_unique<BenchMap>(4096, precision);
    return *map;
}

void stamp_radius(benchmark::State& state, Column column, HeightPrecision precision) {
    const auto radius = static_cast<double>(state.range(0));
    BenchMap& map = map_of(precision);
    const PreparedStamp down = map.stamp(radius, 2048.3, 2047.6, BuiltinProfile::Gaussian, StampRule::Add, true);
    const PreparedStamp up = map.stamp(radius, 2048.3, 2047.6);
    map.apply(column, {&up, 1});  // compiles and allocates; taken back at the end
    Single single;
    bool lower = true;
    for (auto _ : state) {
        single.run(state, [&] { map.apply(column, {lower ? &down : &up, 1}); });
        lower = !lower;
    }
    if (!lower) map.apply(column, {&up, 1});  // the row's hash is that of the ground with one stamp
    single.report(state);
    const auto texels = static_cast<double>(up.rect().count());
    state.counters["texels"] = texels;
    state.counters["ns_per_texel"] = single.subject().p50 * 1e6 / texels;
    state.counters["texels_per_s"] = texels / (single.subject().p50 / 1000);
    report_hash(state, map.hash(column));
    map.apply(column, {&down, 1});
    medians()[{static_cast<int>(column), static_cast<int>(precision)}][texels] = single.subject().p50;
}

/// Least squares of ms = fixed + slope * texels over the rows, and how much of the spread it explains.
void stamp_radius_fit(benchmark::State& state, Column column, HeightPrecision precision) {
    for (auto _ : state) state.SetIterationTime(1e-9);
    const auto& rows = medians()[{static_cast<int>(column), static_cast<int>(precision)}];
    if (rows.size() < 3) {
        state.SkipWithError("needs the rows of stamp_radius in the same run");
        return;
    }
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const auto& [texels, ms] : rows) n += 1, sx += texels, sy += ms, sxx += texels * texels, sxy += texels * ms;
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx), fixed = (sy - slope * sx) / n;
    double residual = 0, spread = 0;
    for (const auto& [texels, ms] : rows) {
        residual += (ms - fixed - slope * texels) * (ms - fixed - slope * texels);
        spread += (ms - sy / n) * (ms - sy / n);
    }
    state.counters["r_squared"] = 1 - residual / spread;
    state.counters["fixed_ms"] = fixed;
    state.counters["ns_per_texel"] = slope * 1e6;
}

void sizes(benchmark::internal::Benchmark* bench) {
    for (const int radius : {16, 32, 64, 128, 256, 512, 1024}) bench->Arg(radius);
    bench->ArgName("radius_texels")->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.3);
}
void once(benchmark::internal::Benchmark* bench) { bench->UseManualTime()->Iterations(1); }

#define STAMP_RADIUS(name, column, precision)                               \
    BENCHMARK_CAPTURE(stamp_radius, name, column, precision)->Apply(sizes); \
    BENCHMARK_CAPTURE(stamp_radius_fit, name, column, precision)->Apply(once)
STAMP_RADIUS(gpu_bits32, Column::Gpu, HeightPrecision::bits32);
STAMP_RADIUS(gpu_bits16, Column::Gpu, HeightPrecision::bits16);
STAMP_RADIUS(cpu_bits32, Column::Cpu, HeightPrecision::bits32);
STAMP_RADIUS(cpu_bits16, Column::Cpu, HeightPrecision::bits16);

}  // namespace
}  // namespace tilth::bench
