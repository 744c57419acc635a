// The system's files, by POSIX calls.
#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "tilth/store/file_system.h"

namespace tilth {

namespace {

const char* advice(int reason) {
    switch (reason) {
        case ENOSPC:
        case EDQUOT:
            return "the disk is full: free some space";
        case EFBIG:
            return "the file system holds no larger files: move the world to another disk";
        case EACCES:
        case EPERM:
            return "it is not ours to use: change its permissions, or choose another folder";
        case EROFS:
            return "the disk is read-only: mount it for writing, or choose another folder";
        case ENOENT:
            return "it does not exist, or its folder does not: check the path, make the folder first";
        case ENOTDIR:
            return "a part of its path is a file, not a folder: choose another path";
        case EISDIR:
            return "it is a folder, not a file: choose another path";
        case ENAMETOOLONG:
            return "its name is too long: choose a shorter path";
        case EMFILE:
        case ENFILE:
            return "too many files are open: close some, or raise the limit";
        case EIO:
            return "the disk is failing: copy the world to another one";
        default:
            return "check the disk and the path";
    }
}

Error trouble(ErrorCode code, const std::string& path, const char* what, int reason) {
    return {code, text(path, ": ", what, ": ", std::strerror(reason), "; ", advice(reason))};
}

class Descriptor {
public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&&) = delete;
    [[nodiscard]] int get() const { return fd_; }

private:
    int fd_;
};

/// Repeats a call that a signal interrupted.
template <class Call>
auto retried(const Call& call) {
    auto result = call();
    while (result < 0 && errno == EINTR) result = call();
    return result;
}

Descriptor open_descriptor(const std::string& path, int flags) {
    return Descriptor(retried([&] { return ::open(path.c_str(), flags | O_CLOEXEC, 0666); }));
}

/// `everything`: also what `read` does not need, such as the file's entry after it was made.
int sync_descriptor(int fd, bool everything) {
#ifdef __APPLE__  // fsync leaves the bytes in the drive's cache there
    (void)everything;
    return retried([&] { return ::fcntl(fd, F_FULLFSYNC); });
#else
    return retried([&] { return everything ? ::fsync(fd) : ::fdatasync(fd); });
#endif
}

class PosixFile final : public File {
public:
    PosixFile(std::string path, Descriptor fd) : File(std::move(path)), fd_(std::move(fd)) {}

    Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> out) override {
        std::size_t done = 0;
        while (done < out.size()) {
            const ssize_t count = retried([&] {
                return ::pread(fd_.get(), out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
            });
            if (count < 0) return trouble(ErrorCode::FileRead, path(), "cannot be read", errno);
            if (count == 0) break;
            done += static_cast<std::size_t>(count);
        }
        return done;
    }
    Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size()) {
            const ssize_t count = retried([&] {
                return ::pwrite(fd_.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
            });
            if (count < 0) return trouble(ErrorCode::FileWrite, path(), "cannot be written", errno);
            if (count == 0) return trouble(ErrorCode::FileWrite, path(), "cannot be written", ENOSPC);
            done += static_cast<std::size_t>(count);
        }
        return {};
    }
    Result<void> sync() override {
        if (sync_descriptor(fd_.get(), sync_everything_) != 0)
            return trouble(ErrorCode::FileWrite, path(), "cannot be made durable", errno);
        sync_everything_ = false;
        return {};
    }
    Result<void> truncate(std::uint64_t size) override {
        if (retried([&] { return ::ftruncate(fd_.get(), static_cast<off_t>(size)); }) != 0)
            return trouble(ErrorCode::FileWrite, path(), "cannot be shortened", errno);
        sync_everything_ = true;
        return {};
    }
    Result<std::uint64_t> size() override {
        struct stat facts {};
        if (::fstat(fd_.get(), &facts) != 0)
            return trouble(ErrorCode::FileRead, path(), "its size cannot be asked", errno);
        return static_cast<std::uint64_t>(facts.st_size);
    }

private:
    Descriptor fd_;
    bool sync_everything_ = true;  ///< it may be new
};

class PosixLock final : public FileLock {
public:
    explicit PosixLock(Descriptor fd) : fd_(std::move(fd)) {}

private:
    Descriptor fd_;  // flock ends with the last descriptor of this opening
};

class PosixFiles final : public FileSystem {
public:
    Result<std::unique_ptr<File>> open(const std::string& path, OpenMode mode) override {
        const int flags = mode == OpenMode::Read ? O_RDONLY : mode == OpenMode::Write ? O_RDWR : O_RDWR | O_CREAT;
        Descriptor fd = open_descriptor(path, flags);
        if (fd.get() < 0) {
            const int reason = errno;
            if (reason == ENOENT) return trouble(ErrorCode::NotFound, path, "cannot be opened", reason);
            return trouble(mode == OpenMode::Read ? ErrorCode::FileRead : ErrorCode::FileWrite, path,
                           mode == OpenMode::Read ? "cannot be opened for reading" : "cannot be opened for writing",
                           reason);
        }
        struct stat facts {};
        if (::fstat(fd.get(), &facts) == 0 && S_ISDIR(facts.st_mode))
            return trouble(ErrorCode::FileRead, path, "cannot be opened", EISDIR);
        return std::unique_ptr<File>(std::make_unique<PosixFile>(path, std::move(fd)));
    }

    bool exists(const std::string& path) override {
        struct stat facts {};
        return ::stat(path.c_str(), &facts) == 0;
    }

    Result<void> make_folder(const std::string& path) override {
        if (::mkdir(path.c_str(), 0777) == 0) return {};
        const int reason = errno;
        struct stat facts {};
        if (reason == EEXIST && ::stat(path.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode)) return {};
        return trouble(ErrorCode::FileWrite, path, "the folder cannot be made", reason == EEXIST ? ENOTDIR : reason);
    }

    Result<std::vector<std::string>> list(const std::string& folder) override {
        const auto close = [](DIR* entries) { ::closedir(entries); };
        const std::unique_ptr<DIR, decltype(close)> entries(::opendir(folder.c_str()), close);
        if (entries == nullptr) {
            const int reason = errno;
            return trouble(reason == ENOENT ? ErrorCode::NotFound : ErrorCode::FileRead, folder,
                           "the folder cannot be read", reason);
        }
        std::vector<std::string> names;
        errno = 0;
        while (const dirent* entry = ::readdir(entries.get())) {
            struct stat facts {};
            const bool is_folder =
                entry->d_type == DT_DIR ||
                (entry->d_type == DT_UNKNOWN && ::fstatat(::dirfd(entries.get()), entry->d_name, &facts, 0) == 0 &&
                 S_ISDIR(facts.st_mode));
            if (!is_folder) names.emplace_back(entry->d_name);
            errno = 0;
        }
        if (errno != 0) return trouble(ErrorCode::FileRead, folder, "the folder cannot be read", errno);
        std::sort(names.begin(), names.end());
        return names;
    }

    Result<void> rename(const std::string& from, const std::string& to) override {
        if (::rename(from.c_str(), to.c_str()) == 0) return {};
        return trouble(ErrorCode::FileWrite, to, text("cannot be put in place of ", from).c_str(), errno);
    }

    Result<void> remove(const std::string& path) override {
        if (::unlink(path.c_str()) == 0 || errno == ENOENT) return {};
        return trouble(ErrorCode::FileWrite, path, "cannot be removed", errno);
    }

    Result<void> sync_folder(const std::string& folder) override {
        const Descriptor fd = open_descriptor(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
        // EINVAL: a file system that has no such thing, so that names are as durable as they get.
        if (fd.get() >= 0 && (sync_descriptor(fd.get(), true) == 0 || errno == EINVAL)) return {};
        const int reason = errno;
        return trouble(reason == ENOENT ? ErrorCode::NotFound : ErrorCode::FileWrite, folder,
                       "the folder cannot be made durable", reason);
    }

    Result<std::unique_ptr<FileLock>> lock(const std::string& path) override {
        Descriptor fd = open_descriptor(path, O_RDWR | O_CREAT);
        if (fd.get() < 0) {
            const int reason = errno;
            return trouble(reason == ENOENT ? ErrorCode::NotFound : ErrorCode::FileWrite, path,
                           "the lock cannot be made", reason);
        }
        // flock, not fcntl: it belongs to this opening of the file, so that it also holds against this process.
        if (retried([&] { return ::flock(fd.get(), LOCK_EX | LOCK_NB); }) == 0)
            return std::unique_ptr<FileLock>(std::make_unique<PosixLock>(std::move(fd)));
        const int reason = errno;
        if (reason == EWOULDBLOCK)
            return Error{ErrorCode::Locked, text(path,
                                                 ": is locked: another process, or another part of this one, has "
                                                 "the world open; close it there first")};
        return trouble(ErrorCode::FileWrite, path, "cannot be locked", reason);
    }
};

}  // namespace

FileSystem& system_files() {
    static PosixFiles files;
    return files;
}

}  // namespace tilth
