// Real processes, killed at any moment while they stamp, save and compact: what was flushed is there, to the bit.
//
// TILTH_CRASH_KILLS sets how often (25; `./run crash` takes 1 000), TILTH_CRASH_SEED what is drawn.
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/scratch_folder.h"
#include "store/crash_notes.h"
#include "store/edit_script.h"

extern char** environ;

namespace tilth {
namespace {

using test::CrashNotes;
using test::ReferenceWorld;
using test::ScriptWorld;

constexpr std::uint64_t kKillsAFolder = 50;
// Some ten of the script's strokes at least; it undoes three.
constexpr ScriptWorld kWorld{.undo_bytes = 2u << 20};

std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
    const char* const value = std::getenv(name);
    return value == nullptr ? otherwise : std::strtoull(value, nullptr, 10);
}

/// A child on a world of its own, killed again and again.
class KilledWorld {
public:
    KilledWorld(const test::ScratchFolder& scratch, std::uint64_t seed)
        : folder_(scratch.path(text("world ", seed))),
          notes_path_(scratch.path("notes")),
          seed_(seed),
          random_{seed},
          reference_(std::make_unique<ReferenceWorld>(kWorld, seed)) {}

    /// Half of the children are killed from without at any moment, half kill themselves at an operation on their files.
    void run_and_kill() {
        CrashNotes& notes = test::notes_in(notes_path_, true);
        const bool from_without = random_.next() % 2 == 0;
        const std::uint64_t die_at = from_without ? 0 : 1 + random_.next() % 150;
        const pid_t child = spawn(random_.next(), die_at);
        ASSERT_GT(child, 0);
        int status = 0;
        pid_t ended = 0;
        if (from_without) {
            while (notes.is_open == 0 && (ended = ::waitpid(child, &status, WNOHANG)) == 0) ::usleep(200);
            if (ended == 0) {
                ::usleep(static_cast<useconds_t>(random_.next() % 60'000));
                ::kill(child, SIGKILL);
            }
        }
        if (ended == 0) ended = ::waitpid(child, &status, 0);
        ASSERT_EQ(ended, child);
        ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << "status " << status << ": " << notes.error;
        durable_ = std::max<std::uint64_t>(durable_, notes.durable);
        saves += notes.saves;
    }

    void check() {
        auto opened = test::open_script_world(kWorld, folder_, {.flush = {.when = FlushPolicy::When::Manual}});
        ASSERT_TRUE(opened) << opened.error().message;
        SavedGround& world = **opened;
        for (const Error& error : world.reports()) ADD_FAILURE() << error.message;
        for (const Error& error : world.world().verify()) ADD_FAILURE() << error.message;
        const std::uint64_t edits = world.world().appended();
        ASSERT_GE(edits, durable_) << "edits that were flushed are lost";
        ASSERT_TRUE(reference_->advance_to(edits));
        ASSERT_EQ(reference_->edits(), edits);
        ASSERT_EQ(world.ground().hash(), reference_->hash()) << "after " << edits << " edits";
        durable_ = edits;
        if (random_.next() % 4 == 0) {
            ASSERT_TRUE(world.save());
        }
        reference_->begin_run();
    }

    /// Takes back what world and reference can take back: a replay may keep more than the bound leaves otherwise.
    void check_undo() {
        auto opened = test::open_script_world(kWorld, folder_, {.flush = {.when = FlushPolicy::When::Manual}});
        ASSERT_TRUE(opened) << opened.error().message;
        const std::size_t strokes = std::min((*opened)->history().undoable(), reference_->history().undoable());
        if (durable_ > 32) {
            EXPECT_GE(strokes, 10u);
        }
        for (std::size_t i = 0; i < strokes; ++i) {
            ASSERT_TRUE((*opened)->undo());
            ASSERT_TRUE(reference_->undo());
        }
        ASSERT_EQ((*opened)->ground().hash(), reference_->hash()) << "after undoing " << strokes << " strokes";
    }

    [[nodiscard]] std::uint64_t edits() const { return durable_; }
    [[nodiscard]] std::string folder() const { return folder_; }
    std::uint64_t saves = 0;

private:
    pid_t spawn(std::uint64_t run_seed, std::uint64_t die_at) const {
        std::vector<std::string> words = {
            TILTH_CRASH_CHILD,        notes_path_,           folder_, std::to_string(seed_),
            std::to_string(run_seed), std::to_string(die_at)};
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        pid_t child = 0;
        return ::posix_spawn(&child, TILTH_CRASH_CHILD, nullptr, nullptr, arguments.data(), environ) == 0 ? child : -1;
    }

    std::string folder_, notes_path_;
    std::uint64_t seed_;
    SplitMix64 random_;
    std::unique_ptr<ReferenceWorld> reference_;
    std::uint64_t durable_ = 0;
};

TEST(WorldCrash, EverythingThatWasFlushedIsThereAfterAnyKill) {
    const test::ScratchFolder scratch;
    const std::uint64_t kills = from_environment("TILTH_CRASH_KILLS", 25),
                        seed = from_environment("TILTH_CRASH_SEED", 1);
    std::uint64_t edits = 0, saves = 0, compactions = 0;
    std::unique_ptr<KilledWorld> world;
    const auto count = [&] {
        if (world == nullptr) return;
        world->check_undo();
        edits += world->edits();
        saves += world->saves;
        for (const auto& file : std::filesystem::directory_iterator(world->folder())) {
            const std::string name = file.path().filename().string();
            if (name.starts_with("pages-") && name.ends_with(".tlp")) compactions += std::stoull(name.substr(6)) - 1;
        }
        std::filesystem::remove_all(world->folder());
    };
    for (std::uint64_t kill = 0; kill < kills; ++kill) {
        SCOPED_TRACE(testing::Message() << "kill " << kill + 1 << " of " << kills << ", TILTH_CRASH_SEED=" << seed);
        if (kill % kKillsAFolder == 0) {
            count();
            world = std::make_unique<KilledWorld>(scratch, seed * 1000 + kill / kKillsAFolder);
        }
        ASSERT_NO_FATAL_FAILURE(world->run_and_kill());
        ASSERT_NO_FATAL_FAILURE(world->check());
        if (HasFailure()) return;
    }
    count();
    RecordProperty("edits", static_cast<int>(edits));
    RecordProperty("saves", static_cast<int>(saves));
    RecordProperty("compactions", static_cast<int>(compactions));
    std::printf("%llu kills, %llu edits, %llu saves, %llu compactions\n", static_cast<unsigned long long>(kills),
                static_cast<unsigned long long>(edits), static_cast<unsigned long long>(saves),
                static_cast<unsigned long long>(compactions));
    EXPECT_GT(edits, kills);
    EXPECT_GT(saves, 0u);
}

}  // namespace
}  // namespace tilth
