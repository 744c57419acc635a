// Files as the store needs them: positioned reads and writes that say what went wrong, locks, atomic replacement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tilth/core/result.h"

namespace tilth {

/// An open file. Threads: one at a time. Errors name the path and the system's reason, and what to do about it.
class File {
public:
    explicit File(std::string path) : path_(std::move(path)) {}
    virtual ~File() = default;
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    /// Fills `out` from `offset` on; returns how many bytes there were, fewer only at the end of the file.
    virtual Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> out) = 0;
    /// All of `bytes`, or an error: what the file then holds from `offset` on is not known. Grows the file.
    virtual Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
    /// Returns when everything written so far would survive a power cut.
    virtual Result<void> sync() = 0;
    virtual Result<void> truncate(std::uint64_t size) = 0;
    virtual Result<std::uint64_t> size() = 0;

    [[nodiscard]] const std::string& path() const { return path_; }

private:
    std::string path_;
};

/// Held until it is destroyed, or until the process ends in whatever way.
class FileLock {
public:
    FileLock() = default;
    virtual ~FileLock() = default;
    FileLock(const FileLock&) = delete;
    FileLock& operator=(const FileLock&) = delete;
};

enum class OpenMode : std::uint8_t {
    Read,    ///< must exist
    Write,   ///< must exist; read and written
    Create,  ///< made if it is not there; read and written
};

/// The disk: the real one, or one that a test makes fail. Paths are UTF-8, relative ones to the working directory.
/// Threads: all members may be called from several.
class FileSystem {
public:
    FileSystem() = default;
    virtual ~FileSystem() = default;
    FileSystem(const FileSystem&) = delete;
    FileSystem& operator=(const FileSystem&) = delete;

    /// NotFound where it must exist and does not; FileWrite where it may not be written; FileRead otherwise.
    virtual Result<std::unique_ptr<File>> open(const std::string& path, OpenMode mode) = 0;
    [[nodiscard]] virtual bool exists(const std::string& path) = 0;
    /// Makes one folder; one that exists is no error. Its parent must exist.
    virtual Result<void> make_folder(const std::string& path) = 0;
    /// Names (not paths) of the files in a folder, sorted.
    virtual Result<std::vector<std::string>> list(const std::string& folder) = 0;
    /// Replaces `to` if it exists, as one step. Durable after `sync_folder` of its folder.
    virtual Result<void> rename(const std::string& from, const std::string& to) = 0;
    /// A file that is not there is no error.
    virtual Result<void> remove(const std::string& path) = 0;
    /// Names that were made, renamed or removed in it are durable when this returns.
    virtual Result<void> sync_folder(const std::string& folder) = 0;
    /// An exclusive lock, also against this same process. Makes the file. Fails with Locked while another holds it.
    virtual Result<std::unique_ptr<FileLock>> lock(const std::string& path) = 0;
};

/// The system's own (POSIX).
FileSystem& system_files();

/// What the name of a replacement ends in while it is written; such a file that is found is the rest of a crash.
inline constexpr const char* kReplacementEnding = ".new";

/// Replaces a file's content as one step that is durable on return: written beside it, synced, renamed, folder synced.
/// On an error the old content is there, or (where the folder could not be synced) the new one.
Result<void> replace_file(FileSystem& files, const std::string& path, std::span<const std::byte> bytes);

/// A whole file of at most `most_bytes`; a longer one is an error (FileFormat), and not read.
Result<std::vector<std::byte>> read_file(FileSystem& files, const std::string& path, std::uint64_t most_bytes);

}  // namespace tilth
