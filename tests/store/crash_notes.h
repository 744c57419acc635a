// What a process that will be killed leaves for the one that kills it: a page of memory that both have mapped.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <new>
#include <string>

namespace tilth::test {

struct CrashNotes {
    std::atomic<std::uint32_t> is_open = 0;
    std::atomic<std::uint64_t> durable = 0;  ///< edits that had been flushed, at least
    std::atomic<std::uint64_t> saves = 0, operations = 0;
    char error[512] = {};  ///< of a run that went wrong

    void fail(const std::string& what) { std::memcpy(error, what.data(), std::min(what.size(), sizeof error - 1)); }
};

/// The notes in the file `path`, made if need be. Stays mapped until the process ends.
inline CrashNotes& notes_in(const std::string& path, bool fresh) {
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (::ftruncate(file, 4096) != 0) _exit(4);
    void* const memory = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    if (memory == MAP_FAILED) _exit(4);
    return fresh ? *new (memory) CrashNotes : *static_cast<CrashNotes*>(memory);
}

}  // namespace tilth::test
