// A world on disk: pages, journal, shapes and lock in one folder; opening it, and what opening repairs.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/ground.h"
#include "tilth/store/blob_store.h"
#include "tilth/store/file_system.h"
#include "tilth/store/journal.h"
#include "tilth/store/log_store.h"
#include "tilth/store/snapshot.h"
#include "tilth/store/tile_store.h"
#include "tilth/store/world_identity.h"

namespace tilth {

struct WorldOptions {
    FlushPolicy flush;
    /// Journal behind the last snapshot that stays, so that damaged pages can be rebuilt: at most this much. 64 bytes
    /// an edit; while it reaches back to the first edit every page can be.
    std::uint64_t keep_journal_bytes = 64u << 20;
    /// Of journal and pages; 0: no bound. Beyond it old journal goes, then waste, a step with each snapshot and each
    /// `compact`; while that goes on, the new copy of the pages comes on top. Where that does not help, it is reported
    /// (`take_errors`), once while it lasts: nothing that was dented is dropped for space.
    std::uint64_t most_disk_bytes = 0;
    std::string heights;               ///< note of where the heights come from, kept when the world is made
    FileSystem* files = nullptr;       ///< nullptr: the system's
    std::shared_ptr<BlobStore> blobs;  ///< nullptr: a `LogStore` in the folder. It belongs to this world alone
    LogStoreSettings log;              ///< of that `LogStore`
};

/// What opening found, to be put into the ground: first the pages, then the waiting stamps and the history, then the
/// tail, edit by edit.
struct RecoveredWorld {
    bool is_new = false;
    std::uint64_t next_sequence = 1;
    std::vector<Page> coarse;
    std::map<TileIndex, std::vector<WaitingStamp>> waiting;
    std::vector<StrokePtr> done, undone;
    std::uint64_t next_stroke = 1;
    std::vector<Edit> tail;                ///< edits that the pages do not hold
    std::vector<Error> reports;            ///< damage that was found, each with file and offset, and what became of it
    std::uint64_t repaired = 0, lost = 0;  ///< pages
};

/// The durable store of one world.
///
/// The journal has every edit; the pages have the world as of the last snapshot. A crash at any moment loses what was
/// not flushed and nothing else: opening takes the pages as of the last commit and replays the journal's tail. A page
/// whose checksum is wrong is rebuilt from the original ground and the journal where that reaches back to the first
/// edit; else it is reported and reads as untouched. One lock: a second process is refused.
///
/// As a `TileStore` it serves the cache: `save` is seen by `load` at once and is durable with the next `commit`.
/// Threads: `append`, `keep_shape` and `flush` on the owner's; `load`, `save`, `commit` and `compact` one at a time, on
/// any other; `take_errors` and `abandon` anywhere.
class WorldFolder final : public TileStore {
public:
    /// Opens or makes the world in `folder` (made where its parent exists). `ground`: no stamp has touched it; used
    /// here alone: its shapes become those of the world. Fails with Locked, with FileWrite or FileRead (the folder
    /// cannot be made, read or written), with InvalidArgument (another world's heights or settings: the field is
    /// named), with FileFormat (a newer version; an identity or shape that is damaged: nothing is touched then).
    static Result<std::shared_ptr<WorldFolder>> open(const std::string& folder, Ground& ground,
                                                     const WorldOptions& options, RecoveredWorld& recovered);
    ~WorldFolder() override;

    // The journal.

    /// Keeps a shape of the ground that a stamp is about to use, and those with lower ids; nothing to do for built-in
    /// ones and those already kept. Durable on return.
    Result<void> keep_shape(ShapeId id, const Shape& shape);
    std::uint64_t append(const Edit& edit);
    Result<void> flush();
    [[nodiscard]] std::uint64_t appended() const;
    [[nodiscard]] std::uint64_t durable() const;
    /// Of the last commit: the edits that the pages hold.
    [[nodiscard]] std::uint64_t committed() const;
    /// Reads edits back, for replay; see `Journal::read`.
    Result<std::vector<Edit>> read_edits(std::uint64_t first, std::uint64_t last);
    [[nodiscard]] std::uint64_t first_edit() const;

    // The pages.

    Result<std::vector<TileIndex>> tiles() override;
    Result<std::vector<Page>> load(TileIndex tile, const PageRect& pages) override;
    Result<void> save(TileIndex tile, std::span<const Page> pages) override;
    /// Flushes the journal, writes what changed, makes it durable as one, and lets old journal go. On an error the
    /// snapshot must be taken again, larger; until then the world on disk is as before, or, where the commit failed
    /// late, as of this snapshot, wholly.
    Result<void> commit(const Snapshot& snapshot);
    /// A step of giving disk space back, of about `most_bytes`, where much is wasted or `most_disk_bytes` is exceeded.
    /// True: there is more to do.
    Result<bool> compact(std::uint64_t most_bytes);

    struct Size {
        std::uint64_t journal_bytes = 0, page_bytes = 0, live_page_bytes = 0;
    };
    [[nodiscard]] Size size() const;
    /// Reads every blob. Each error has file and offset. Changes nothing.
    std::vector<Error> verify();

    /// What went wrong in the background since the last call, and pages found damaged: each trouble once.
    [[nodiscard]] std::vector<Error> take_errors();
    [[nodiscard]] const WorldIdentity& identity() const;
    [[nodiscard]] const std::string& folder() const;
    /// Closes as a crash would: what is not flushed never will be. For tests and rehearsals.
    void abandon();

private:
    struct Impl;
    explicit WorldFolder(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace tilth
