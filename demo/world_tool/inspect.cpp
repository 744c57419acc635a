// info, verify, compact: what can be done without the heights.
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "demo/world_tool/commands.h"
#include "tilth/core/hash.h"
#include "tilth/store/journal.h"
#include "tilth/store/log_store.h"
#include "tilth/store/world_blobs.h"
#include "tilth/store/world_identity.h"
#include "tilth/store/world_pages.h"
#include "tilth/store/world_verify.h"

namespace tilth::demo {
namespace {

/// A world's files, locked and open, without a ground.
struct OpenFiles {
    std::unique_ptr<FileLock> lock;
    WorldIdentity identity;
    std::unique_ptr<LogStore> blobs;
    std::unique_ptr<Journal> journal;
    std::vector<Edit> tail;
    std::vector<Error> reports;  ///< what opening found
};

Result<OpenFiles> open_files(const std::string& folder) {
    OpenFiles open;
    FileSystem& files = system_files();
    auto identity = read_identity(files, folder);  // first, so that no lock is left in a folder that is no world
    if (!identity) return identity.error();
    open.identity = std::move(*identity);
    auto lock = files.lock(folder + "/lock");
    if (!lock) return lock.error();
    open.lock = std::move(*lock);
    LogStoreReport of_store;
    auto blobs = LogStore::open(files, folder, open.identity.salt, {.most_waste = 0, .least_waste_bytes = 0}, of_store);
    if (!blobs) return blobs.error();
    open.blobs = std::move(*blobs);
    JournalReport of_journal;
    auto journal = Journal::open(files, folder, open.identity.salt, open.blobs->mark(),
                                 {.when = FlushPolicy::When::Manual}, of_journal, open.tail);
    if (!journal) return journal.error();
    open.journal = std::move(*journal);
    open.reports = std::move(of_store.damage);
    open.reports.insert(open.reports.end(), of_journal.damage.begin(), of_journal.damage.end());
    return open;
}

std::uint64_t disk_bytes(const OpenFiles& open) { return open.blobs->size().disk_bytes + open.journal->disk_bytes(); }

void print_identity(const WorldIdentity& identity) {
    const GroundSettings& s = identity.settings;
    std::cout << "heights: " << (identity.heights.empty() ? "(not noted)" : identity.heights) << ", " << identity.width
              << " x " << identity.depth << " posts, hash " << hex16(identity.original_hash) << '\n'
              << "grid: " << s.spacing_m << " m between posts, origin (" << s.origin.x << ", " << s.origin.z << ")"
              << (s.mirror ? ", mirrored" : "") << ", quantum " << s.quantum_m.value_or(0) << " m, "
              << (s.precision == HeightPrecision::bits32 ? "32" : "16") << " bits\n"
              << "detail: ";
    if (s.detail)
        std::cout << s.texels_per_post << " texels a post, tiles of " << s.tile_size << " texels\n";
    else
        std::cout << "none\n";
}

}  // namespace

Outcome print_info(const std::string& folder) {
    const auto open = open_files(folder);
    if (!open) return open.error();
    print_identity(open->identity);
    const BlobStore::Size size = open->blobs->size();
    std::cout << "edits: " << open->journal->appended() << ", of which the pages hold " << open->blobs->mark()
              << "; the journal begins at edit " << open->journal->first() << '\n'
              << "bytes: journal " << open->journal->disk_bytes() << ", pages " << size.disk_bytes << ", of which "
              << size.live_bytes << " in use\n";
    const auto count = [&](BlobKind kind) {
        const auto keys = open->blobs->keys(kind);
        return keys ? keys->size() : 0;
    };
    std::cout << "blobs: " << count(BlobKind::CoarsePage) << " coarse pages, " << count(BlobKind::DetailPage)
              << " detail pages, " << count(BlobKind::Waiting) << " lists of waiting stamps, "
              << count(BlobKind::Stroke) << " of strokes\n";
    for (const Error& report : open->reports) std::cout << report.message << '\n';
    return open->reports.empty();
}

Outcome verify(const std::string& folder) {
    const auto open = open_files(folder);
    if (!open) return open.error();
    const GroundSettings& settings = open->identity.settings;
    WorldPages pages(*open->blobs, folder, settings.tile_size, {.precision = settings.precision}, nullptr);
    if (const Result<void> read = pages.read_keys(); !read) return read.error();
    std::vector<Error> found = open->reports;
    const std::vector<Error> damaged = verify_world({.files = &system_files(),
                                                     .folder = folder,
                                                     .salt = open->identity.salt,
                                                     .blobs = open->blobs.get(),
                                                     .pages = &pages,
                                                     .journal = open->journal.get()});
    found.insert(found.end(), damaged.begin(), damaged.end());
    for (const Error& error : found) std::cout << error.message << '\n';
    if (found.empty()) std::cout << "all is well: " << open->journal->appended() << " edits\n";
    return found.empty();
}

Outcome compact(const std::string& folder) {
    const auto open = open_files(folder);
    if (!open) return open.error();
    const std::uint64_t before = disk_bytes(*open);
    for (bool more = true; more;) {
        const auto step = open->blobs->compact(16u << 20);
        if (!step) return step.error();
        more = *step;
    }
    std::cout << before << " bytes before, " << disk_bytes(*open) << " now\n";
    return true;
}

}  // namespace tilth::demo
