#include "tilth/store/log_compaction.h"

#include <algorithm>

#include "tilth/core/hash.h"

namespace tilth {

using namespace log_format;

namespace {
constexpr std::uint64_t kSyncBytes = 16u << 20;
}

Result<std::unique_ptr<LogCompaction>> LogCompaction::begin(FileSystem& files, const std::string& folder,
                                                            const FileTag& tag, const LogState& state) {
    Result<std::unique_ptr<LogFile>> log = LogFile::create(files, folder, tag);
    if (!log) return log.error();
    std::unique_ptr<LogCompaction> compaction(new LogCompaction(files, folder, *std::move(log)));

    std::vector<std::pair<std::uint64_t, BlobKey>> by_offset;
    for (const auto& [key, entry] : state.blobs)
        if (!state.pending.contains(key)) by_offset.emplace_back(entry.offset, key);
    for (const auto& [key, before] : state.pending)
        if (before) by_offset.emplace_back(before->offset, key);
    // Taken from the back, so that the old file is read from its beginning to its end.
    std::ranges::sort(by_offset, std::greater<>());
    for (const auto& [offset, key] : by_offset) compaction->todo_.push_back(key);
    return compaction;
}

void LogCompaction::committed(const LogState& state) {
    for (const auto& [key, before] : state.pending) todo_.push_back(key);
}

Result<Entry> LogCompaction::copy(LogFile& old, const BlobKey& key, const Entry& entry) {
    const Result<LogFile::StoredBlob> blob = old.read_blob(key, entry);
    if (!blob) return blob.error();
    FrameHeader header{.type = FrameType::Blob, .key = key};
    header.payload_hash = hash_bytes(blob->payload) ^ (blob->is_sound ? 0 : ~std::uint64_t{0});
    const Result<std::uint64_t> offset = log_->append(header, blob->payload, true);
    if (!offset) return offset.error();
    return Entry{*offset, entry.mark, entry.length};
}

Result<void> LogCompaction::step(LogFile& old, const LogState& state, std::uint64_t most_bytes) {
    const std::uint64_t begin = log_->end();
    do {
        if (todo_.empty()) return {};
        const BlobKey key = todo_.back();
        const std::optional<Entry> entry = state.committed(key);
        const auto done = copied_.find(key);
        if (!entry) {
            if (done != copied_.end()) copied_.erase(done);
        } else if (done == copied_.end() || done->second.from != entry->offset) {
            const Result<Entry> moved = copy(old, key, *entry);
            if (!moved) return moved.error();
            copied_[key] = {entry->offset, *moved};
        }
        todo_.pop_back();
        if (log_->unsynced_bytes() >= kSyncBytes)
            if (Result<void> synced = log_->sync(); !synced) return synced;
    } while (log_->end() - begin < most_bytes);
    return {};
}

Result<void> LogCompaction::copy_pending(LogFile& old, const LogState& state, LogState& moved) {
    for (const auto& [key, before] : state.pending) {
        if (const std::optional<Entry> entry = state.seen(key)) {
            const Result<Entry> copied = copy(old, key, *entry);
            if (!copied) return copied.error();
            moved.set(key, *copied);
        } else {
            const Result<std::uint64_t> offset = log_->append({.type = FrameType::Erase, .key = key}, {});
            if (!offset) return offset.error();
            moved.set(key, std::nullopt);
        }
    }
    return {};
}

Result<LogCompaction::Finished> LogCompaction::finish(LogFile& old, const LogState& state, std::uint64_t generation,
                                                      std::uint64_t mark) {
    Finished finished;
    Index index{.generation = generation, .mark = mark};
    for (const auto& [key, copied] : copied_) {
        index.added.push_back({key, copied.entry});
        finished.run.keys.push_back(key);
        finished.state.blobs[key] = copied.entry;
        finished.state.live_bytes += copied.entry.length;
    }
    const Result<std::uint64_t> offset =
        log_->append({.type = FrameType::Index, .key = key_of_mark(mark)}, encode_index(index));
    if (!offset) return offset.error();
    finished.run.offset = *offset, finished.run.end = log_->end();
    finished.commit = {generation, mark, *offset, log_->end(), index.added.size()};

    if (Result<void> done = copy_pending(old, state, finished.state); !done) return done.error();
    if (Result<void> done = log_->sync(); !done) return done.error();
    if (Result<void> done = log_->write_superblock(finished.commit, kSlot); !done) return done.error();
    if (Result<void> done = files_.sync_folder(folder_); !done) return done.error();
    finished.log = std::move(log_);
    return finished;
}

}  // namespace tilth
