// What does a durable stamp cost, by flush policy? A boot print on a ground in memory, and the same with a journal that
// flushes each edit, every 5 ms on its own thread, or when asked (here once in 100). Floors in turn with it: 64 bytes
// appended to a file and synced, and 64 bytes written in place and synced. The wall time is what the caller waits.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <optional>

#include "store/engines.h"
#include "store/sample_pages.h"
#include "store/store_timing.h"
#include "tilth/core/hash.h"
#include "tilth/store/saved_ground.h"

namespace tilth::bench {
namespace {

constexpr std::int32_t kPosts = 257;
constexpr int kRounds = 400;
constexpr int kFlushOnceIn = 100;

/// 64 bytes a time.
class BareFile {
public:
    BareFile(const std::string& path, bool grows)
        : fd_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)), grows_(grows) {
        for (int i = 0; fd_ >= 0 && !grows && i < 64; ++i) (void)!::pwrite(fd_, page_.data(), page_.size(), i * 4096);
        if (fd_ < 0 || ::fsync(fd_) != 0) fail();
    }
    ~BareFile() { ::close(fd_); }
    BareFile(const BareFile&) = delete;
    BareFile& operator=(const BareFile&) = delete;

    void write_and_sync() {
        if (::pwrite(fd_, page_.data(), 64, end_) != 64 || ::fdatasync(fd_) != 0) fail();
        end_ = grows_ ? end_ + 64 : (end_ + 64) % (64 * 4096);
    }

private:
    [[noreturn]] static void fail() {
        std::perror("tilth-bench: bare file");
        std::exit(1);
    }
    int fd_;
    bool grows_;
    off_t end_ = 0;
    std::array<char, 4096> page_{};
};

enum class Subject { Memory, Each, Every, Manual };

FlushPolicy policy_of(Subject subject) {
    switch (subject) {
        case Subject::Each:
            return {.when = FlushPolicy::When::Each};
        case Subject::Every:
            return {.when = FlushPolicy::When::Every, .interval_ms = 5};
        default:
            return {.when = FlushPolicy::When::Manual};
    }
}

void durable_stamp(benchmark::State& state, Subject subject) {
    const BenchFolder folder;
    auto plan = flat_ground(kPosts);
    const std::vector<StampRequest> walk = trail_of_prints(*plan, {.prints = 150});
    std::unique_ptr<SavedGround> saved;
    if (subject != Subject::Memory) {
        saved = value(SavedGround::open(flat_ground(kPosts), folder.make("world"), {.flush = policy_of(subject)}, 0));
        value(saved->shapes().bake("boot", kBootTexels, boot_weight));
        value(saved->stamp(walk.front()));  // the shape goes to the disk with its first stamp
        check(saved->flush());
    } else {
        plan->apply(value(plan->issue(walk.front())));
    }
    BareFile appended((folder.path() / "appended").string(), true),
        in_place((folder.path() / "in_place").string(), false);
    Timed append, place, stamp, flush;
    std::array<double, 2> cpu{};
    for (auto _ : state) {
        for (int i = 0; i < kRounds; ++i) {
            append.run([&] { appended.write_and_sync(); });
            place.run([&] { in_place.write_and_sync(); });
            const StampRequest& print = walk[static_cast<std::size_t>(i) % walk.size()];
            stamp.run([&] {
                if (saved)
                    value(saved->stamp(print));
                else
                    plan->apply(value(plan->issue(print)));
            });
            if (saved && (i + 1) % kFlushOnceIn == 0) flush.run([&] { check(saved->flush()); });
        }
        // A stretch without the floors: CPU time of all threads, those of the journal included.
        cpu[0] = process_cpu_ms();
        for (int i = 0; i < 2000; ++i) {
            const StampRequest& print = walk[static_cast<std::size_t>(i) % walk.size()];
            if (subject == Subject::Each && i >= 200) break;
            if (saved)
                value(saved->stamp(print));
            else
                plan->apply(value(plan->issue(print)));
            cpu[1] = i + 1;
        }
        if (saved) check(saved->flush());
        cpu[0] = process_cpu_ms() - cpu[0];
        state.SetIterationTime(stamp.wall().p50 / 1e3);
    }
    stamp.report(state);
    append.report(state, "append_and_sync_");
    place.report(state, "in_place_and_sync_");
    if (saved) flush.report(state, "flush_");
    state.counters["ratio"] = stamp.wall().p50 / append.wall().p50;
    state.counters["ratio_in_place"] = stamp.wall().p50 / place.wall().p50;
    state.counters["all_threads_cpu_us"] = cpu[0] * 1000 / cpu[1];
    report_hash(state, (saved ? saved->ground() : *plan).hash().detail);
}

void once(benchmark::internal::Benchmark* bench) {
    bench->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);
}
BENCHMARK_CAPTURE(durable_stamp, memory_alone, Subject::Memory)->Apply(once);
BENCHMARK_CAPTURE(durable_stamp, each, Subject::Each)->Apply(once);
BENCHMARK_CAPTURE(durable_stamp, every_5_ms, Subject::Every)->Apply(once);
BENCHMARK_CAPTURE(durable_stamp, manual, Subject::Manual)->Apply(once);

}  // namespace
}  // namespace tilth::bench
