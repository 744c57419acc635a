// Blobs in a file of our own that only ever grows, and is rewritten when half of it is waste.
#pragma once

#include <memory>
#include <string>

#include "tilth/store/blob_store.h"
#include "tilth/store/file_system.h"

namespace tilth {

struct LogStoreSettings {
    /// Compaction begins when waste exceeds this share of the file and `least_waste_bytes`.
    double most_waste = 0.5;
    std::uint64_t least_waste_bytes = 4u << 20;
};

/// What opening found.
struct LogStoreReport {
    std::uint64_t truncated_bytes = 0;  ///< of what was never committed
    /// Each with file and offset. Of blobs only after a scan: else `get` finds them damaged.
    std::vector<Error> damage;
    bool was_scanned = false;     ///< the index was damaged or cut off, the file was read from end to end
    bool may_miss_blobs = false;  ///< and what was there could not be told: blobs may be missing, or of an older commit
};

/// The default `BlobStore`. See FORMATS.md for the bytes.
///
/// One file `pages-<n>.tlp`: blobs in frames with checksums, appended. A commit appends an index of what changed,
/// syncs, and writes a superblock that points to it, into one of two places by turns; so a crash at any moment,
/// whatever part of the unsynced bytes the disk has, leaves the last commit or the one before it.
///
/// Opening reads the indexes alone: cost by the number of blobs that can be got. What lies behind the last commit is
/// cut off. A damaged blob costs that blob, also where a superblock is damaged with it; a damaged index is made again
/// from the frames (`was_scanned`); a file that was cut short is as of the newest commit that it has all of (`mark`
/// says which). A file in which no commit can be found is put aside under another name, never written over. Compaction
/// copies live blobs to the next file, step by step, and removes the old one when the new one is complete and durable;
/// until then nothing depends on the new one. Damaged blobs stay damaged there.
///
/// After a sync that failed, what was put since the last commit may be gone even from memory (the system drops it).
/// Commits, and the end of a compaction, then fail with FileWrite and name a blob that is gone, as long as there is
/// one: put it again, or erase it.
///
/// A `put` costs a copy; every MiB of them is written, without a sync. A `commit` costs two syncs. Memory: about 150
/// bytes a blob, 1 MiB of puts. A commit that failed late may turn out to be durable after a crash, as one.
class LogStore final : public BlobStore {
public:
    /// `folder` exists, and is locked by the caller. `salt`: of the world; files of another world are refused. Fails
    /// with FileFormat (another world's, a newer version, no file of ours: nothing is touched), NotFound, FileRead,
    /// FileWrite.
    static Result<std::unique_ptr<LogStore>> open(FileSystem& files, std::string folder, std::uint64_t salt,
                                                  const LogStoreSettings& settings, LogStoreReport& report);
    ~LogStore() override;

    Result<std::vector<BlobKey>> keys(BlobKind kind) override;
    Result<std::optional<std::vector<std::byte>>> get(BlobKey key) override;
    Result<void> put(BlobKey key, std::span<const std::byte> bytes) override;
    Result<void> erase(BlobKey key) override;
    Result<void> commit(std::uint64_t mark) override;
    [[nodiscard]] std::uint64_t mark() const override;
    /// The mark of the commit that made the present blob durable; empty: none did yet, or it is not known.
    [[nodiscard]] std::optional<std::uint64_t> mark_of(BlobKey key) const;
    [[nodiscard]] Size size() const override;
    /// Begins as the settings say; forced: with waste of more than 3 % of the file. Until it ends both files are there.
    Result<bool> compact(std::uint64_t most_bytes, bool forced = false) override;

private:
    struct Impl;
    explicit LogStore(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace tilth
