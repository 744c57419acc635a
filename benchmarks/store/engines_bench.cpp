// Which engine under the store? SQLite (WAL), LMDB and the library's own log of blobs behind one interface, in turn and
// in one run, on encoded pages as worlds have them: commits of 1, 16 and 1 024 dirty pages, loads of 64 and 1 024
// pages, opening, and the size after ten rounds of rewriting everything. The floor: the same bytes appended to one file
// and synced, resp. read from it.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <random>

#include "store/engines.h"
#include "store/sample_pages.h"
#include "store/store_timing.h"
#include "tilth/core/hash.h"
#include "tilth/store/page_codec.h"

namespace tilth::bench {
namespace {

using Blob = std::vector<std::byte>;
constexpr std::size_t kTilePages = 1024;  // 2 048 x 2 048 texels

/// Blobs of encoded pages, a quarter of each kind that players make.
const std::vector<Blob>& blobs() {
    static const std::vector<Blob> all = [] {
        std::vector<Blob> made;
        for (const SampleKind kind : {SampleKind::Prints, SampleKind::Adds, SampleKind::Craters, SampleKind::Dense})
            for (const Page& page : sample_pages(kind, HeightPrecision::bits32, 64))
                made.push_back(encode_page(*page.codes, HeightPrecision::bits32));
        std::shuffle(made.begin(), made.end(), std::mt19937(1));
        return made;
    }();
    return all;
}
const Blob& blob_of(std::size_t page, std::size_t version) {
    return blobs()[(page * 7 + version * 13) % blobs().size()];
}
BlobKey key_of(std::size_t page) {
    return {BlobKind::DetailPage, static_cast<std::int32_t>(page % 32), static_cast<std::int32_t>(page / 32)};
}

/// The floor: a file whose blocks are all there already, written round and round, or read.
class PlainFile {
public:
    explicit PlainFile(const std::string& path) : fd_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
        if (fd_ < 0) fail();
        write_and_sync(Blob(kBytes));
    }
    ~PlainFile() { ::close(fd_); }
    PlainFile(const PlainFile&) = delete;
    PlainFile& operator=(const PlainFile&) = delete;

    void write_and_sync(const Blob& bytes) {
        if (end_ + bytes.size() > kBytes) end_ = 0;
        if (::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(end_)) != static_cast<ssize_t>(bytes.size()) ||
            ::fdatasync(fd_) != 0)
            fail();
        end_ += bytes.size();
    }
    void read(std::size_t bytes) {
        buffer_.resize(bytes);
        if (::pread(fd_, buffer_.data(), bytes, 0) != static_cast<ssize_t>(bytes)) fail();
        benchmark::DoNotOptimize(buffer_.data());
    }

private:
    static constexpr std::size_t kBytes = std::size_t{16} << 20;
    [[noreturn]] static void fail() {
        std::perror("tilth-bench: plain file");
        std::exit(1);
    }
    int fd_;
    std::size_t end_ = 0;
    Blob buffer_;
};

struct Subject {
    std::string name, folder;
    bool compacts = false;
    std::unique_ptr<BlobStore> store;
};

/// All engines with the pages of one tile in them, version 0.
std::vector<Subject> filled(const BenchFolder& folder) {
    std::vector<Subject> subjects;
    for (const Engine& engine : engines()) {
        Subject subject{engine.name, folder.make(engine.name), engine.compacts, nullptr};
        subject.store = std::move(value(engine.open(subject.folder)).store);
        for (std::size_t page = 0; page < kTilePages; ++page) check(subject.store->put(key_of(page), blob_of(page, 0)));
        check(subject.store->commit(1));
        subjects.push_back(std::move(subject));
    }
    return subjects;
}

/// XXH3-64 of all that a store holds: every engine's row must have the same.
std::uint64_t hash_of(BlobStore& store) {
    std::vector<std::uint64_t> hashes;
    for (const BlobKey key : value(store.keys(BlobKind::DetailPage))) {
        const auto bytes = value(store.get(key));
        hashes.push_back(bytes ? hash_bytes(*bytes) : 0);
    }
    return hash_bytes(std::as_bytes(std::span(hashes)));
}

struct Measured {
    std::map<std::string, Timed> timed;   ///< by engine; "plain" is the floor
    std::map<std::string, Timed> upkeep;  ///< compaction, beside it
    std::map<std::string, std::uint64_t> hashes;
    std::map<std::string, std::map<std::string, double>> counters;
};

/// What the host's worker does between commits. The databases have nothing to do there.
void keep_up(Subject& subject, Measured& measured) {
    if (subject.compacts)
        measured.upkeep[subject.name].run([&] {
            while (value(subject.store->compact(std::uint64_t{1} << 20))) continue;
        });
}

Measured measure_commits(std::size_t dirty) {
    const BenchFolder folder;
    std::vector<Subject> subjects = filled(folder);
    PlainFile plain(folder.path() / "plain");
    Measured measured;
    std::mt19937 random(static_cast<std::uint32_t>(dirty));
    const std::size_t rounds = dirty == 1 ? 150 : dirty == 16 ? 80 : 20;
    double bytes = 0;
    for (std::size_t round = 1; round <= rounds; ++round) {
        std::vector<std::size_t> pages;
        for (std::size_t i = 0; i < dirty; ++i) pages.push_back(dirty == kTilePages ? i : random() % kTilePages);
        Blob together;
        for (const std::size_t page : pages) {
            const Blob& blob = blob_of(page, round);
            together.insert(together.end(), blob.begin(), blob.end());
        }
        bytes += static_cast<double>(together.size()) / static_cast<double>(rounds);
        measured.timed["plain"].run([&] { plain.write_and_sync(together); });
        for (Subject& subject : subjects) {
            measured.timed[subject.name].run([&] {
                for (const std::size_t page : pages) check(subject.store->put(key_of(page), blob_of(page, round)));
                check(subject.store->commit(round + 1));
            });
            keep_up(subject, measured);
        }
    }
    for (Subject& subject : subjects) {
        measured.hashes[subject.name] = hash_of(*subject.store);
        measured.counters[subject.name]["KiB"] = bytes / 1024;
    }
    return measured;
}

/// `pages` blobs of a tile, from the system's cache: what a disk adds is the same for all.
Measured measure_loads(std::size_t pages) {
    const BenchFolder folder;
    std::vector<Subject> subjects = filled(folder);
    PlainFile plain(folder.path() / "plain");
    Blob together;
    for (std::size_t page = 0; page < pages; ++page)
        together.insert(together.end(), blob_of(page, 0).begin(), blob_of(page, 0).end());
    Measured measured;
    std::vector<Blob> got(pages);
    for (int round = 0; round < 40; ++round) {
        measured.timed["plain"].run([&] { plain.read(together.size()); });
        for (Subject& subject : subjects)
            measured.timed[subject.name].run([&] {
                for (std::size_t page = 0; page < pages; ++page) got[page] = *value(subject.store->get(key_of(page)));
            });
        // What comes on top, whatever the engine.
        measured.timed["decode_alone"].run([&] {
            for (const Blob& blob : got) benchmark::DoNotOptimize(value(decode_page(blob, "page"))->data());
        });
    }
    for (Subject& subject : subjects) {
        measured.hashes[subject.name] = hash_of(*subject.store);
        measured.counters[subject.name]["KiB"] = static_cast<double>(together.size()) / 1024;
    }
    return measured;
}

/// Opening a world of 16 tiles, and closing it.
Measured measure_opening() {
    const BenchFolder folder;
    std::vector<Subject> subjects = filled(folder);
    for (Subject& subject : subjects) {
        for (std::size_t page = 0; page < 16 * kTilePages; ++page)
            check(subject.store->put(key_of(page), blob_of(page, 0)));
        check(subject.store->commit(2));
        subject.store.reset();
    }
    PlainFile plain(folder.path() / "plain");
    Measured measured;
    for (int round = 0; round < 20; ++round) {
        measured.timed["plain"].run([&] { plain.read(16 * kTilePages * 32); });
        for (std::size_t i = 0; i < subjects.size(); ++i) {
            measured.timed[subjects[i].name].run([&] {
                subjects[i].store = std::move(value(engines()[i].open(subjects[i].folder)).store);
                measured.counters[subjects[i].name]["keys"] =
                    static_cast<double>(value(subjects[i].store->keys(BlobKind::DetailPage)).size());
            });
            measured.hashes[subjects[i].name] =
                round == 0 ? hash_of(*subjects[i].store) : measured.hashes[subjects[i].name];
            subjects[i].store.reset();
        }
    }
    return measured;
}

/// Ten rounds in which every page of a tile is rewritten, each a commit. The most that lay on disk, and what is left.
Measured measure_sizes() {
    const BenchFolder folder;
    std::vector<Subject> subjects = filled(folder);
    Measured measured;
    for (Subject& subject : subjects) {
        double most = 0, live = 0;
        for (std::size_t round = 1; round <= 10; ++round) {
            measured.timed[subject.name].run([&] {
                for (std::size_t page = 0; page < kTilePages; ++page)
                    check(subject.store->put(key_of(page), blob_of(page, round)));
                check(subject.store->commit(round + 1));
            });
            most = std::max(most, static_cast<double>(bytes_in(subject.folder)));
            keep_up(subject, measured);
        }
        for (std::size_t page = 0; page < kTilePages; ++page) live += static_cast<double>(blob_of(page, 10).size());
        measured.hashes[subject.name] = hash_of(*subject.store);
        measured.counters[subject.name]["live_MiB"] = live / 1048576;
        measured.counters[subject.name]["most_over_live"] = most / live;
        subject.store.reset();  // a database tidies up as it closes
        measured.counters[subject.name]["closed_over_live"] = static_cast<double>(bytes_in(subject.folder)) / live;
    }
    return measured;
}

const Measured& measured(const std::string& what, std::size_t pages) {
    static std::map<std::pair<std::string, std::size_t>, Measured> all;
    const auto key = std::pair(what, pages);
    if (const auto known = all.find(key); known != all.end()) return known->second;
    Measured made = what == "commit"    ? measure_commits(pages)
                    : what == "load"    ? measure_loads(pages)
                    : what == "opening" ? measure_opening()
                                        : measure_sizes();
    return all[key] = std::move(made);
}

void engine_row(benchmark::State& state, const std::string& what, const std::string& name) {
    const Measured& all = measured(what, static_cast<std::size_t>(state.range(0)));
    const Timed& timed = all.timed.at(name);
    for (auto _ : state) state.SetIterationTime(timed.wall().p50 / 1e3);
    timed.report(state);
    if (const auto plain = all.timed.find("plain"); plain != all.timed.end()) {
        plain->second.report(state, "plain_");
        state.counters["ratio"] = timed.wall().p50 / plain->second.wall().p50;
        state.counters["cpu_ratio"] = timed.cpu().p50 / plain->second.cpu().p50;
    }
    if (const auto upkeep = all.upkeep.find(name); upkeep != all.upkeep.end()) {
        state.counters["compaction_mean_wall_ms"] = upkeep->second.mean_wall_ms();
        state.counters["compaction_mean_cpu_ms"] = upkeep->second.mean_cpu_ms();
    }
    if (const auto counters = all.counters.find(name); counters != all.counters.end())
        for (const auto& [counter, number] : counters->second) state.counters[counter] = number;
    if (const auto hash = all.hashes.find(name); hash != all.hashes.end()) report_hash(state, hash->second);
}

void missing_row(benchmark::State& state) {
    state.SkipWithError(("this build has no" + missing_engines() + ": install, configure again").c_str());
}

const bool kRegistered = [] {
    const auto add = [](const std::string& what, const std::string& name, const std::vector<std::int64_t>& pages) {
        auto* row = benchmark::RegisterBenchmark(("engines/" + what + "/" + name).c_str(), engine_row, what, name);
        for (const std::int64_t count : pages) row->Arg(count);
        row->ArgName("pages")->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);
    };
    for (const Engine& engine : engines()) {
        add("commit", engine.name, {1, 16, 1024});
        add("load", engine.name, {64, 1024});
        add("opening", engine.name, {16 * kTilePages});
        add("size", engine.name, {kTilePages});
    }
    add("load", "decode_alone", {64, 1024});
    if (!missing_engines().empty()) benchmark::RegisterBenchmark("engines/missing", missing_row)->Iterations(1);
    return true;
}();

}  // namespace
}  // namespace tilth::bench
