#include "tilth/io/file_bytes.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace tilth::io {

Result<std::vector<std::byte>> read_file(const std::string& path, std::uint64_t max_bytes) {
    const auto close = [](std::FILE* f) { std::fclose(f); };
    const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rb"), close);
    if (!file) return Error{ErrorCode::NotFound, text(path, ": cannot be opened: ", std::strerror(errno))};

    struct stat facts {};
    if (fstat(fileno(file.get()), &facts) != 0 || !S_ISREG(facts.st_mode))
        return Error{ErrorCode::FileFormat, text(path, ": is not a regular file")};
    const std::uint64_t size = static_cast<std::uint64_t>(facts.st_size);
    if (size > max_bytes)
        return Error{ErrorCode::FileFormat, text(path, ": has ", size, " bytes, at most ", max_bytes, " are allowed")};

    std::vector<std::byte> bytes(size);
    if (size != 0 && std::fread(bytes.data(), 1, size, file.get()) != size)
        return Error{ErrorCode::FileFormat, text(path, ": cannot be read to its end: ",
                                                 std::ferror(file.get()) ? std::strerror(errno) : "it became shorter")};
    return bytes;
}

Result<FileWriter> FileWriter::create(const std::string& path) {
    std::FILE* file = std::fopen((path + ".part").c_str(), "wb");
    if (!file) return Error{ErrorCode::FileWrite, text(path, ": cannot be written: ", std::strerror(errno))};
    return FileWriter(path, file);
}

FileWriter::FileWriter(FileWriter&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, nullptr)), problem_(other.problem_) {}

FileWriter::~FileWriter() {
    if (!file_) return;
    std::fclose(file_);
    std::remove(part().c_str());
}

void FileWriter::write(std::span<const std::byte> bytes) {
    if (problem_ == 0 && std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) problem_ = errno;
}

Result<void> FileWriter::commit() {
    if (problem_ == 0 && (std::fflush(file_) != 0 || fsync(fileno(file_)) != 0)) problem_ = errno;
    if (std::fclose(std::exchange(file_, nullptr)) != 0 && problem_ == 0) problem_ = errno;
    if (problem_ == 0 && std::rename(part().c_str(), path_.c_str()) != 0) problem_ = errno;
    if (problem_ == 0) return {};
    std::remove(part().c_str());
    return Error{ErrorCode::FileWrite, text(path_, ": cannot be written: ", std::strerror(problem_))};
}

Result<void> write_file(const std::string& path, std::span<const std::byte> bytes) {
    auto writer = FileWriter::create(path);
    if (!writer) return writer.error();
    writer->write(bytes);
    return writer->commit();
}

}  // namespace tilth::io
