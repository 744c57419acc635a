// tilth_crash_child: edits, saves and compacts a world without end, until it is killed. See world_crash_test.cpp.
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>

#include "store/crash_notes.h"
#include "store/edit_script.h"
#include "tilth/store/saved_ground.h"

namespace tilth::test {
namespace {

[[noreturn]] void die() {
    ::kill(::getpid(), SIGKILL);
    for (;;) ::pause();
}

/// The system's files, but at a given operation the process dies: before it, after it, or half-way through a write.
class DeadlyFiles final : public FileSystem {
public:
    DeadlyFiles(CrashNotes& notes, std::uint64_t die_at, std::uint64_t seed)
        : notes_(notes), die_at_(die_at), way_(SplitMix64{seed}.next() % 3) {}

    Result<std::unique_ptr<File>> open(const std::string& path, OpenMode mode) override {
        auto file =
            mode == OpenMode::Create ? around([&] { return inner_.open(path, mode); }) : inner_.open(path, mode);
        if (!file) return file.error();
        return std::unique_ptr<File>(new DeadlyFile(*this, std::move(*file)));
    }
    bool exists(const std::string& path) override { return inner_.exists(path); }
    Result<void> make_folder(const std::string& path) override {
        return around([&] { return inner_.make_folder(path); });
    }
    Result<std::vector<std::string>> list(const std::string& folder) override { return inner_.list(folder); }
    Result<void> rename(const std::string& from, const std::string& to) override {
        return around([&] { return inner_.rename(from, to); });
    }
    Result<void> remove(const std::string& path) override {
        return around([&] { return inner_.remove(path); });
    }
    Result<void> sync_folder(const std::string& folder) override {
        return around([&] { return inner_.sync_folder(folder); });
    }
    Result<std::unique_ptr<FileLock>> lock(const std::string& path) override { return inner_.lock(path); }

private:
    class DeadlyFile final : public File {
    public:
        DeadlyFile(DeadlyFiles& files, std::unique_ptr<File> inner)
            : File(inner->path()), files_(files), inner_(std::move(inner)) {}
        Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> out) override {
            return inner_->read(offset, out);
        }
        Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
            const bool is_last = files_.is_last();
            if (is_last && files_.way_ == 0) die();
            if (is_last && files_.way_ == 1) bytes = bytes.first(bytes.size() / 2);
            Result<void> done = inner_->write(offset, bytes);
            if (is_last) die();
            return done;
        }
        Result<void> sync() override {
            return files_.around([&] { return inner_->sync(); });
        }
        Result<void> truncate(std::uint64_t size) override {
            return files_.around([&] { return inner_->truncate(size); });
        }
        Result<std::uint64_t> size() override { return inner_->size(); }

    private:
        DeadlyFiles& files_;
        std::unique_ptr<File> inner_;
    };

    bool is_last() { return ++notes_.operations == die_at_; }
    template <class Operation>
    std::invoke_result_t<const Operation&> around(const Operation& operation) {
        const bool is_last = this->is_last();
        if (is_last && way_ == 0) die();
        auto done = operation();
        if (is_last) die();
        return done;
    }

    FileSystem& inner_ = system_files();
    CrashNotes& notes_;
    std::uint64_t die_at_, way_;
};

/// What the run does, drawn from its seed.
struct Manner {
    WorldOptions options;
    std::uint64_t edits_a_flush = 1, edits_a_save = 10;
    bool saves_beside = false;  ///< on a second thread, while edits go on

    explicit Manner(SplitMix64& random) {
        constexpr FlushPolicy::When kWhens[] = {FlushPolicy::When::Each, FlushPolicy::When::Every,
                                                FlushPolicy::When::Manual};
        constexpr std::uint64_t kKept[] = {0, 4096, 64u << 20};
        options.flush = {.when = kWhens[random.next() % 3], .interval_ms = 0.5};
        options.keep_journal_bytes = kKept[random.next() % 3];
        options.log = {.most_waste = 0.3, .least_waste_bytes = 64u << 10};
        edits_a_flush = 1 + random.next() % 12;
        edits_a_save = 4 + random.next() % 30;
        saves_beside = random.next() % 2 == 0;
    }
};

/// A snapshot on its way to the disk.
class Saving {
public:
    Saving(SavedGround& world, bool beside) : world_(world), snapshot_(world.snapshot()) {
        if (beside)
            thread_ = std::thread([this] { write(); });
        else
            write();
    }
    [[nodiscard]] bool is_done() const { return is_done_; }
    Result<void> finish() {
        if (thread_.joinable()) thread_.join();
        world_.finish(snapshot_, outcome_);
        return outcome_;
    }

private:
    void write() {
        outcome_ = world_.commit(snapshot_);
        for (bool more = outcome_.ok(); more;) {
            const auto step = world_.world().compact(128u << 10);
            if (!step) outcome_ = step.error();
            more = step && *step;
        }
        is_done_ = true;
    }
    SavedGround& world_;
    Snapshot snapshot_;
    Result<void> outcome_;
    std::atomic<bool> is_done_ = false;
    std::thread thread_;
};

Result<void> run(CrashNotes& notes, const std::string& folder, std::uint64_t script_seed, std::uint64_t run_seed,
                 std::uint64_t die_at) {
    SplitMix64 random{run_seed};
    DeadlyFiles files(notes, die_at, random.next());
    Manner manner(random);
    manner.options.files = &files;
    auto opened = open_script_world({.undo_bytes = 2u << 20}, folder, manner.options);
    if (!opened) return opened.error();
    SavedGround& world = **opened;
    notes.durable = world.world().durable();
    notes.is_open = 1;
    EditScript script(script_seed);
    std::unique_ptr<Saving> saving;
    while (true) {
        const std::uint64_t n = world.world().appended() + 1;
        if (!script.step(world, n)) return Error{ErrorCode::InvalidArgument, text("edit ", n, " was refused")};
        if (manner.options.flush.when == FlushPolicy::When::Manual && n % manner.edits_a_flush == 0)
            if (const Result<void> flushed = world.flush(); !flushed) return flushed;
        notes.durable = world.world().durable();
        if (saving == nullptr && n % manner.edits_a_save == 0)
            saving = std::make_unique<Saving>(world, manner.saves_beside);
        if (saving != nullptr && saving->is_done()) {
            if (const Result<void> saved = saving->finish(); !saved) return saved;
            saving.reset();
            ++notes.saves;
        }
        for (const Error& error : world.world().take_errors()) return error;
    }
}

}  // namespace
}  // namespace tilth::test

int main(int argc, char** argv) {
    if (argc != 6) return 2;
    ::alarm(120);  // nobody kills it: then it is on its own
    auto& notes = tilth::test::notes_in(argv[1], false);
    const auto number = [&](int i) { return std::strtoull(argv[i], nullptr, 10); };
    const auto outcome = tilth::test::run(notes, argv[2], number(3), number(4), number(5));
    if (!outcome) notes.fail(outcome.error().message);
    return 3;  // it should have been killed
}
