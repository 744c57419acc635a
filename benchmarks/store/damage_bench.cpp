// What does one flipped bit cost, by engine? A store of 256 pages in two versions, 1 000 times copied, damaged and
// opened in a process of its own, where every blob is read. Not a time: counts of what a host would then see.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <random>

#include "store/engines.h"
#include "store/sample_pages.h"
#include "store/store_timing.h"
#include "tilth/core/hash.h"
#include "tilth/store/page_codec.h"

namespace tilth::bench {
namespace {

using Blob = std::vector<std::byte>;
constexpr std::size_t kPages = 256;
enum class Damage { Bit, Sector };
constexpr std::size_t kSectorBytes = 4096;
constexpr unsigned kMostSeconds = 10;  // a reader that is not back by then runs in a circle

BlobKey key_of(std::size_t page) {
    return {BlobKind::DetailPage, static_cast<std::int32_t>(page % 16), static_cast<std::int32_t>(page / 16)};
}

/// What the reader saw.
struct Sight {
    std::int32_t opened = 0;
    std::int32_t said = 0;     ///< opening said that something is wrong
    std::int32_t failed = 0;   ///< blobs that were an error
    std::int32_t missing = 0;  ///< blobs that are not there, and no error
    std::int32_t wrong = 0;    ///< other bytes than were ever put, and no error
    std::int32_t passed = 0;   ///< of those, the ones whose page decodes, as another page
    std::int32_t old = 0;      ///< the bytes of the first version, and no error
};

Sight look(const Engine& engine, const std::string& folder, const std::vector<Blob>& first,
           const std::vector<Blob>& second) {
    Sight sight;
    auto opened = engine.open(folder);
    if (!opened) return sight;
    sight.opened = 1;
    sight.said = opened->said_damage ? 1 : 0;
    for (std::size_t page = 0; page < kPages; ++page) {
        const auto got = opened->store->get(key_of(page));
        if (!got)
            ++sight.failed;
        else if (!*got)
            ++sight.missing;
        else if (**got == first[page])
            ++sight.old;
        else if (**got != second[page]) {
            ++sight.wrong;
            const auto codes = decode_page(**got, "page");
            sight.passed += codes && **codes != *value(decode_page(second[page], "page"));
        }
    }
    return sight;
}

/// `look` in a process of its own; empty where that one did not come back.
std::optional<Sight> look_apart(const Engine& engine, const std::string& folder, const std::vector<Blob>& first,
                                const std::vector<Blob>& second) {
    int ends[2];
    if (::pipe(ends) != 0) std::perror("tilth-bench: pipe"), std::exit(1);
    const pid_t child = ::fork();
    if (child < 0) std::perror("tilth-bench: fork"), std::exit(1);
    if (child == 0) {
        ::close(2);  // what an engine says as it falls
        ::alarm(kMostSeconds);
        const Sight sight = look(engine, folder, first, second);
        const bool sent = ::write(ends[1], &sight, sizeof sight) == sizeof sight;
        ::_exit(sent ? 0 : 1);
    }
    ::close(ends[1]);
    Sight sight;
    const bool came = ::read(ends[0], &sight, sizeof sight) == sizeof sight;
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (!came || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
    return sight;
}

struct FileCopy {
    std::string name;
    std::vector<char> bytes;
};

std::vector<FileCopy> files_in(const std::filesystem::path& folder) {
    std::vector<FileCopy> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        std::ifstream in(entry.path(), std::ios::binary);
        files.push_back({entry.path().filename().string(), {std::istreambuf_iterator<char>(in), {}}});
    }
    std::sort(files.begin(), files.end(), [](const FileCopy& a, const FileCopy& b) { return a.name < b.name; });
    return files;
}

void write_to(const std::filesystem::path& folder, const std::vector<FileCopy>& files) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    for (const FileCopy& file : files) {
        std::ofstream out(folder / file.name, std::ios::binary);
        out.write(file.bytes.data(), static_cast<std::streamsize>(file.bytes.size()));
    }
}

void damage(benchmark::State& state, std::size_t which, Damage kind) {
    const Engine& engine = engines()[which];
    std::vector<Blob> all;
    for (const SampleKind made_of : {SampleKind::Prints, SampleKind::Adds, SampleKind::Craters, SampleKind::Dense})
        for (const Page& page : sample_pages(made_of, HeightPrecision::bits32, kPages))
            all.push_back(encode_page(*page.codes, HeightPrecision::bits32));
    std::shuffle(all.begin(), all.end(), std::mt19937(1));
    const std::vector<Blob> first(all.begin(), all.begin() + kPages), second(all.end() - kPages, all.end());
    const BenchFolder folder;
    {
        const auto store = std::move(value(engine.open(folder.make("whole"))).store);
        for (const std::vector<Blob>* version : {&first, &second}) {
            for (std::size_t page = 0; page < kPages; ++page) check(store->put(key_of(page), (*version)[page]));
            check(store->commit(version == &first ? 1 : 2));
        }
    }
    std::vector<FileCopy> files = files_in(folder.path() / "whole");
    std::size_t bytes = 0;
    for (const FileCopy& file : files) bytes += file.bytes.size();
    std::mt19937_64 random(1);
    double harmless = 0, said_only = 0, one = 0, several = 0, shut = 0, fell = 0, lost = 0, missing = 0, wrong = 0,
           old = 0, passed = 0;
    for (auto _ : state) {
        const Sight whole = look_apart(engine, folder.path() / "whole", first, second).value_or(Sight{});
        if (whole.opened != 1 || whole.failed + whole.missing + whole.wrong + whole.old > 0) {
            state.SkipWithError("without damage it does not read what was put");
            return;
        }
        const int tries = kind == Damage::Bit ? 1000 : 300;
        for (int i = 0; i < tries; ++i) {
            std::size_t at = random() % bytes;
            FileCopy* file = files.data();
            for (; at >= file->bytes.size(); ++file) at -= file->bytes.size();
            const std::vector<char> was = file->bytes;
            if (kind == Damage::Bit) {
                file->bytes[at] = static_cast<char>(was[at] ^ 1 << random() % 8);
            } else {
                const std::size_t begin = at / kSectorBytes * kSectorBytes;
                std::fill_n(file->bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                            std::min(kSectorBytes, was.size() - begin), '\0');
            }
            write_to(folder.path() / "damaged", files);
            file->bytes = was;
            const std::optional<Sight> sight = look_apart(engine, folder.path() / "damaged", first, second);
            if (!sight) {
                fell += 1;
                continue;
            }
            if (sight->opened == 0) {
                shut += 1;
                continue;
            }
            const int gone = sight->failed + sight->missing;
            if (sight->failed > 0 || sight->said != 0) {
                (gone == 0 ? said_only : gone == 1 ? one : several) += 1;
                lost += gone;
            } else if (sight->missing > 0) {
                missing += 1;
            }
            wrong += sight->wrong > 0;
            passed += sight->passed;
            old += sight->old > 0 && sight->said == 0 && sight->failed == 0;
            harmless += gone + sight->wrong + sight->old + sight->said == 0;
        }
        state.SetIterationTime(1e-9);
    }
    state.counters["MiB"] = static_cast<double>(bytes) / 1048576;
    state.counters["nothing_happened"] = harmless;
    state.counters["said_nothing_lost"] = said_only;
    state.counters["said_one_blob_lost"] = one;
    state.counters["said_more_lost"] = several;
    state.counters["blobs_lost"] = lost;
    state.counters["would_not_open"] = shut;
    state.counters["silently_wrong"] = wrong;
    state.counters["wrong_and_decodes"] = passed;
    state.counters["silently_missing"] = missing;
    state.counters["silently_old"] = old;
    state.counters["crash_or_hang"] = fell;
}

const bool kRegistered = [] {
    // How SQLite syncs makes no difference to a file that was closed.
    for (const Damage kind : {Damage::Bit, Damage::Sector})
        for (std::size_t i = 0; i < engines().size(); ++i) {
            if (std::strcmp(engines()[i].name, "sqlite_normal") == 0) continue;
            const std::string name = kind == Damage::Bit ? "damage/bit/" : "damage/sector/";
            benchmark::RegisterBenchmark((name + engines()[i].name).c_str(), damage, i, kind)
                ->UseManualTime()
                ->Iterations(1);
        }
    return true;
}();

}  // namespace
}  // namespace tilth::bench
