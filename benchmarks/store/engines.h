// The engines that the library's own store was chosen among, behind the library's own interface.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tilth/store/blob_store.h"

namespace tilth::bench {

struct OpenStore {
    std::unique_ptr<BlobStore> store;
    bool said_damage = false;  ///< opening found that something is wrong, and said so
};

struct Engine {
    const char* name;
    /// Of a folder that exists; durable commits, as the engine's manual has them.
    std::function<Result<OpenStore>(const std::string& folder)> open;
    bool compacts = false;  ///< the host's worker has to call `compact` now and then
};

/// The library's `LogStore`, and of SQLite and LMDB those that this program was built with.
const std::vector<Engine>& engines();
/// Empty: all are there.
std::string missing_engines();

#ifdef TILTH_BENCH_SQLITE
enum class Synchronous { Full, Normal };
/// One table, write-ahead log. `Normal`: a commit may be lost by a power cut, a checkpoint is not.
Result<OpenStore> open_sqlite(const std::string& folder, Synchronous synchronous);
#endif
#ifdef TILTH_BENCH_LMDB
Result<OpenStore> open_lmdb(const std::string& folder);
#endif

/// A folder that is gone with the object. Below `TILTH_BENCH_FOLDER`, or the system's temporary one.
class BenchFolder {
public:
    BenchFolder();
    ~BenchFolder();
    BenchFolder(const BenchFolder&) = delete;
    BenchFolder& operator=(const BenchFolder&) = delete;
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    /// A new folder in it.
    [[nodiscard]] std::string make(const std::string& name) const;

private:
    std::filesystem::path path_;
};

/// Of all files in a folder.
std::uint64_t bytes_in(const std::filesystem::path& folder);

}  // namespace tilth::bench
