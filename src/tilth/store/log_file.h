// One `pages-<n>.tlp`, open: frames are appended through a bounded buffer, read back and checked.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tilth/store/file_system.h"
#include "tilth/store/log_format.h"

namespace tilth {

/// What the bytes mean is for `LogStore` and `recover_log` to know; here lie the places and the order of writes.
/// Threads: one at a time.
class LogFile {
public:
    /// Makes it, empty; it exists wholly or not at all. Replaces one of that number.
    static Result<std::unique_ptr<LogFile>> create(FileSystem& files, const std::string& folder,
                                                   const log_format::FileTag& tag);
    /// Its end is the file's; nothing is checked.
    static Result<std::unique_ptr<LogFile>> open(FileSystem& files, const std::string& folder,
                                                 const log_format::FileTag& tag);

    [[nodiscard]] const std::string& path() const { return file_->path(); }
    [[nodiscard]] const log_format::FileTag& tag() const { return tag_; }
    /// Where the next frame goes; of what is not flushed yet, too.
    [[nodiscard]] std::uint64_t end() const { return flushed_ + buffer_.size(); }

    /// Returns the frame's offset. Of `header` the type and the key count and, with `keep_hash`, the hash. On an
    /// error nothing was appended. Memory: up to 1 MiB of frames, or one frame, waits for `flush`.
    Result<std::uint64_t> append(log_format::FrameHeader header, std::span<const std::byte> payload,
                                 bool keep_hash = false);
    /// Forgets what was appended from there on, which no superblock may know of.
    void drop_from(std::uint64_t offset);
    /// Cuts the file off there, durably.
    Result<void> cut(std::uint64_t end);

    Result<void> flush();
    /// Flushes, and returns when a power cut would leave all of it. After a failed one it is not known what the disk
    /// has, and the next one alone would not write it again: `is_doubtful`, until what can still be read was written
    /// again and found to be what was appended (`trust`).
    Result<void> sync();
    [[nodiscard]] bool is_doubtful() const { return is_doubtful_; }
    Result<void> write_again();
    void trust() { is_doubtful_ = false; }
    /// About how much the next sync has to write.
    [[nodiscard]] std::uint64_t unsynced_bytes() const { return end() - synced_; }

    /// Durable on return; on an error the slot may hold it or nothing.
    Result<void> write_superblock(const log_format::Superblock& superblock, unsigned slot);
    Result<void> write_header();

    /// Fewer bytes than asked for only at the end.
    Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> out);
    Result<std::optional<log_format::FrameHeader>> read_frame_header(std::uint64_t offset);

    struct StoredBlob {
        std::vector<std::byte> payload;
        bool is_sound = false;  ///< else damaged; what could be read stands in `payload`
    };
    /// Of a frame within the file. Fails where the disk does (FileRead).
    Result<StoredBlob> read_blob(const BlobKey& key, const log_format::Entry& entry);

private:
    LogFile(std::unique_ptr<File> file, const log_format::FileTag& tag, std::uint64_t end)
        : file_(std::move(file)), tag_(tag), flushed_(end), synced_(end) {}
    std::unique_ptr<File> file_;
    log_format::FileTag tag_;
    std::uint64_t flushed_;  ///< what lies before is in the file, what lies behind in `buffer_`; whole frames both
    std::uint64_t synced_;
    std::vector<std::byte> buffer_;
    bool is_doubtful_ = false;
};

}  // namespace tilth
