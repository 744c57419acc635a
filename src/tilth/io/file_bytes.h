// Whole files in and out, with every error of the file system reported.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "tilth/core/result.h"

namespace tilth::io {

/// All bytes of the file. Fails with `NotFound` (missing or not openable) or `FileFormat` (not a regular file, larger
/// than `max_bytes`, cannot be read); nothing is allocated before the size is known and allowed. May block on the disk.
Result<std::vector<std::byte>> read_file(const std::string& path, std::uint64_t max_bytes);

/// Writes a file under the name `path` + ".part" and gives it its name when it is complete, so that a reader sees the
/// old file or the whole new one. What was not committed is removed.
/// One thread at a time; two writers of the same path disturb each other.
class FileWriter {
public:
    /// Fails with `FileWrite` if the file cannot be created; the message says why.
    static Result<FileWriter> create(const std::string& path);
    ~FileWriter();
    FileWriter(FileWriter&& other) noexcept;
    FileWriter& operator=(FileWriter&&) = delete;

    /// Appends. An error is remembered and reported by `commit`.
    void write(std::span<const std::byte> bytes);

    /// Flushes to the disk and renames. Fails with `FileWrite` if any write, the flush or the renaming failed.
    Result<void> commit();

private:
    FileWriter(std::string path, std::FILE* file) : path_(std::move(path)), file_(file) {}
    [[nodiscard]] std::string part() const { return path_ + ".part"; }

    std::string path_;
    std::FILE* file_;
    int problem_ = 0;  // errno of the first write that failed
};

/// Writes `bytes` as the whole file, through `FileWriter`.
Result<void> write_file(const std::string& path, std::span<const std::byte> bytes);

}  // namespace tilth::io
