// How many bytes is a footprint? 100, 1 000 and 10 000 prints as a log of edits, as pages in memory, as pages on disk
// after a save, and as whole tiles. Counts, and no times: they are the same on every machine.
#include <algorithm>
#include <set>

#include "store/engines.h"
#include "store/sample_pages.h"
#include "store/store_timing.h"
#include "tilth/core/hash.h"
#include "tilth/store/journal_entry.h"
#include "tilth/store/page_codec.h"
#include "tilth/store/saved_ground.h"

namespace tilth::bench {
namespace {

constexpr double kKiB = 1024, kMiB = 1024 * 1024;
constexpr std::int32_t kPosts = 4097;  // 410 m, 6 x 6 tiles

void footprint_bytes(benchmark::State& state) {
    const std::int64_t prints = state.range(0);
    const BenchFolder folder;
    auto world = value(SavedGround::open(flat_ground(kPosts), folder.make("world"),
                                         {.flush = {.when = FlushPolicy::When::Manual}}, 0));
    // The walk of a ground of its own: shapes are the world's.
    std::uint64_t saved_again = 0;
    for (auto _ : state) {
        auto plan = flat_ground(kPosts);
        const std::vector<StampRequest> walk = trail_of_prints(*plan, {.prints = prints, .lanes_m = 20});
        const ShapeId id = value(world->shapes().bake("boot", kBootTexels, boot_weight));
        for (StampRequest print : walk) {
            print.shape = id;
            value(world->stamp(print));
        }
        check(world->save());
        const std::uint64_t before = world->world().size().page_bytes;
        StampRequest again = walk.front();
        again.shape = id;
        again.amplitude_m *= 2;
        value(world->stamp(again));
        check(world->save());
        saved_again = world->world().size().page_bytes - before;
        state.SetIterationTime(1e-9);
    }
    const DetailField& detail = world->ground().detail();
    const TileGrid tiles{.size = world->ground().settings().tile_size,
                         .map = world->ground().map(MapKind::Detail).grid.rect()};
    std::set<TileIndex> touched;
    double encoded = 0;
    for (const auto& [index, codes] : detail.pages()) {
        encoded += static_cast<double>(encode_page(*codes, HeightPrecision::bits32).size());
        for_each_tile(tiles_of(tiles, texels_of(index)), [&](TileIndex tile) { touched.insert(tile); });
    }
    const WorldFolder::Size size = world->world().size();
    const auto pages = static_cast<double>(detail.pages().size()), count = static_cast<double>(prints);
    state.counters["log_KiB"] = count * kJournalEntryBytes / kKiB;
    state.counters["pages"] = pages;
    state.counters["pages_raw_MiB"] = pages * sizeof(PageCodes) / kMiB;
    state.counters["pages_encoded_KiB"] = encoded / kKiB;
    state.counters["page_file_live_KiB"] = static_cast<double>(size.live_page_bytes) / kKiB;
    state.counters["page_file_KiB"] = static_cast<double>(size.page_bytes) / kKiB;
    state.counters["tiles"] = static_cast<double>(touched.size());
    state.counters["tiles_raw_MiB"] = static_cast<double>(touched.size()) * tiles.size * tiles.size * 4 / kMiB;
    state.counters["bytes_per_print_on_disk"] = static_cast<double>(size.page_bytes) / count;
    state.counters["one_print_more_saves_bytes"] = static_cast<double>(saved_again);
    const StateHash hash = world->ground().hash();
    report_hash(state, hash.detail);
}
BENCHMARK(footprint_bytes)->Arg(100)->Arg(1000)->Arg(10000)->ArgName("prints")->UseManualTime()->Iterations(1);

}  // namespace
}  // namespace tilth::bench
