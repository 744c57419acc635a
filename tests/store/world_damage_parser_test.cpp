// Bits that flip, sectors of zeros and files that end early, in every file of a world: it is what it was, or says what
// is wrong.
//
// TILTH_DAMAGES sets how many of each kind of file (1 250; 60 under a sanitizer).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "store/edit_script.h"
#include "support/fault_files.h"

namespace tilth {
namespace {

using test::EditScript;
using test::FaultFiles;
using test::joined;
using test::ReferenceWorld;
using test::ScriptWorld;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kDamages = 60;
#else
constexpr std::uint64_t kDamages = 1250;
#endif

constexpr std::uint64_t kSeed = 21, kEdits = 60;

constexpr ScriptWorld kWorld{.heights = "hill:size=65,peak=12,sigma=15"};

/// Three commits, and a tail of edits behind them.
void make_world(FaultFiles& disk, std::uint64_t keep_journal_bytes) {
    auto world = test::open_script_world(
        kWorld, "world",
        {.flush = {.when = FlushPolicy::When::Manual}, .keep_journal_bytes = keep_journal_bytes, .files = &disk});
    ASSERT_TRUE(world);
    EditScript script(kSeed);
    for (const std::uint64_t edits : {15u, 30u, 45u}) {
        ASSERT_TRUE(test::advance(**world, script, edits));
        ASSERT_TRUE((*world)->save());
    }
    ASSERT_TRUE(test::advance(**world, script, kEdits));
    ASSERT_TRUE((*world)->flush());
}

/// `right`: hashes after each number of edits.
void expect_honest(FaultFiles& disk, const std::string& damaged, const std::vector<StateHash>& right) {
    auto world =
        test::open_script_world(kWorld, "world", {.flush = {.when = FlushPolicy::When::Manual}, .files = &disk});
    if (!world) {
        EXPECT_NE(world.error().message.find(damaged), std::string::npos) << world.error().message;
        return;
    }
    const std::string told = joined((*world)->reports());
    const std::uint64_t edits = (*world)->world().appended();
    ASSERT_LE(edits, kEdits);
    const bool is_right = (*world)->ground().hash() == right[edits];
    const bool is_named = told.find(damaged) != std::string::npos;
    if (damaged.ends_with(".tlj"))  // a torn tail cannot be told from one that was never written
        EXPECT_TRUE(is_right || is_named) << edits << " edits; told: " << told;
    else
        EXPECT_TRUE((is_right && edits == kEdits) || is_named) << edits << " edits; told: " << told;
    if (!is_right && told.empty()) ADD_FAILURE() << "wrong, and nothing was said";
    const std::vector<Error> verified = (*world)->world().verify();
    // It can go on: what is wrong now stays known, what was right stays right.
    EditScript script(kSeed + 1);
    for (int i = 0; i < 3; ++i)
        EXPECT_TRUE((*world)->stamp({.centre = {10.0 + i, 10}, .radius_m = 2, .amplitude_m = 0.1})) << told;
    const StateHash now = (*world)->ground().hash();
    const auto saved = (*world)->save();
    EXPECT_TRUE(saved) << saved.error().message;
    world = Error{};
    world = test::open_script_world(kWorld, "world", {.flush = {.when = FlushPolicy::When::Manual}, .files = &disk});
    ASSERT_TRUE(world) << world.error().message << "; told: " << told << joined(verified);
    EXPECT_EQ((*world)->ground().hash(), now) << "told: " << told << "told again: " << joined((*world)->reports());
}

class WorldDamage : public testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Journals, WorldDamage, testing::Values(64u << 20, 0u),
                         [](const auto& of) { return of.param == 0 ? "OfTheTailAlone" : "FromTheFirstEdit"; });

TEST_P(WorldDamage, IsRepairedOrTold) {
    FaultFiles disk;
    ASSERT_NO_FATAL_FAILURE(make_world(disk, GetParam()));
    std::vector<StateHash> right;
    ReferenceWorld reference(kWorld, kSeed);
    for (std::uint64_t edits = 0; edits <= kEdits; ++edits) {
        ASSERT_TRUE(reference.advance_to(edits));
        right.push_back(reference.hash());
    }
    const char* const given = std::getenv("TILTH_DAMAGES");
    const std::uint64_t damages = given == nullptr ? kDamages : std::strtoull(given, nullptr, 10);
    SplitMix64 random{GetParam() + 1};
    for (const std::string& path : disk.paths()) {
        const std::uint64_t size = disk.bytes(path).size();
        if (size == 0) continue;  // the lock
        for (std::uint64_t i = 0; i < damages; ++i) {
            const std::unique_ptr<FaultFiles> copy = disk.crash(i);  // everything is durable: a copy
            std::string what;
            const std::uint64_t way = random.next() % 4;
            if (way == 1) {
                std::vector<std::byte> bytes = copy->bytes(path);
                const std::uint64_t begin = random.next() % size,
                                    end = std::min(size, begin + 1 + random.next() % 6000);
                std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                          bytes.begin() + static_cast<std::ptrdiff_t>(end), std::byte{0});
                copy->set_bytes(path, std::move(bytes));
                what = text("zeros from ", begin, " to ", end);
            } else if (way == 0) {
                const std::uint64_t left = random.next() % size;
                copy->cut(path, left);
                what = text("cut to ", left, " bytes of ", size);
            } else {
                what = "bits flipped:";
                for (std::uint64_t flips = 1 + random.next() % 3; flips > 0; --flips) {
                    const std::uint64_t bit = random.next() % (8 * size);
                    copy->flip_bit(path, bit);
                    what += text(" ", bit);
                }
            }
            SCOPED_TRACE(testing::Message() << path << ", " << what);
            ASSERT_NO_FATAL_FAILURE(expect_honest(*copy, path, right));
            if (HasFailure()) return;
        }
    }
}

}  // namespace
}  // namespace tilth
