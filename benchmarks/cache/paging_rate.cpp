// How fast do tiles come and go? Codes and slopes of a densely dented tile of 2 048 x 2 048 by the facade's own path
// and in its own slices, against a plain copy of the same bytes by the same route (the same rings, the same calls,
// nothing gathered, converted or derived), in turn. Rates are of CPU time of all threads. With the cpu executor nothing
// is read back; its rows of leaving and arriving time what the frame's thread does beside the transfers.
#include <algorithm>
#include <cstring>
#include <ctime>
#include <set>

#include "support/bench_device.h"
#include "tilth/cache/disk_worker.h"
#include "tilth/cache/frame_budget.h"
#include "tilth/cache/page_runs.h"
#include "tilth/core/hash.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/gpu_tiles.h"
#include "tilth/pool/gl_rect.h"
#include "tilth/store/memory_store.h"

namespace tilth::bench {
namespace {

constexpr std::int32_t kSize = 2048;
constexpr TileIndex kTile{1, 1};  // with an apron on each side
constexpr double kMiB = 1024.0 * 1024.0;

/// A tile, its textures, and every code of it and of its apron written.
struct DenseTile {
    explicit DenseTile(bool gpu_executor) {
        if (gpu_executor) deformer.emplace(value(Deformer::create(device(), shaders())));
        // As `DetailStage` makes it.
        const BudgetSettings budget;
        slot_bytes = 2 * static_cast<std::size_t>(budget.slice_bytes);
        GpuTilesSettings settings{.pool = {.grid = grid},
                                  .slopes = {SlopeStencil::Central, HeightCodec::detail().code_quantum_m(), 1.0 / 30},
                                  .slot_bytes = slot_bytes};
        slope_settings = settings.slopes;
        slots = settings.slots;
        tiles = value(GpuTiles::create(device(), shaders(), deformer ? &*deformer : nullptr, settings));
        if (!tiles->acquire(kTile)) std::exit(1);
        std::uint32_t random = 1;
        const PageRect all = pages_of(grid.stored(kTile));
        for (std::int32_t x = all.min.x; x < all.max.x; ++x)
            for (std::int32_t z = all.min.z; z < all.max.z; ++z)
                for (std::uint32_t& code : field.touch({x, z}))
                    code = kMidCode + ((random = random * 1664525u + 1013904223u) >> 12);
        // As `TileCache::fill` cuts it: a budget counts six bytes a texel.
        std::set<PageIndex> pages;
        for (const auto& [page, codes] : field.pages()) pages.insert(page);
        const auto run = static_cast<std::int32_t>(budget.slice_bytes / (kPageTexels * kPageTexels * 6));
        const TexelRect stored = intersection(grid.stored(kTile), grid.map);
        while (!pages.empty())
            if (const TexelRect rect = take_run(pages, run, stored); !rect.empty()) slices.push_back(rect);
    }

    /// All slices as a frame does one; where the ring is full, what was asked for is waited for.
    void fill() {
        for (const TexelRect& slice : slices)
            while (!tiles->fill(kTile, slice, field, true)) device().gl().Finish();
    }
    [[nodiscard]] TexelRect held() const { return intersection(grid.stored(kTile), grid.map); }
    [[nodiscard]] TexelRect stale(const TexelRect& slice) const {
        return stale_slopes(slice, held(), slope_settings.stencil);
    }
    [[nodiscard]] std::uint64_t hash() const {
        const std::vector<std::uint32_t> codes = tiles->codes(kTile, held());
        return hash_bytes(std::as_bytes(std::span(codes)));
    }

    TileGrid grid{.size = kSize, .apron = 2, .map = {{0, 0}, {3 * kSize, 3 * kSize}}};
    std::optional<Deformer> deformer;
    std::size_t slot_bytes = 0;
    int slots = 0;
    SlopeSettings slope_settings;
    std::unique_ptr<GpuTiles> tiles;
    DetailField field;
    std::vector<TexelRect> slices;
};

gl::Texture2D texture(gl::Format format) {
    return value(gl::Texture2D::create(device(), "bench plain copy", {format, kSize + 4, kSize + 4}));
}

/// The same bytes through the same rings, ready-made.
class PlainCopy {
public:
    explicit PlainCopy(const DenseTile& tile)
        : tile_(tile),
          up_(value(UploadRing::create(device(), tile.slot_bytes, tile.slots))),
          down_(value(ReadBackRing::create(device(), tile.slot_bytes, tile.slots))),
          bytes_(tile.slot_bytes, std::byte{0x5a}),
          taken_(static_cast<std::size_t>(kSize) * kSize * 4) {}

    /// Codes, and with `slopes` the slopes that the cpu executor sends along.
    void up(bool slopes) {
        for (const TexelRect& slice : tile_.slices) {
            const TexelRect stale = slopes ? tile_.stale(slice) : TexelRect{};
            const auto plane = static_cast<std::size_t>(slice.count()) * 2;
            const std::size_t size = 2 * plane + static_cast<std::size_t>(stale.count()) * 2;
            std::optional<std::span<std::byte>> slot;
            while (!(slot = up_.begin(size))) device().gl().Finish();
            std::memcpy(slot->data(), bytes_.data(), size);
            const Texel origin = tile_.grid.stored(kTile).min;
            up_.to_texture(high_, 0, gl_rect(slice, origin), 0, stats);
            up_.to_texture(low_, 0, gl_rect(slice, origin), plane, stats);
            if (slopes) up_.to_texture(slopes_, 0, gl_rect(stale, origin), 2 * plane, stats);
            up_.end();
        }
    }

    /// Codes of the interior, in the slices of `GpuTiles::begin_read_back`.
    void down() {
        const std::int32_t rows = static_cast<std::int32_t>(tile_.slot_bytes / 4) / kSize;
        const auto row_bytes = static_cast<std::size_t>(kSize) * 4;
        std::vector<std::pair<std::uint64_t, std::int32_t>> in_flight;
        for (std::int32_t z = 0; z < kSize || !in_flight.empty();) {
            while (z < kSize) {
                const std::int32_t end = std::min(z + rows, kSize), apron = tile_.grid.apron;
                const gl::Rect part = gl_rect({{0, z}, {kSize, end}}, {-apron, -apron});
                const ReadBackRing::Piece pieces[] = {{&high_, part}, {&low_, part}};
                const std::optional<std::uint64_t> ticket = down_.begin(pieces, stats);
                if (!ticket) break;
                in_flight.emplace_back(*ticket, z);
                z = end;
            }
            std::erase_if(in_flight, [&](const auto& slice) {
                return down_.poll(slice.first, [&](std::span<const std::byte> bytes) {
                    std::memcpy(taken_.data() + static_cast<std::size_t>(slice.second) * row_bytes, bytes.data(),
                                bytes.size());
                }) != ReadBackRing::State::Pending;
            });
        }
    }

    gl::TransferStats stats;

private:
    const DenseTile& tile_;
    UploadRing up_;
    ReadBackRing down_;
    gl::Texture2D high_ = texture(gl::Format::R16), low_ = texture(gl::Format::R16), slopes_ = texture(gl::Format::Rg8);
    std::vector<std::byte> bytes_, taken_;
};

void report_rate(benchmark::State& state, const Pair& pair, double bytes) {
    pair.report(state, "plain_copy");
    const double plain_ms = state.counters["plain_copy_p50_ms"];
    state.counters["MiB"] = bytes / kMiB;
    state.counters["MiB_per_s"] = bytes / kMiB / (pair.subject().p50 / 1000);
    state.counters["plain_MiB_per_s"] = bytes / kMiB / (plain_ms / 1000);
    state.counters["fraction_of_plain"] = plain_ms / pair.subject().p50;
}

/// A tile's arrival: `GpuTiles::fill` over all of it. The share of the slopes is measured beside, alone.
void page_in(benchmark::State& state, bool gpu_executor) {
    DenseTile tile(gpu_executor);
    PlainCopy plain(tile);
    std::optional<SlopePass> pass;
    std::optional<HeightPlanes> planes;
    std::optional<SlopeMap> slope_map;
    if (gpu_executor) {
        const TexelRect stored = tile.grid.stored(kTile);
        pass.emplace(value(
            SlopePass::create(device(), shaders(), HeightPrecision::bits32, SlopeFormat::rg8, tile.slope_settings)));
        planes.emplace(value(HeightPlanes::create(device(), {.rect = stored, .map = tile.grid.map})));
        slope_map.emplace(value(SlopeMap::create(device(), {.rect = stored, .levels = 1})));
    }
    GatheredCodes gathered;
    std::vector<std::byte> stored_slopes(tile.slot_bytes);
    gl::StageStats derive;
    const auto slopes_alone = [&] {
        for (const TexelRect& slice : tile.slices) {
            if (pass) {
                pass->run({&slice, 1}, *planes, *slope_map, derive, derive);
                continue;
            }
            const TexelRect stale = tile.stale(slice), read = intersection(expanded(stale, 1), tile.held());
            store_slopes(stale, gathered.gather(tile.field, read), tile.grid.map, tile.slope_settings, SlopeFormat::rg8,
                         stored_slopes.data());
        }
    };
    gl::FrameStats stats;
    tile.tiles->set_stats(&stats);
    tile.fill();
    const auto bytes = static_cast<double>(stats.transfer.bytes_up);
    plain.up(!gpu_executor);
    slopes_alone();
    Single slopes;
    Pair pair;
    for (auto _ : state) {
        slopes.run(state, slopes_alone);
        pair.run(
            state, [&] { tile.fill(); }, [&] { plain.up(!gpu_executor); });
    }
    report_rate(state, pair, bytes);
    state.counters["slopes_p50_ms"] = slopes.subject().p50;
    state.counters["slopes_share"] = slopes.subject().p50 / pair.subject().p50;
    state.counters["slices"] = static_cast<double>(tile.slices.size());
    state.counters["ms_per_slice"] = pair.subject().p50 / static_cast<double>(tile.slices.size());
    report_hash(state, tile.hash());
}

/// What comes before the first slice: textures of a tile that left are cleared for another. The floor is filling as
/// much memory.
void acquire(benchmark::State& state) {
    DenseTile tile(false);
    std::vector<std::uint64_t> memory(tile.tiles->tile_bytes() / sizeof(std::uint64_t));
    std::uint64_t pattern = 0;
    Pair pair;
    for (auto _ : state) {
        tile.tiles->release(kTile);
        device().gl().Finish();
        pair.run(
            state,
            [&] {
                if (!tile.tiles->acquire(kTile)) std::exit(1);
            },
            [&] {
                std::fill(memory.begin(), memory.end(), ++pattern);
                benchmark::DoNotOptimize(memory.data());
                benchmark::ClobberMemory();
            });
    }
    pair.report(state, "plain_fill");
    state.counters["MiB"] = static_cast<double>(tile.tiles->tile_bytes()) / kMiB;
    report_hash(state, tile.hash());
}

/// A tile's departure with the gpu executor: the read-back of its interior into the field.
void page_out(benchmark::State& state) {
    DenseTile tile(true);
    PlainCopy plain(tile);
    gl::FrameStats stats;
    tile.tiles->set_stats(&stats);
    tile.fill();
    const TexelRect interior = tile.grid.interior(kTile);
    const auto read_back = [&] {
        if (!tile.tiles->begin_read_back(kTile, {&interior, 1})) std::exit(1);
        while (tile.tiles->poll_read_back(kTile, tile.field) == ReadBackState::Pending) continue;
    };
    // What a page held is lost first: the hash tells whether it came back.
    for (const Page& page : tile.field.pages_in(pages_of(interior))) tile.field.touch(page.index).fill(0);
    read_back();
    const auto bytes = static_cast<double>(stats.transfer.bytes_down);
    plain.down();
    Pair pair;
    for (auto _ : state) pair.run(state, read_back, [&] { plain.down(); });
    report_rate(state, pair, bytes);
    std::vector<std::uint32_t> codes(static_cast<std::size_t>(kSize) * kSize);
    tile.field.copy(interior, codes.data(), kSize);
    if (codes != tile.tiles->codes(kTile, interior)) state.SkipWithError("other codes came back");
    report_hash(state, hash_bytes(std::as_bytes(std::span(codes))));
}

double thread_cpu_us() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

/// What leaving and arriving cost the frame's thread beside the transfers, with either executor: shares of a tile's
/// pages go to the worker, are erased when the store has them, and loaded ones are put in their place. No texel is
/// copied here; the worker copies them.
void hand_over(benchmark::State& state) {
    DetailField field;
    const PageRect all = pages_of({{0, 0}, {kSize, kSize}});
    for (std::int32_t x = all.min.x; x < all.max.x; ++x)
        for (std::int32_t z = all.min.z; z < all.max.z; ++z) field.touch({x, z}).fill(kMidCode + 1);
    DiskWorker worker(std::make_shared<MemoryStore>());
    std::vector<double> save_us, erase_us, put_us, worker_ms;
    double bytes = 0;
    for (auto _ : state) {
        double began_us = thread_cpu_us();
        std::vector<Page> pages = field.pages_in(all);
        bytes = static_cast<double>(pages.size() * sizeof(Page));
        std::shared_ptr<DiskRequest> request = DiskRequest::save(kTile, std::move(pages), 500);
        worker.submit(request);
        save_us.push_back(thread_cpu_us() - began_us);
        request.reset();
        std::shared_ptr<DiskRequest> done = worker.wait();
        check(done->outcome);
        worker_ms.push_back(done->store_ms);

        began_us = thread_cpu_us();
        done.reset();
        for (const Page& page : field.pages_in(all)) field.erase(page.index);
        erase_us.push_back(thread_cpu_us() - began_us);

        worker.submit(DiskRequest::load(kTile, {{.tile = kTile, .pages = all}}, 0));
        done = worker.wait();
        check(done->outcome);
        began_us = thread_cpu_us();
        for (Page& page : done->pieces.front().loaded) field.put(std::move(page));
        put_us.push_back(thread_cpu_us() - began_us);
        state.SetIterationTime(save_us.back() * 1e-6);
    }
    state.counters["save_p50_us"] = percentiles_of(save_us).p50;
    state.counters["save_p95_us"] = percentiles_of(save_us).p95;
    state.counters["save_bytes"] = bytes;
    state.counters["erase_p50_us"] = percentiles_of(erase_us).p50;
    state.counters["put_p50_us"] = percentiles_of(put_us).p50;
    state.counters["worker_save_p50_ms"] = percentiles_of(worker_ms).p50;
    state.counters["read_back_bytes"] = 0;
    std::vector<std::uint32_t> codes(static_cast<std::size_t>(kSize) * kSize);
    field.copy({{0, 0}, {kSize, kSize}}, codes.data(), kSize);
    report_hash(state, hash_bytes(std::as_bytes(std::span(codes))));
}

void rows(benchmark::internal::Benchmark* bench) {
    bench->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(15);
}
BENCHMARK_CAPTURE(page_in, cpu, false)->Apply(rows);
BENCHMARK_CAPTURE(page_in, gpu, true)->Apply(rows);
BENCHMARK(acquire)->Name("page_in/acquire")->Apply(rows);
BENCHMARK(page_out)->Name("page_out/gpu")->Apply(rows);
BENCHMARK(hand_over)->Name("page_out/hand_over")->Apply(rows);

}  // namespace
}  // namespace tilth::bench
