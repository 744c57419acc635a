#include "tilth/store/file_system.h"

#include <utility>

namespace tilth {

namespace {

std::string folder_of(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    if (slash == std::string::npos) return ".";
    return slash == 0 ? "/" : path.substr(0, slash);
}

Result<void> write_durably(FileSystem& files, const std::string& path, std::span<const std::byte> bytes) {
    Result<std::unique_ptr<File>> file = files.open(path, OpenMode::Create);
    if (!file) return file.error();
    if (Result<void> done = (*file)->truncate(0); !done) return done;
    if (Result<void> done = (*file)->write(0, bytes); !done) return done;
    return (*file)->sync();
}

}  // namespace

Result<void> replace_file(FileSystem& files, const std::string& path, std::span<const std::byte> bytes) {
    const std::string beside = path + kReplacementEnding;
    Result<void> done = write_durably(files, beside, bytes);
    if (done) done = files.rename(beside, path);
    if (!done) {
        (void)files.remove(beside);  // what remains costs space alone: the next replacement writes over it
        return done;
    }
    return files.sync_folder(folder_of(path));
}

Result<std::vector<std::byte>> read_file(FileSystem& files, const std::string& path, std::uint64_t most_bytes) {
    Result<std::unique_ptr<File>> file = files.open(path, OpenMode::Read);
    if (!file) return file.error();
    const Result<std::uint64_t> size = (*file)->size();
    if (!size) return size.error();
    if (*size > most_bytes)
        return Error{ErrorCode::FileFormat, text(path, ": has ", *size, " bytes, at most ", most_bytes,
                                                 " are allowed: it is damaged, or no file of ours")};
    std::vector<std::byte> bytes(*size);
    const Result<std::size_t> count = (*file)->read(0, bytes);
    if (!count) return count.error();
    if (*count != bytes.size())
        return Error{ErrorCode::FileRead, text(path, ": became shorter while it was read: try again")};
    return bytes;
}

}  // namespace tilth
