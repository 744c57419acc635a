#include "store/engines.h"

#include <unistd.h>

#include <cstdlib>

#include "tilth/store/file_system.h"
#include "tilth/store/log_store.h"

namespace tilth::bench {
namespace {

Result<OpenStore> open_log(const std::string& folder) {
    LogStoreReport report;
    auto store = LogStore::open(system_files(), folder, 0x7171, {}, report);
    if (!store) return store.error();
    return OpenStore{*std::move(store), !report.damage.empty() || report.was_scanned || report.truncated_bytes > 0};
}

}  // namespace

const std::vector<Engine>& engines() {
    static const std::vector<Engine> all = {
        {"log", open_log, true},
#ifdef TILTH_BENCH_SQLITE
        {"sqlite_full", [](const std::string& folder) { return open_sqlite(folder, Synchronous::Full); }, false},
        {"sqlite_normal", [](const std::string& folder) { return open_sqlite(folder, Synchronous::Normal); }, false},
#endif
#ifdef TILTH_BENCH_LMDB
        {"lmdb", open_lmdb, false},
#endif
    };
    return all;
}

std::string missing_engines() {
    std::string missing;
#ifndef TILTH_BENCH_SQLITE
    missing += " SQLite (libsqlite3-dev)";
#endif
#ifndef TILTH_BENCH_LMDB
    missing += " LMDB (liblmdb-dev)";
#endif
    return missing;
}

BenchFolder::BenchFolder() {
    static int count = 0;
    const char* named = std::getenv("TILTH_BENCH_FOLDER");
    const std::filesystem::path root = named != nullptr ? named : std::filesystem::temp_directory_path();
    path_ = root / ("tilth_bench_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
}

BenchFolder::~BenchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::string BenchFolder::make(const std::string& name) const {
    std::filesystem::create_directories(path_ / name);
    return (path_ / name).string();
}

std::uint64_t bytes_in(const std::filesystem::path& folder) {
    std::uint64_t bytes = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) bytes += entry.file_size();
    return bytes;
}

}  // namespace tilth::bench
