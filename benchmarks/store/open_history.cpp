// Does a world with a long past open slower? Worlds that hold the same ground after 10 to 100 000 stamps (what
// is more than ten are pairs that cancel), saved, then opened and loaded in turn. The floor is the one with 10; the
// ratio is to be below 1.5. The row with a negative number was never saved and replays its journal instead: what a save
// spares.
#include <map>
#include <random>
#include <vector>

#include "store/engines.h"
#include "store/sample_pages.h"
#include "store/store_timing.h"
#include "tilth/core/hash.h"
#include "tilth/store/saved_ground.h"

namespace tilth::bench {
namespace {

constexpr std::int32_t kPosts = 257;  // 25.7 m: 12 x 12 pages
constexpr std::int64_t kPasts[] = {10, 1000, 10'000, 100'000};
constexpr std::int64_t kUnsaved = 100'000;  // its row has the number negated
constexpr std::uint64_t kUndoBytes = 1u << 20;

std::unique_ptr<SavedGround> open_world(const std::string& folder, std::uint64_t undo_bytes) {
    return value(
        SavedGround::open(flat_ground(kPosts), folder, {.flush = {.when = FlushPolicy::When::Manual}}, undo_bytes));
}

void stamp_past(SavedGround& world, std::int64_t stamps) {
    std::mt19937 random(1);
    const auto stamp = [&](WorldPos at, double radius_m, double amplitude_m) {
        value(world.stamp({.shape = {static_cast<std::uint32_t>(BuiltinProfile::Gaussian)},
                           .centre = at,
                           .radius_m = radius_m,
                           .amplitude_m = amplitude_m,
                           .map = MapChoice::Detail,
                           .key = 1}));
    };
    std::vector<WorldPos> places;
    for (int i = 0; i < 10; ++i) {
        places.push_back({3 + random() % 1960 / 100.0, 3 + random() % 1960 / 100.0});
        stamp(places.back(), 3, -0.1);
    }
    // Within the first ten, so that no page is in one world and not in another.
    for (std::int64_t i = 10; i < stamps; i += 2) {
        const WorldPos about = places[random() % places.size()];
        const WorldPos at{about.x + random() % 200 / 100.0 - 1, about.z + random() % 200 / 100.0 - 1};
        stamp(at, 0.1, 0.01);
        stamp(at, 0.1, -0.01);
    }
    check(world.flush());
}

struct Past {
    std::string folder;
    Timed open, load;
    std::uint64_t hash = 0;
    double journal_KiB = 0, pages_KiB = 0, tail = 0;
};

struct Pasts {
    std::map<std::int64_t, Past> saved;
    Past unsaved;
};

Pasts measure(std::uint64_t undo_bytes) {
    static const BenchFolder folder;
    Pasts pasts;
    const auto make = [&](Past& past, std::int64_t stamps, bool save) {
        past.folder = folder.make(text(undo_bytes, "_", stamps, save ? "_saved" : "_unsaved"));
        const auto world = open_world(past.folder, undo_bytes);
        stamp_past(*world, stamps);
        if (save) check(world->save());
    };
    for (const std::int64_t stamps : kPasts) make(pasts.saved[stamps], stamps, true);
    make(pasts.unsaved, kUnsaved, false);
    const auto open = [&](Past& past) {
        std::unique_ptr<SavedGround> world;
        past.open.run([&] { world = open_world(past.folder, undo_bytes); });
        const PageRect all = pages_of({{0, 0}, {2048, 2048}});
        past.load.run([&] { benchmark::DoNotOptimize(value(world->world().load({0, 0}, all)).data()); });
        past.hash = world->ground().hash().detail;
        past.journal_KiB = static_cast<double>(world->world().size().journal_bytes) / 1024;
        past.pages_KiB = static_cast<double>(world->world().size().page_bytes) / 1024;
        past.tail = static_cast<double>(world->world().appended() - world->world().committed());
        if (!world->reports().empty()) {
            std::fprintf(stderr, "tilth-bench: %s\n", world->reports().front().message.c_str());
            std::exit(1);
        }
    };
    for (int round = 0; round < 21; ++round) {
        for (auto& [stamps, past] : pasts.saved) open(past);
        open(pasts.unsaved);
    }
    return pasts;
}

void open_after(benchmark::State& state, std::uint64_t undo_bytes) {
    static std::map<std::uint64_t, Pasts> all;
    if (!all.contains(undo_bytes)) all[undo_bytes] = measure(undo_bytes);
    const Pasts& pasts = all[undo_bytes];
    const bool unsaved = state.range(0) < 0;
    const Past& past = unsaved ? pasts.unsaved : pasts.saved.at(state.range(0));
    const Past& least = pasts.saved.at(kPasts[0]);
    for (auto _ : state) state.SetIterationTime(past.open.wall().p50 / 1e3);
    past.open.report(state);
    past.load.report(state, "load_");
    state.counters["ratio"] = past.open.cpu().p50 / least.open.cpu().p50;
    state.counters["wall_ratio"] = past.open.wall().p50 / least.open.wall().p50;
    state.counters["load_ratio"] = past.load.cpu().p50 / least.load.cpu().p50;
    state.counters["journal_KiB"] = past.journal_KiB;
    state.counters["pages_KiB"] = past.pages_KiB;
    state.counters["tail_edits"] = past.tail;
    report_hash(state, past.hash);
}

void pasts(benchmark::internal::Benchmark* bench) {
    for (const std::int64_t stamps : kPasts) bench->Arg(stamps);
    bench->Arg(-kUnsaved);
    bench->ArgName("stamps_before")->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);
}
BENCHMARK_CAPTURE(open_after, no_undo, 0)->Apply(pasts);
BENCHMARK_CAPTURE(open_after, undo_1_MiB, kUndoBytes)->Apply(pasts);

}  // namespace
}  // namespace tilth::bench
