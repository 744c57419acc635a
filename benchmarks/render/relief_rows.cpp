// What does detail cost that can be seen? Frames of each backend, of their floors and of `none`, in turn at each place
// of a walk, as ratios to `none`: median and 95th percentile over the places. On untouched ground all ratios are to be
// 1 and all counts equal. Rows and floors: the files of the backends beside this one; ground and walk: relief_scene.h.
//
//   primitives     generated, mean over the places, by query
//   error_...      against every texel as a mesh (relief_error.h)
//   hash           of the picture at the walk's middle
#include "render/relief_rows.h"

#include <cmath>
#include <map>
#include <memory>

#include "render/relief_error.h"
#include "render/relief_scene.h"
#include "support/picture.h"

namespace tilth::bench {
namespace {

constexpr int kPlaces = 15;

struct Size {
    int width = 1600, height = 900;
    friend auto operator<=>(const Size&, const Size&) = default;
};

std::vector<ReliefRow>& rows() {
    static std::vector<ReliefRow> all;
    return all;
}

struct RowResult {
    std::vector<double> ms, ratio;
    double primitives = 0, draws = 0;
    std::uint64_t hash = 0;
};

/// The terrains of one state of the ground, one for each folder of shaders.
struct Worlds {
    explicit Worlds(Dents wanted) : dents(wanted) {}
    Terrain& of(RowShaders shaders) {
        std::unique_ptr<Terrain>& made = all[shaders];
        if (made) return *made;
        std::string folder;
        if (shaders != RowShaders::Own) {
            overlays.push_back(
                std::make_unique<ShaderOverlay>(shaders == RowShaders::PassThrough ? "pass_through" : "plain_fetches"));
            folder = overlays.back()->folder();
        }
        made = reference_terrain(folder);
        make_dents(*made, dents);
        return *made;
    }
    Dents dents;
    std::map<RowShaders, std::unique_ptr<Terrain>> all;
    std::vector<std::unique_ptr<ShaderOverlay>> overlays;
};

Worlds& worlds_of(Dents dents) {
    static std::unique_ptr<Worlds> here;  // one at a time: each terrain takes some 300 MB
    if (!here || here->dents != dents) {
        here.reset();
        here = std::make_unique<Worlds>(dents);
    }
    return *here;
}

std::map<std::string, RowResult> measured(Dents dents, Size size, bool by_resolution) {
    Worlds& worlds = worlds_of(dents);
    std::vector<const ReliefRow*> chosen;
    for (const ReliefRow& row : rows())
        if (row.by_resolution || !by_resolution)
            if (row.shaders == RowShaders::Own || dents != Dents::None) chosen.push_back(&row);
    for (const ReliefRow* row : chosen) static_cast<void>(worlds.of(row->shaders));

    Picture picture(size.width, size.height), small(16, 9);
    gl::Query generated = value(gl::Query::create(device(), "generated", gl::QueryKind::PrimitivesGenerated));
    gl::GpuTimer timer = value(gl::GpuTimer::create(device(), "detail frame", gl::TimerPolicy::MayFinish));
    std::map<std::string, RowResult> results;
    // The first place is drawn once for nothing: programs are made there.
    for (int place = -1; place < kPlaces; ++place) {
        const WorldPos at = walk_place(std::max(place, 0) / double{kPlaces - 1});
        for (auto& [shaders, terrain] : worlds.all) {
            terrain->set_viewers({&at, 1});
            check(terrain->update(0));
            check(terrain->drain());
        }
        std::map<std::string, double> ms;
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            // Each place begins with another row.
            const ReliefRow& row = *chosen[(i + static_cast<std::size_t>(place + 1)) % chosen.size()];
            Terrain& terrain = worlds.of(row.shaders);
            const View view = walk_view(terrain.ground(), at);
            check(terrain.set_detail(row.settings));
            small.draw(terrain, view);  // fills the relief window, which `none` has given up
            check(terrain.update(0));
            generated.begin();
            timer.begin();
            picture.draw(terrain, view);
            timer.end();
            generated.end();
            const std::vector<double> samples = timer.finish_samples_ms();
            if (place < 0) continue;
            RowResult& result = results[row.name];
            ms[row.name] = samples.empty() ? 0 : samples.back();
            result.primitives += static_cast<double>(generated.result()) / kPlaces;
            result.draws += static_cast<double>(terrain.last_frame().render.draws) / kPlaces;
            if (place == kPlaces / 2) result.hash = picture.hash();
        }
        for (const auto& [name, time] : ms) {
            results[name].ms.push_back(time);
            results[name].ratio.push_back(time / ms.at("none"));
        }
    }
    return results;
}

const std::map<std::string, RowResult>& results_of(Dents dents, Size size, bool by_resolution) {
    static std::map<std::pair<Dents, Size>, std::map<std::string, RowResult>> all;
    auto found = all.find({dents, size});
    if (found == all.end()) found = all.emplace(std::pair{dents, size}, measured(dents, size, by_resolution)).first;
    return found->second;
}

void detail_frame(benchmark::State& state, const ReliefRow& row, Dents dents, Size size, bool by_resolution) {
    const std::map<std::string, RowResult>& all = results_of(dents, size, by_resolution);
    const RowResult& result = all.at(row.name);
    for (auto _ : state) state.SetIterationTime(percentile(result.ms, 0.5) / 1000);
    state.counters["p50_ms"] = percentile(result.ms, 0.5);
    state.counters["p95_ms"] = percentile(result.ms, 0.95);
    state.counters["ratio"] = percentile(result.ratio, 0.5);
    state.counters["ratio_p95"] = percentile(result.ratio, 0.95);
    state.counters["primitives"] = result.primitives;
    state.counters["draws"] = result.draws;
    if (dents != Dents::None && !by_resolution && row.shaders == RowShaders::Own) {
        const ReliefError error = relief_error(row.settings, dents);
        state.counters["error_rms_px"] = error.rms_px;
        state.counters["error_p99_px"] = error.p99_px;
        state.counters["wrong_percent"] = error.wrong_percent;
    }
    report_hash(state, result.hash);
}

}  // namespace

bool add_relief_row(ReliefRow row) {
    rows().push_back(row);
    const auto add = [&](Dents dents, Size size, bool by_resolution) {
        const std::string name =
            text("detail_frame/", name_of(dents), "/", size.width, "x", size.height, "/", row.name);
        benchmark::RegisterBenchmark(name.c_str(), detail_frame, row, dents, size, by_resolution)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond)
            ->Iterations(1);
    };
    if (row.shaders == RowShaders::Own) add(Dents::None, {}, false);
    add(Dents::Trail, {}, false);
    if (row.by_resolution) {
        add(Dents::Trail, {1280, 720}, true);
        add(Dents::Trail, {1920, 1080}, true);
    }
    add(Dents::Dense, {}, false);
    return true;
}

namespace {

const bool kNone = add_relief_row({.name = "none", .settings = {}, .by_resolution = true});
const bool kAgain = add_relief_row({.name = "none_again", .settings = {}});  // what the machine does by itself

}  // namespace

}  // namespace tilth::bench
