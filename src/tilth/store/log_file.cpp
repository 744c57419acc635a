#include "tilth/store/log_file.h"

#include <algorithm>
#include <cstring>

#include "tilth/core/hash.h"

namespace tilth {

using namespace log_format;

namespace {
constexpr std::size_t kBufferBytes = 1u << 20;  // a write of 1 MiB costs the disk no more a byte than a larger one
}

Result<std::unique_ptr<LogFile>> LogFile::create(FileSystem& files, const std::string& folder, const FileTag& tag) {
    const std::vector<std::byte> bytes = encode_empty_file(tag);
    if (Result<void> done = replace_file(files, folder + "/" + file_name(tag.number), bytes); !done)
        return done.error();
    return open(files, folder, tag);
}

Result<std::unique_ptr<LogFile>> LogFile::open(FileSystem& files, const std::string& folder, const FileTag& tag) {
    Result<std::unique_ptr<File>> file = files.open(folder + "/" + file_name(tag.number), OpenMode::Write);
    if (!file) return file.error();
    const Result<std::uint64_t> size = (*file)->size();
    if (!size) return size.error();
    return std::unique_ptr<LogFile>(new LogFile(*std::move(file), tag, *size));
}

Result<std::uint64_t> LogFile::append(FrameHeader header, std::span<const std::byte> payload, bool keep_hash) {
    header.length = static_cast<std::uint32_t>(payload.size());
    if (!keep_hash) header.payload_hash = hash_bytes(payload);
    if (!buffer_.empty() && buffer_.size() + header.bytes() > kBufferBytes)
        if (Result<void> done = flush(); !done) return done.error();

    const std::uint64_t offset = end();
    const std::size_t before = buffer_.size();
    const FrameHeaderBytes bytes = encode_frame_header(header, tag_, offset);
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    buffer_.insert(buffer_.end(), payload.begin(), payload.end());
    if (buffer_.size() > kBufferBytes)
        if (Result<void> done = flush(); !done) {
            buffer_.resize(before);
            return done.error();
        }
    return offset;
}

void LogFile::drop_from(std::uint64_t offset) {
    buffer_.resize(offset > flushed_ ? std::min<std::uint64_t>(buffer_.size(), offset - flushed_) : 0);
    flushed_ = std::min(flushed_, offset);
    synced_ = std::min(synced_, offset);
}

Result<void> LogFile::cut(std::uint64_t end) {
    if (Result<void> done = file_->truncate(end); !done) return done;
    drop_from(end);
    return sync();
}

Result<void> LogFile::flush() {
    if (buffer_.empty()) return {};
    if (Result<void> done = file_->write(flushed_, buffer_); !done) return done;
    flushed_ += buffer_.size();
    buffer_.clear();
    if (buffer_.capacity() > 2 * kBufferBytes) buffer_.shrink_to_fit();
    return {};
}

Result<void> LogFile::sync() {
    if (Result<void> done = flush(); !done) return done;
    if (Result<void> done = file_->sync(); !done) {
        is_doubtful_ = true;
        return done;
    }
    if (!is_doubtful_) synced_ = flushed_;
    return {};
}

Result<void> LogFile::write_again() {
    std::vector<std::byte> chunk(std::min<std::uint64_t>(kBufferBytes, flushed_ - synced_));
    for (std::uint64_t at = synced_; at < flushed_;) {
        const std::span<std::byte> part = std::span(chunk).first(std::min<std::uint64_t>(chunk.size(), flushed_ - at));
        const Result<std::size_t> count = file_->read(at, part);
        if (!count) return count.error();
        if (Result<void> done = file_->write(at, part.first(*count)); !done) return done;
        at += part.size();
    }
    return {};
}

Result<void> LogFile::write_superblock(const Superblock& superblock, unsigned slot) {
    if (Result<void> done = file_->write(superblock_offset(slot), encode_superblock(superblock, tag_, slot)); !done)
        return done;
    return sync();
}

Result<void> LogFile::write_header() { return file_->write(0, encode_header(tag_)); }

Result<std::size_t> LogFile::read(std::uint64_t offset, std::span<std::byte> out) {
    if (offset >= end()) return std::size_t{0};
    if (offset < flushed_)
        return file_->read(offset, out.first(std::min<std::uint64_t>(out.size(), flushed_ - offset)));
    const std::size_t first = offset - flushed_, count = std::min(out.size(), buffer_.size() - first);
    if (count != 0) std::memcpy(out.data(), buffer_.data() + first, count);
    return count;
}

Result<std::optional<FrameHeader>> LogFile::read_frame_header(std::uint64_t offset) {
    FrameHeaderBytes bytes;
    const Result<std::size_t> count = read(offset, bytes);
    if (!count) return count.error();
    return decode_frame_header(std::span(bytes).first(*count), tag_, offset);
}

Result<LogFile::StoredBlob> LogFile::read_blob(const BlobKey& key, const Entry& entry) {
    const Result<std::optional<FrameHeader>> header = read_frame_header(entry.offset);
    if (!header) return header.error();
    StoredBlob blob{.payload = std::vector<std::byte>(entry.length)};
    const Result<std::size_t> count = read(entry.offset + kFrameHeaderBytes, blob.payload);
    if (!count) return count.error();
    blob.is_sound = *header && *count == entry.length && (*header)->type == FrameType::Blob && (*header)->key == key &&
                    (*header)->length == entry.length && (*header)->payload_hash == hash_bytes(blob.payload);
    return blob;
}

}  // namespace tilth
