// The system's files: bytes, errors that say what and where, locks, replacement; and that the test's disk behaves
// alike.
#include "tilth/store/file_system.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <set>

#include "io/scratch_folder.h"
#include "support/fault_files.h"

namespace tilth::test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(const std::string& content) {
    Bytes bytes(content.size());
    std::transform(content.begin(), content.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

template <class T>
void expect_error(const Result<T>& result, ErrorCode code, const std::string& path) {
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, code) << result.error().message;
    EXPECT_NE(result.error().message.find(path), std::string::npos) << result.error().message;
}

/// What both disks must do.
void expect_contract(FileSystem& files, const std::string& folder) {
    const std::string path = folder + "/a";
    expect_error(files.open(path, OpenMode::Read), ErrorCode::NotFound, path);
    expect_error(files.open(path, OpenMode::Write), ErrorCode::NotFound, path);
    expect_error(files.open(folder + "/none/a", OpenMode::Create), ErrorCode::NotFound, folder + "/none/a");
    expect_error(files.list(folder + "/none"), ErrorCode::NotFound, folder + "/none");
    EXPECT_FALSE(files.exists(path));
    EXPECT_TRUE(files.remove(path).ok()) << "a file that is not there is no error";

    {
        auto file = files.open(path, OpenMode::Create);
        ASSERT_TRUE(file.ok()) << file.error().message;
        EXPECT_EQ((*file)->path(), path);
        ASSERT_TRUE((*file)->write(3, bytes_of("defg")).ok());
        ASSERT_TRUE((*file)->write(0, bytes_of("ab")).ok());
        EXPECT_EQ(*(*file)->size(), 7u);
        Bytes out(10, std::byte{9});
        EXPECT_EQ(*(*file)->read(0, out), 7u);
        EXPECT_EQ(Bytes(out.begin(), out.begin() + 7), bytes_of(std::string("ab\0defg", 7)));
        EXPECT_EQ(out[7], std::byte{9}) << "nothing behind what was read";
        EXPECT_EQ(*(*file)->read(5, std::span(out).first(2)), 2u);
        EXPECT_EQ(out[1], std::byte{'g'});
        EXPECT_EQ(*(*file)->read(7, out), 0u);
        EXPECT_EQ(*(*file)->read(1'000'000, out), 0u);
        ASSERT_TRUE((*file)->truncate(4).ok());
        ASSERT_TRUE((*file)->truncate(6).ok());
        ASSERT_TRUE((*file)->sync().ok());
    }
    EXPECT_TRUE(files.exists(path));
    EXPECT_EQ(*read_file(files, path, 6), bytes_of(std::string("ab\0d\0\0", 6)));
    expect_error(read_file(files, path, 5), ErrorCode::FileFormat, path);
    EXPECT_TRUE(files.open(path, OpenMode::Create).ok());
    EXPECT_EQ(*(*files.open(path, OpenMode::Read))->size(), 6u) << "Create keeps what is there";

    ASSERT_TRUE(replace_file(files, path, bytes_of("new")).ok());
    EXPECT_EQ(*read_file(files, path, 100), bytes_of("new"));
    ASSERT_TRUE(files.make_folder(folder + "/inner").ok());
    ASSERT_TRUE(files.make_folder(folder + "/inner").ok()) << "one that exists is no error";
    EXPECT_FALSE(files.make_folder(folder + "/no/inner").ok());
    ASSERT_TRUE(replace_file(files, folder + "/B", bytes_of("")).ok());
    EXPECT_EQ(*files.list(folder), (std::vector<std::string>{"B", "a"})) << "files alone, sorted";
    EXPECT_TRUE(read_file(files, folder + "/B", 0)->empty());

    ASSERT_TRUE(files.rename(folder + "/a", folder + "/B").ok());
    EXPECT_EQ(*files.list(folder), std::vector<std::string>{"B"});
    EXPECT_EQ(*read_file(files, folder + "/B", 100), bytes_of("new"));
    EXPECT_FALSE(files.rename(folder + "/a", folder + "/B").ok());
    ASSERT_TRUE(files.sync_folder(folder).ok());
    ASSERT_TRUE(files.remove(folder + "/B").ok());
    EXPECT_TRUE((*files.list(folder)).empty());

    const std::string lock = folder + "/lock";
    auto first = files.lock(lock);
    ASSERT_TRUE(first.ok()) << first.error().message;
    expect_error(files.lock(lock), ErrorCode::Locked, lock);
    expect_error(files.lock(folder + "/none/lock"), ErrorCode::NotFound, folder + "/none/lock");
    EXPECT_TRUE(files.lock(folder + "/other").ok()) << "another file's lock is its own";
    first = Error{};
    EXPECT_TRUE(files.lock(lock).ok()) << "released";
}

TEST(SystemFiles, KeepTheContract) {
    const ScratchFolder scratch;
    expect_contract(system_files(), scratch.path("."));
}

TEST(SystemFiles, KeepItInFoldersWithSpacesAndOtherLetters) {
    const ScratchFolder scratch;
    const std::string folder =
        scratch.path("Größe der Welt \xe4\xb8\x96\xe7\x95\x8c 'quoted' \"twice\" \xf0\x9f\x8c\x8d");
    ASSERT_TRUE(system_files().make_folder(folder).ok());
    expect_contract(system_files(), folder);
}

TEST(SystemFiles, LargeWritesAreWhole) {
    const ScratchFolder scratch;
    Bytes large(9'000'001);
    for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<std::byte>(i * 2654435761u >> 13);
    const std::string path = scratch.path("large");
    ASSERT_TRUE(replace_file(system_files(), path, large).ok());
    EXPECT_TRUE(*read_file(system_files(), path, large.size()) == large);
}

// Permissions do not stop the superuser, so the paths themselves are made impossible.
TEST(SystemFiles, ErrorsSayWhatAndWhatToDo) {
    const ScratchFolder scratch;
    FileSystem& files = system_files();
    const std::string file = scratch.put("file", std::string("x"));
    expect_error(files.open(file + "/below", OpenMode::Create), ErrorCode::FileWrite, file + "/below");
    expect_error(files.open(file + "/below", OpenMode::Read), ErrorCode::FileRead, file + "/below");
    expect_error(files.make_folder(file), ErrorCode::FileWrite, file);
    expect_error(files.make_folder(file + "/below"), ErrorCode::FileWrite, file + "/below");
    expect_error(files.lock(file + "/below"), ErrorCode::FileWrite, file + "/below");
    expect_error(files.list(file), ErrorCode::FileRead, file);
    expect_error(replace_file(files, file + "/below", {}), ErrorCode::FileWrite, file + "/below");
    EXPECT_FALSE(files.open(scratch.path("."), OpenMode::Read).ok()) << "a folder is no file";
    EXPECT_FALSE(files.remove(scratch.path(".")).ok());
    EXPECT_FALSE(files.open("/proc/tilth", OpenMode::Create).ok()) << "a folder that is not ours to write";
    EXPECT_EQ(*read_file(files, file, 1), bytes_of("x"));

    if (!files.exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
    auto full = files.open("/dev/full", OpenMode::Write);
    ASSERT_TRUE(full.ok());
    const Result<void> done = (*full)->write(0, bytes_of("abc"));
    expect_error(done, ErrorCode::FileWrite, "/dev/full");
    EXPECT_NE(done.error().message.find("free some space"), std::string::npos) << done.error().message;
}

TEST(SystemFiles, LockHoldsAgainstAnotherProcessAndEndsWithIt) {
    const ScratchFolder scratch;
    const std::string path = scratch.path("lock");
    int ready[2];
    ASSERT_EQ(pipe(ready), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const auto held = system_files().lock(path);
        const char outcome = held.ok() ? 'y' : 'n';
        if (write(ready[1], &outcome, 1) != 1) _exit(1);
        for (;;) pause();
    }
    char outcome = 0;
    ASSERT_EQ(read(ready[0], &outcome, 1), 1);
    EXPECT_EQ(outcome, 'y');
    expect_error(system_files().lock(path), ErrorCode::Locked, path);
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(system_files().lock(path).ok()) << "a killed process holds nothing";
    close(ready[0]);
    close(ready[1]);
}

TEST(FaultFiles, KeepTheContract) {
    FaultFiles files;
    ASSERT_TRUE(files.make_folder("world").ok());
    expect_contract(files, "world");
}

// A replacement is the old content or the new one, whatever fails and whenever the power goes.
TEST(FaultFiles, ReplacementIsWhollyOldOrNew) {
    const Bytes old_content(1500, std::byte{1}), new_content(2100, std::byte{2});
    for (const Fault fault : {Fault::NoSpace, Fault::Once, Fault::PowerOff}) {
        int seen_old = 0, seen_new = 0;
        for (std::uint64_t operation = 1; operation <= 7; ++operation)
            for (std::uint64_t seed = 0; seed < 40; ++seed) {
                FaultFiles files;
                ASSERT_TRUE(replace_file(files, "a", old_content).ok());
                files.fail_at(operation, fault, seed);
                const bool done = replace_file(files, "a", new_content).ok();
                EXPECT_EQ(done, !files.failed());
                EXPECT_EQ(operation > 6, done) << "made, cut, written, synced, renamed, folder synced";
                const auto after = files.crash(seed);
                const Result<Bytes> content = read_file(*after, "a", 10'000);
                ASSERT_TRUE(content.ok());
                EXPECT_TRUE(*content == new_content || (!done && *content == old_content)) << operation << ' ' << seed;
                (*content == old_content ? seen_old : seen_new) += 1;
                if (fault != Fault::PowerOff) {
                    files.make_room();
                    EXPECT_TRUE(replace_file(files, "a", new_content).ok());
                    EXPECT_EQ(*read_file(*files.crash(seed + 1), "a", 10'000), new_content);
                    EXPECT_EQ(files.paths(), std::vector<std::string>{"a"});
                }
            }
        EXPECT_GT(seen_old, 100);
        EXPECT_GT(seen_new, 40);
    }
}

// The disk of the tests must be as bad as they need it: what was not synced comes back in every way it may.
TEST(FaultFiles, PowerCutLeavesAnyPartOfWhatWasNotSynced) {
    FaultFiles files;
    auto file = files.open("a", OpenMode::Create);
    ASSERT_TRUE((*file)->write(0, Bytes(2048, std::byte{1})).ok());
    EXPECT_FALSE(files.crash(0)->exists("a") && files.crash(1)->exists("a") && files.crash(2)->exists("a") &&
                 files.crash(3)->exists("a") && files.crash(4)->exists("a") && files.crash(5)->exists("a"));
    ASSERT_TRUE((*file)->sync().ok());
    ASSERT_TRUE(files.sync_folder("").ok());
    ASSERT_TRUE((*file)->write(0, Bytes(2048, std::byte{2})).ok());
    ASSERT_TRUE((*file)->write(512, Bytes(2048, std::byte{3})).ok());
    std::set<std::string> seen;
    for (std::uint64_t seed = 0; seed < 4000; ++seed) {
        const Bytes content = files.crash(seed)->bytes("a");
        std::string sectors;
        for (std::size_t at = 0; at < content.size(); at += 512) {
            sectors += static_cast<char>('0' + static_cast<int>(content[at]) % 10);
            if (at < 2048) {
                EXPECT_EQ(Bytes(content.begin() + static_cast<std::ptrdiff_t>(at),
                                content.begin() + static_cast<std::ptrdiff_t>(at) + 512),
                          Bytes(512, content[at]))
                    << "a sector is whole";
            }
        }
        seen.insert(sectors.substr(0, 4));
    }
    EXPECT_TRUE(seen.contains("1111") && seen.contains("2222") && seen.contains("2333"));
    EXPECT_EQ(seen.size(), 2u * 3 * 3 * 3) << "each sector in each of its states";
    ASSERT_TRUE((*file)->sync().ok());
    for (std::uint64_t seed = 0; seed < 20; ++seed) EXPECT_EQ(files.crash(seed)->bytes("a"), files.bytes("a"));

    // A sync that failed: the next one does not make good what was written before it.
    ASSERT_TRUE((*file)->write(0, Bytes(512, std::byte{7})).ok());
    files.fail_at(1, Fault::Once);
    EXPECT_FALSE((*file)->sync().ok());
    ASSERT_TRUE((*file)->sync().ok());
    int lost = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) lost += files.crash(seed)->bytes("a")[0] == std::byte{2} ? 1 : 0;
    EXPECT_GT(lost, 0);
    ASSERT_TRUE((*file)->write(0, Bytes(512, std::byte{7})).ok());
    ASSERT_TRUE((*file)->sync().ok());
    for (std::uint64_t seed = 0; seed < 40; ++seed) EXPECT_EQ(files.crash(seed)->bytes("a")[0], std::byte{7});
}

}  // namespace
}  // namespace tilth::test
