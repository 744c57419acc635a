// Does a stamp on a corner of four tiles cost less than 1.5 times the same stamp in the middle of one (the paper: "less
// than 4 times")? The whole update of a frame with one stamp and its slopes, corner and centre in turn, on tiles of
// 2 048 x 2 048 that are all resident and dented before. Sizes are texels across.
#include <algorithm>
#include <map>

#include "support/bench_terrain.h"
#include "tilth/source/analytic_sources.h"

namespace tilth::bench {
namespace {

/// Four tiles about one corner, each dented where a row will stamp.
BenchTerrain& four_tiles(ExecutorKind executor) {
    static std::map<ExecutorKind, std::unique_ptr<BenchTerrain>> all;
    std::unique_ptr<BenchTerrain>& made = all[executor];
    if (made) return *made;
    made = std::make_unique<BenchTerrain>(std::make_shared<FlatSource>(1400, 10.0), executor);
    const double size = made->tile_texels();
    made->put_viewer({size - 0.5, size - 0.5});
    made->stamp({size - 0.5, size - 0.5}, 560, 0.01);
    made->stamp({size / 2 - 0.5, size / 2 - 0.5}, 560, 0.01);
    made->settle();
    return *made;
}

void stamp_tiles(benchmark::State& state, ExecutorKind executor) {
    BenchTerrain& ground = four_tiles(executor);
    const double size = ground.tile_texels(), radius = static_cast<double>(state.range(0)) / 2;
    const PostPos centre{size / 2 - 0.5, size / 2 - 0.5}, corner{size - 0.5, size - 0.5};
    // Up and down in turn: the ground stays where it was.
    // So low that thousands of them cannot reach the range's end: nothing has to be counted.
    const StampRecord up_centre = ground.stamp(centre, radius, 1e-4), up_corner = ground.stamp(corner, radius, 1e-4);
    ground.settle();
    const auto update_with = [&](const StampRecord& record) {
        check(ground->replay(record));
        ground.frame();
    };
    Pair pair;
    bool lower = true;
    gl::FrameStats at_corner, at_centre;
    for (auto _ : state) {
        pair.run(
            state,
            [&] {
                update_with(lower ? negated(up_corner) : up_corner);
                at_corner = ground->last_frame();
            },
            [&] {
                update_with(lower ? negated(up_centre) : up_centre);
                at_centre = ground->last_frame();
            });
        lower = !lower;
    }
    if (!lower)  // the row's hash is that of the ground with one stamp at each place
        for (const StampRecord& record : {up_corner, up_centre}) update_with(record);
    pair.report(state, "centre");
    const double texels = static_cast<double>(state.range(0)) * static_cast<double>(state.range(0));
    state.counters["ns_per_texel"] = pair.subject().p50 * 1e6 / texels;
    for (const auto& [name, frame] : {std::pair{"centre_", &at_centre}, {"corner_", &at_corner}}) {
        state.counters[std::string(name) + "passes"] = static_cast<double>(frame->deform.passes + frame->derive.passes);
        state.counters[std::string(name) + "draws"] = static_cast<double>(frame->deform.draws + frame->derive.draws);
        state.counters[std::string(name) + "up_bytes"] = static_cast<double>(frame->transfer.bytes_up);
    }
    report_hash(state, ground.hash());
    for (const StampRecord& record : {up_corner, up_centre}) update_with(negated(record));
    ground.settle();
}

void sizes(benchmark::internal::Benchmark* bench) {
    for (const int across : {16, 32, 64, 128, 256, 512, 1024}) bench->Arg(across);
    bench->ArgName("texels_across")->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.3);
}
BENCHMARK_CAPTURE(stamp_tiles, gpu, ExecutorKind::Gpu)->Apply(sizes);
BENCHMARK_CAPTURE(stamp_tiles, cpu, ExecutorKind::Cpu)->Apply(sizes);

}  // namespace
}  // namespace tilth::bench
