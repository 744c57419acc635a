// Where a world's state lies on disk: blobs by key, and commits that are wholly there or not at all.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tilth/core/result.h"

namespace tilth {

enum class BlobKind : std::uint8_t {
    World = 1,       ///< one, key (0, 0): counters
    DetailPage = 2,  ///< by page index
    CoarsePage = 3,  ///< by page index
    Waiting = 4,     ///< stamps that wait for a detail tile, by tile index
    Stroke = 5,      ///< a stroke that can be undone or redone, by its number (x the low half, z the high one)
};

struct BlobKey {
    BlobKind kind = BlobKind::World;
    std::int32_t x = 0, z = 0;
    friend auto operator<=>(const BlobKey&, const BlobKey&) = default;
};

/// The interface that a host implements to keep worlds elsewhere (a database, a console's save system).
///
/// What is `put` is seen by `get` at once, and becomes durable with the next `commit`, all of it together: after a
/// crash the store is exactly as of its last commit. Blobs of up to 64 MiB; a page has 16 bytes to 16.5 KiB.
/// Threads: one call at a time, on whatever thread.
class BlobStore {
public:
    BlobStore() = default;
    virtual ~BlobStore() = default;
    BlobStore(const BlobStore&) = delete;
    BlobStore& operator=(const BlobStore&) = delete;

    /// Of one kind, sorted. Must not read blobs.
    virtual Result<std::vector<BlobKey>> keys(BlobKind kind) = 0;
    /// Empty: there is none. A damaged blob is an error (FileFormat) that says where it lies; it costs no other blob.
    virtual Result<std::optional<std::vector<std::byte>>> get(BlobKey key) = 0;
    /// On an error the old blob stays.
    virtual Result<void> put(BlobKey key, std::span<const std::byte> bytes) = 0;
    virtual Result<void> erase(BlobKey key) = 0;
    /// Everything put and erased since the last commit becomes durable, as one, under `mark`. On an error nothing of it
    /// is (it stays visible, and the next commit has it). Where the store lost some of it, this fails with FileWrite
    /// until that is put again or erased.
    virtual Result<void> commit(std::uint64_t mark) = 0;
    /// Of the last commit; 0: there was none.
    [[nodiscard]] virtual std::uint64_t mark() const = 0;

    struct Size {
        std::uint64_t live_bytes = 0;       ///< of blobs that can be got
        std::uint64_t disk_bytes = 0;       ///< of everything
        std::uint64_t temporary_bytes = 0;  ///< part of `disk_bytes`: of an unfinished compaction, gone when it ends
    };
    [[nodiscard]] virtual Size size() const = 0;
    /// Gives disk space back where much is wasted, in a step of about `most_bytes`; with `forced`, for a caller that
    /// has too little, also where little is. True: there is more to do. Safe at any kill point.
    virtual Result<bool> compact(std::uint64_t most_bytes, bool forced = false) = 0;
};

}  // namespace tilth
