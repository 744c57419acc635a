#include "tilth/store/log_store.h"

#include <algorithm>
#include <utility>

#include "tilth/store/log_compaction.h"
#include "tilth/store/log_open.h"

namespace tilth {

using namespace log_format;

namespace {
/// A share of the file; to copy everything for less is not worth it, even where space is short.
constexpr double kLeastForcedWaste = 0.03;
}  // namespace

struct LogStore::Impl {
    FileSystem& files;
    std::string folder;
    LogStoreSettings settings;
    std::unique_ptr<LogFile> log;
    LogState state;
    Superblock commit;  ///< the last one that is durable
    unsigned next_slot = 0;
    std::uint64_t generation = 0;  ///< of the last commit that was tried
    std::vector<LogRun> runs;      ///< its chain of indexes
    bool needs_full_index = false, needs_header = false;
    std::unique_ptr<LogCompaction> compaction;
    std::vector<std::string> leftovers;  ///< files that could not be removed

    Result<void> write_again();
    std::size_t runs_to_keep(std::size_t changes) const;
    Index next_index(std::uint64_t mark, std::size_t kept_runs, std::vector<BlobKey>& keys) const;
    bool is_wasteful(bool forced) const;
    Result<void> finish_compaction();
    void discard_compaction();
    void remove_leftovers();
};

LogStore::LogStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

LogStore::~LogStore() {
    if (impl_->compaction != nullptr) impl_->discard_compaction();
}

Result<std::unique_ptr<LogStore>> LogStore::open(FileSystem& files, std::string folder, std::uint64_t salt,
                                                 const LogStoreSettings& settings, LogStoreReport& report) {
    Result<OpenedLog> opened = open_log(files, folder, salt, report);
    if (!opened) return opened.error();
    RecoveredLog& found = opened->found;
    auto impl = std::make_unique<Impl>(Impl{files, std::move(folder), settings, std::move(opened->log)});
    impl->state.blobs = std::move(found.blobs);
    for (const auto& [key, entry] : impl->state.blobs) impl->state.live_bytes += entry.length;
    impl->commit = found.commit;
    impl->next_slot = found.slot ^ 1;
    impl->generation = found.generation;
    impl->runs = std::move(found.runs);
    impl->needs_full_index = found.was_scanned;
    impl->needs_header = found.is_header_damaged;
    return std::unique_ptr<LogStore>(new LogStore(std::move(impl)));
}

Result<std::vector<BlobKey>> LogStore::keys(BlobKind kind) {
    constexpr std::int32_t least = INT32_MIN;
    std::vector<BlobKey> keys;
    const auto& blobs = impl_->state.blobs;
    for (auto at = blobs.lower_bound({kind, least, least}); at != blobs.end() && at->first.kind == kind; ++at)
        keys.push_back(at->first);
    return keys;
}

Result<std::optional<std::vector<std::byte>>> LogStore::get(BlobKey key) {
    const std::optional<Entry> entry = impl_->state.seen(key);
    if (!entry) return std::optional<std::vector<std::byte>>{};
    Result<LogFile::StoredBlob> blob = impl_->log->read_blob(key, *entry);
    if (!blob) return blob.error();
    if (!blob->is_sound)
        return Error{ErrorCode::FileFormat,
                     text(impl_->log->path(), ": at byte ", entry->offset, ": the blob ", static_cast<int>(key.kind),
                          " (", key.x, ", ", key.z, ") of ", entry->length,
                          " bytes is damaged: it is lost, unless it is "
                          "made again")};
    return std::optional(std::move(blob->payload));
}

Result<void> LogStore::put(BlobKey key, std::span<const std::byte> bytes) {
    if (bytes.size() > kMostBlobBytes || key.kind == BlobKind{})
        return Error{ErrorCode::InvalidArgument,
                     text("blob ", static_cast<int>(key.kind), " (", key.x, ", ", key.z, "): has ", bytes.size(),
                          " bytes; at most ", kMostBlobBytes, " and a kind above 0 are allowed")};
    const Result<std::uint64_t> offset = impl_->log->append({.type = FrameType::Blob, .key = key}, bytes);
    if (!offset) return offset.error();
    impl_->state.set(key, Entry{*offset, kUnknownMark, static_cast<std::uint32_t>(bytes.size())});
    return {};
}

Result<void> LogStore::erase(BlobKey key) {
    if (!impl_->state.seen(key)) return {};
    const Result<std::uint64_t> offset = impl_->log->append({.type = FrameType::Erase, .key = key}, {});
    if (!offset) return offset.error();
    impl_->state.set(key, std::nullopt);
    return {};
}

/// After a sync that failed: what the disk may have dropped is written again, and must still be there to be read. Until
/// all of it is, or was put again or erased, this fails.
Result<void> LogStore::Impl::write_again() {
    if (!log->is_doubtful()) return {};
    if (Result<void> done = log->write_again(); !done) return done;
    for (const auto& [key, before] : state.pending) {
        const std::optional<Entry> entry = state.seen(key);
        if (!entry) continue;
        const Result<LogFile::StoredBlob> blob = log->read_blob(key, *entry);
        if (!blob) return blob.error();
        if (!blob->is_sound)
            return Error{ErrorCode::FileWrite,
                         text(log->path(), ": at byte ", entry->offset, ": the blob ", static_cast<int>(key.kind), " (",
                              key.x, ", ", key.z,
                              ") was written before the disk failed, and is gone: put it again, or erase it; until "
                              "then nothing is saved")};
    }
    log->trust();
    return {};
}

/// Indexes chain back to one of everything. A new one swallows those before it that are not at least twice as large, so
/// that sizes at least double along the chain: it has a length, and a key is written again, a logarithm of times.
std::size_t LogStore::Impl::runs_to_keep(std::size_t changes) const {
    if (needs_full_index) return 0;
    std::size_t kept = runs.size();
    while (kept > 0 && runs[kept - 1].keys.size() <= 2 * changes) changes += runs[--kept].keys.size();
    return kept;
}

Index LogStore::Impl::next_index(std::uint64_t mark, std::size_t kept_runs, std::vector<BlobKey>& keys) const {
    Index index{.generation = generation, .mark = mark};
    if (kept_runs != 0) index.previous = runs[kept_runs - 1].offset, index.previous_end = runs[kept_runs - 1].end;
    const auto add = [&](const BlobKey& key, Entry entry) {
        if (state.pending.contains(key)) entry.mark = mark;
        index.added.push_back({key, entry});
    };
    if (kept_runs == 0) {
        for (const auto& [key, entry] : state.blobs) add(key, entry), keys.push_back(key);
        return index;
    }
    for (const auto& [key, before] : state.pending) keys.push_back(key);
    for (std::size_t run = kept_runs; run < runs.size(); ++run)
        keys.insert(keys.end(), runs[run].keys.begin(), runs[run].keys.end());
    std::ranges::sort(keys);
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    for (const BlobKey& key : keys)
        if (const std::optional<Entry> entry = state.seen(key))
            add(key, *entry);
        else
            index.erased.push_back(key);
    return index;
}

Result<void> LogStore::commit(std::uint64_t mark) {
    Impl& my = *impl_;
    const bool changes = !my.state.pending.empty() || my.needs_full_index || my.needs_header;
    if (!changes && my.commit.generation != 0 && my.commit.mark == mark) return {};
    if (Result<void> done = my.write_again(); !done) return done;
    if (my.needs_header)
        if (Result<void> done = my.log->write_header(); !done) return done;

    ++my.generation;
    const std::size_t kept = my.runs_to_keep(my.state.pending.size());
    LogRun run;
    const Index index = my.next_index(mark, kept, run.keys);
    const Result<std::uint64_t> offset =
        my.log->append({.type = FrameType::Index, .key = key_of_mark(mark)}, encode_index(index));
    if (!offset) return offset.error();
    run.offset = *offset, run.end = my.log->end();
    if (Result<void> done = my.log->sync(); !done) {
        my.log->drop_from(run.offset);
        return done;
    }
    // From here on the index stays, whatever happens: a superblock that points to it may be on the disk.
    const Superblock next{my.generation, mark, run.offset, run.end, my.state.blobs.size()};
    if (Result<void> done = my.log->write_superblock(next, my.next_slot); !done) return done;

    my.commit = next;
    my.next_slot ^= 1;
    my.runs.resize(kept);
    my.runs.push_back(std::move(run));
    my.needs_full_index = my.needs_header = false;
    if (my.compaction != nullptr) my.compaction->committed(my.state);
    my.state.settle(mark);
    return {};
}

std::uint64_t LogStore::mark() const { return impl_->commit.mark; }

std::optional<std::uint64_t> LogStore::mark_of(BlobKey key) const {
    const std::optional<Entry> entry = impl_->state.seen(key);
    if (!entry || impl_->state.pending.contains(key) || entry->mark == kUnknownMark) return {};
    return entry->mark;
}

BlobStore::Size LogStore::size() const {
    const std::uint64_t next = impl_->compaction == nullptr ? 0 : impl_->compaction->log().end();
    return {.live_bytes = impl_->state.live_bytes, .disk_bytes = impl_->log->end() + next, .temporary_bytes = next};
}

bool LogStore::Impl::is_wasteful(bool forced) const {
    const std::uint64_t least = state.least_file_bytes(), all = log->end();
    if (commit.generation == 0 || all <= least) return false;
    const double share = static_cast<double>(all - least) / static_cast<double>(all);
    if (share > settings.most_waste && all - least > settings.least_waste_bytes) return true;
    return forced && share > kLeastForcedWaste;
}

Result<bool> LogStore::compact(std::uint64_t most_bytes, bool forced) {
    Impl& my = *impl_;
    my.remove_leftovers();
    if (my.compaction == nullptr) {
        if (!my.is_wasteful(forced)) return false;
        const FileTag& tag = my.log->tag();
        auto begun = LogCompaction::begin(my.files, my.folder, {tag.salt, tag.number + 1}, my.state);
        if (!begun) return begun.error();
        my.compaction = *std::move(begun);
        std::erase(my.leftovers,
                   my.compaction->log().path());  // one of that name was given up, and could not be removed
    }
    Result<void> done = my.compaction->step(*my.log, my.state, most_bytes);
    if (done && !my.compaction->is_caught_up()) return true;
    // It copies what is not committed, too: not as long as that may be gone. What was copied is good and stays.
    if (done)
        if (Result<void> again = my.write_again(); !again) return again.error();
    if (done) done = my.finish_compaction();
    if (!done) {
        my.discard_compaction();
        return done.error();
    }
    return my.is_wasteful(forced);
}

/// A new generation, so that the new file is the one to be opened as long as both are there; should it not be finished
/// after all, the next commit of the old file has a higher one.
Result<void> LogStore::Impl::finish_compaction() {
    Result<LogCompaction::Finished> finished = compaction->finish(*log, state, ++generation, commit.mark);
    if (!finished) return finished.error();
    leftovers.push_back(log->path());
    log = std::move(finished->log);
    state = std::move(finished->state);
    commit = finished->commit;
    next_slot = 1 - LogCompaction::kSlot;
    runs.clear();
    runs.push_back(std::move(finished->run));
    needs_full_index = needs_header = false;
    compaction.reset();
    remove_leftovers();
    return {};
}

void LogStore::Impl::discard_compaction() {
    leftovers.push_back(folder + "/" + file_name(log->tag().number + 1));
    compaction.reset();
    remove_leftovers();
}

/// What cannot be removed costs space alone; opening removes it, too.
void LogStore::Impl::remove_leftovers() {
    if (leftovers.empty()) return;
    std::erase_if(leftovers, [&](const std::string& path) { return files.remove(path).ok(); });
    (void)files.sync_folder(folder);
}

}  // namespace tilth
