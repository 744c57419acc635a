#include "tilth/store/world_folder.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "tilth/store/shape_files.h"
#include "tilth/store/snapshot_writer.h"
#include "tilth/store/world_creation.h"
#include "tilth/store/world_pages.h"
#include "tilth/store/world_recovery.h"
#include "tilth/store/world_repair.h"
#include "tilth/store/world_verify.h"

namespace tilth {
namespace {

// What a snapshot copies at most, to make room.
constexpr std::uint64_t kCompactionStep = 16u << 20;

}  // namespace

// `blobs_mutex` guards the store and all that stands under it; it is held for as long as a commit takes. `errors_mutex`
// is held for moments. The journal guards itself.
struct WorldFolder::Impl {
    std::string folder;
    FileSystem* files = nullptr;
    WorldOptions options;
    WorldIdentity identity;
    std::unique_ptr<FileLock> lock;
    const ShapeLibrary* shapes = nullptr;  // the ground's
    std::uint32_t kept_shapes = 0;         // ids below it
    std::unique_ptr<Journal> journal;
    std::atomic<std::uint64_t> committed = 0, page_bytes = 0, live_page_bytes = 0, temporary_page_bytes = 0;

    std::mutex blobs_mutex;
    std::shared_ptr<BlobStore> blobs;  // nullptr: abandoned
    std::optional<WorldPages> pages;
    std::optional<WorldRepair> repair;
    std::map<TileIndex, std::vector<WaitingStamp>> waiting;  // as of the last commit
    std::optional<SnapshotWriter> writer;
    std::set<PageIndex> reported;  // damaged detail pages, each told once
    bool is_over_reported = false;

    std::mutex errors_mutex;
    std::vector<Error> errors;

    Result<void> open_stores(Ground& ground, RecoveredWorld& recovered);
    [[nodiscard]] Result<void> usable() const;
    void report(Error error);
    void note_sizes();
    /// What an unfinished compaction has is not counted: it goes when the compaction ends.
    [[nodiscard]] std::uint64_t disk_bytes() const { return journal->disk_bytes() + page_bytes - temporary_page_bytes; }
    [[nodiscard]] bool is_over_budget() const {
        return options.most_disk_bytes != 0 && disk_bytes() > options.most_disk_bytes;
    }

    Result<void> repair_pages(TileIndex tile, std::map<PageIndex, Error>& damaged, std::vector<Page>& pages);
    void keep_to_budget(std::uint64_t edits);
};

WorldFolder::WorldFolder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WorldFolder::~WorldFolder() = default;

Result<void> WorldFolder::Impl::usable() const {
    if (blobs != nullptr) return {};
    return Error{ErrorCode::FileWrite, text(folder, ": the world was abandoned; open it again")};
}

void WorldFolder::Impl::report(Error error) {
    const std::lock_guard guard(errors_mutex);
    errors.push_back(std::move(error));
}

void WorldFolder::Impl::note_sizes() {
    const BlobStore::Size size = blobs->size();
    page_bytes = size.disk_bytes;
    live_page_bytes = size.live_bytes;
    temporary_page_bytes = size.temporary_bytes;
}

// ---------------------------------------------------------------------------------------------------- opening

Result<std::shared_ptr<WorldFolder>> WorldFolder::open(const std::string& folder, Ground& ground,
                                                       const WorldOptions& options, RecoveredWorld& recovered) {
    recovered = {};
    auto impl = std::make_unique<Impl>();
    impl->folder = folder;
    while (impl->folder.size() > 1 && impl->folder.ends_with('/')) impl->folder.pop_back();
    impl->files = options.files != nullptr ? options.files : &system_files();
    impl->options = options;
    if (const Result<void> made = make_world_folder(*impl->files, impl->folder); !made) return made.error();
    auto lock = impl->files->lock(impl->folder + "/lock");
    if (!lock) return lock.error();
    impl->lock = std::move(*lock);

    auto identity = identity_in(*impl->files, impl->folder, ground, options.heights, recovered.is_new);
    if (!identity) return identity.error();
    impl->identity = std::move(*identity);
    const auto shapes = read_shapes(*impl->files, impl->folder, impl->identity.salt, ground.shapes());
    if (!shapes) return shapes.error();
    impl->kept_shapes = *shapes;
    impl->shapes = &ground.shapes();
    if (const Result<void> opened = impl->open_stores(ground, recovered); !opened) return opened.error();
    return std::shared_ptr<WorldFolder>(new WorldFolder(std::move(impl)));
}

Result<void> WorldFolder::Impl::open_stores(Ground& ground, RecoveredWorld& recovered) {
    blobs = options.blobs;
    LogStoreReport store_report;
    if (blobs == nullptr) {
        auto store = LogStore::open(*files, folder, identity.salt, options.log, store_report);
        if (!store) return store.error();
        blobs = std::move(*store);
    }
    committed = blobs->mark();
    JournalReport journal_report;
    auto opened =
        Journal::open(*files, folder, identity.salt, committed, options.flush, journal_report, recovered.tail);
    if (!opened) return opened.error();
    journal = std::move(*opened);
    recovered.reports = std::move(journal_report.damage);
    std::vector<Error> lost_blobs = std::move(store_report.damage);
    if (!store_report.may_miss_blobs)
        recovered.reports.insert(recovered.reports.end(), lost_blobs.begin(), lost_blobs.end()), lost_blobs.clear();

    const GroundSettings& settings = ground.settings();
    const MapGeometry &coarse = ground.map(MapKind::Coarse), &detail = ground.map(MapKind::Detail);
    pages.emplace(*blobs, folder, settings.tile_size, coarse, ground.original_codes());
    repair.emplace(WorldRepair::Place{.files = files,
                                      .folder = folder,
                                      .salt = identity.salt,
                                      .coarse = coarse,
                                      .detail = detail,
                                      .tiles = {.size = settings.tile_size, .map = detail.grid.rect()},
                                      .original = ground.original_codes()},
                   *journal);
    if (const Result<void> read = pages->read_keys(); !read) return read;
    WorldRecovery recovery(*blobs, *pages, *repair, folder, settings.precision);
    if (const Result<void> run = recovery.run(lost_blobs, recovered); !run) return run;
    waiting = recovered.waiting;
    std::set<TileIndex> waiting_tiles;
    for (const auto& [tile, stamps] : waiting) waiting_tiles.insert(tile);
    writer.emplace(*blobs, *pages, folder, settings.precision, std::move(waiting_tiles), recovery.stroke_parts());
    repair->forget();
    note_sizes();
    return {};
}

// ---------------------------------------------------------------------------------------------------- the journal

Result<void> WorldFolder::keep_shape(ShapeId id, const Shape& shape) {
    // Ids have no gaps, so the shapes before it are kept with it.
    for (std::uint32_t& kept = impl_->kept_shapes; kept <= id.value; ++kept) {
        const Shape& next = kept == id.value ? shape : impl_->shapes->shape({kept});
        const Result<void> written = write_shape(*impl_->files, impl_->folder, impl_->identity.salt, {kept}, next);
        if (!written) return written;
    }
    return {};
}

std::uint64_t WorldFolder::append(const Edit& edit) { return impl_->journal->append(edit); }
Result<void> WorldFolder::flush() { return impl_->journal->flush(); }
std::uint64_t WorldFolder::appended() const { return impl_->journal->appended(); }
std::uint64_t WorldFolder::durable() const { return impl_->journal->durable(); }
std::uint64_t WorldFolder::committed() const { return impl_->committed; }
Result<std::vector<Edit>> WorldFolder::read_edits(std::uint64_t first, std::uint64_t last) {
    return impl_->journal->read(first, last);
}
std::uint64_t WorldFolder::first_edit() const { return impl_->journal->first(); }

// ---------------------------------------------------------------------------------------------------- tiles

Result<std::vector<TileIndex>> WorldFolder::tiles() {
    const std::lock_guard guard(impl_->blobs_mutex);
    if (const Result<void> usable = impl_->usable(); !usable) return usable.error();
    const std::vector<TileIndex> with_pages = impl_->pages->tiles();
    std::set<TileIndex> all(with_pages.begin(), with_pages.end());
    const std::set<TileIndex>& waiting = impl_->writer->waiting_tiles();
    all.insert(waiting.begin(), waiting.end());
    return std::vector<TileIndex>(all.begin(), all.end());
}

Result<std::vector<Page>> WorldFolder::load(TileIndex tile, const PageRect& pages) {
    const std::lock_guard guard(impl_->blobs_mutex);
    if (const Result<void> usable = impl_->usable(); !usable) return usable.error();
    if (impl_->pages->is_torn(tile))
        return Error{ErrorCode::FileRead, text(impl_->folder, ": tile (", tile.x, ", ", tile.z,
                                               ") was saved in part, for an error; save it again")};
    auto found = impl_->pages->load(tile, pages);
    if (!found) return found.error();
    if (!found->damaged.empty())
        if (const Result<void> repaired = impl_->repair_pages(tile, found->damaged, found->pages); !repaired)
            return repaired.error();
    return std::move(found->pages);
}

/// A page that the last commit left as it is now can be made again as of that commit: what did not wait then was
/// applied.
Result<void> WorldFolder::Impl::repair_pages(TileIndex tile, std::map<PageIndex, Error>& damaged,
                                             std::vector<Page>& found) {
    std::set<PageIndex> wanted;
    for (const auto& [page, error] : damaged)
        if (!pages->is_pending(page)) wanted.insert(page);
    std::vector<WaitingStamp> left_out;
    if (const auto stamps = waiting.find(tile); stamps != waiting.end()) left_out = stamps->second;
    auto rebuilt = wanted.empty() ? Result<std::vector<Page>>(std::vector<Page>())
                                  : repair->pages(committed, MapKind::Detail, wanted, left_out);
    if (!rebuilt && !is_beyond_repair(rebuilt.error())) return rebuilt.error();  // later, then
    for (const auto& [page, error] : damaged) {
        if (!reported.insert(page).second) continue;
        const std::string outcome = !wanted.contains(page) ? "lost, it was not yet committed; it reads as untouched"
                                    : rebuilt              ? "rebuilt from the journal"
                                                           : "lost, it reads as untouched: " + rebuilt.error().message;
        report({error.code, text(error.message, "; ", outcome)});
    }
    if (!rebuilt) return {};
    for (Page& page : *rebuilt) {
        // Where the disk does not take it, it is made again next time.
        if (const Result<void> put = pages->replace(MapKind::Detail, page); !put) report(put.error());
        found.push_back(std::move(page));
    }
    return {};
}

Result<void> WorldFolder::save(TileIndex tile, std::span<const Page> pages) {
    const std::lock_guard guard(impl_->blobs_mutex);
    if (const Result<void> usable = impl_->usable(); !usable) return usable;
    const Result<void> saved = impl_->pages->save(tile, pages);
    impl_->note_sizes();
    return saved;
}

// ---------------------------------------------------------------------------------------------------- commits

Result<void> WorldFolder::commit(const Snapshot& snapshot) {
    if (const Result<void> flushed = impl_->journal->flush(); !flushed) return flushed;
    const std::lock_guard guard(impl_->blobs_mutex);
    if (const Result<void> usable = impl_->usable(); !usable) return usable;
    const Result<void> written = impl_->writer->write(snapshot);
    impl_->note_sizes();
    if (!written) return written;

    impl_->committed = snapshot.edits;
    impl_->pages->committed();
    impl_->repair->forget();
    for (const TileSnapshot& tile : snapshot.tiles)
        if (tile.waiting.empty())
            impl_->waiting.erase(tile.tile);
        else
            impl_->waiting[tile.tile] = tile.waiting;
    // The world is safe from here on: trouble with old files is told, not returned.
    const Result<void> released = impl_->journal->release(snapshot.edits, impl_->options.keep_journal_bytes);
    if (!released) impl_->report(released.error());
    impl_->keep_to_budget(snapshot.edits);
    return {};
}

void WorldFolder::Impl::keep_to_budget(std::uint64_t edits) {
    const std::uint64_t most = options.most_disk_bytes;
    if (is_over_budget()) {
        const std::uint64_t journal_now = journal->disk_bytes(), over = disk_bytes() - most;
        const Result<void> released = journal->release(edits, journal_now > over ? journal_now - over : 0);
        if (!released) report(released.error());
    }
    if (is_over_budget()) {
        // One step: `load` waits meanwhile. The others come with `compact`.
        const auto more = blobs->compact(kCompactionStep, true);
        note_sizes();
        if (!more) report(more.error());
        if (more && *more) return;
    }
    const bool was_reported = std::exchange(is_over_reported, is_over_budget());
    if (is_over_reported && !was_reported)
        report(
            {ErrorCode::FileWrite, text(folder, ": the world has ", disk_bytes(), " bytes on disk (journal ",
                                        journal->disk_bytes(), ", pages ", page_bytes.load(), ", of which ",
                                        live_page_bytes.load(), " are in use), and most_disk_bytes is ", most,
                                        "; nothing is dropped for space: raise the bound, or keep less undo history")});
}

Result<bool> WorldFolder::compact(std::uint64_t most_bytes) {
    const std::lock_guard guard(impl_->blobs_mutex);
    if (const Result<void> usable = impl_->usable(); !usable) return usable.error();
    auto more = impl_->blobs->compact(most_bytes, impl_->is_over_budget());
    impl_->note_sizes();
    return more;
}

// ---------------------------------------------------------------------------------------------------- state

WorldFolder::Size WorldFolder::size() const {
    return {.journal_bytes = impl_->journal->disk_bytes(),
            .page_bytes = impl_->page_bytes,
            .live_page_bytes = impl_->live_page_bytes};
}

std::vector<Error> WorldFolder::verify() {
    const std::lock_guard guard(impl_->blobs_mutex);
    if (const Result<void> usable = impl_->usable(); !usable) return {usable.error()};
    return verify_world({.files = impl_->files,
                         .folder = impl_->folder,
                         .salt = impl_->identity.salt,
                         .blobs = impl_->blobs.get(),
                         .pages = &*impl_->pages,
                         .journal = impl_->journal.get()});
}

std::vector<Error> WorldFolder::take_errors() {
    std::vector<Error> taken = impl_->journal->take_errors();
    const std::lock_guard guard(impl_->errors_mutex);
    taken.insert(taken.end(), impl_->errors.begin(), impl_->errors.end());
    impl_->errors.clear();
    return taken;
}

const WorldIdentity& WorldFolder::identity() const { return impl_->identity; }
const std::string& WorldFolder::folder() const { return impl_->folder; }

void WorldFolder::abandon() {
    impl_->journal->abandon();
    const std::lock_guard guard(impl_->blobs_mutex);
    impl_->writer.reset();
    impl_->repair.reset();
    impl_->pages.reset();
    impl_->blobs.reset();
    impl_->lock.reset();
}

}  // namespace tilth
