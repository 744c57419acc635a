// The life of a tile: the whole table, and that no order of events loses an edit.
#include "tilth/cache/tile_state.h"

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

constexpr TileState kStates[] = {TileState::Absent, TileState::Loading, TileState::Uploading, TileState::Resident,
                                 TileState::Saving};
constexpr TileEvent kEvents[] = {TileEvent::Wanted, TileEvent::Unwanted,  TileEvent::Loaded, TileEvent::LoadFailed,
                                 TileEvent::Filled, TileEvent::Displaced, TileEvent::Saved,  TileEvent::SaveFailed};

// Four answers a cell, for the facts (saved, textures old), (saved, current), (modified, old), (modified, current).
// Small letters are states (a, l, u, r, s), the sign after them what is to be done: . nothing, L load, C cancel the
// load, F fill, S save, A save again, R rescue, D drop.
struct Row {
    TileEvent event;
    std::string_view absent, loading, uploading, resident, saving;
};
// clang-format off
constexpr Row kTable[] = {
    {TileEvent::Wanted,     "lL lL lL lL", "l. l. l. l.", "u. u. u. u.", "r. r. r. r.", "uR rR uR rR"},
    {TileEvent::Unwanted,   "a. a. a. a.", "aC aC aC aC", "aD aD sS sS", "aD aD sS sS", "s. s. s. s."},
    {TileEvent::Loaded,     "a. a. a. a.", "uF uF uF uF", "u. u. u. u.", "r. r. r. r.", "s. s. s. s."},
    {TileEvent::LoadFailed, "a. a. a. a.", "a. a. a. a.", "u. u. u. u.", "r. r. r. r.", "s. s. s. s."},
    {TileEvent::Filled,     "a. a. a. a.", "l. l. l. l.", "r. r. r. r.", "r. r. r. r.", "s. s. s. s."},
    {TileEvent::Displaced,  "a. a. a. a.", "l. l. l. l.", "u. u. u. u.", "u. u. u. u.", "s. s. s. s."},
    {TileEvent::Saved,      "a. a. a. a.", "l. l. l. l.", "u. u. u. u.", "r. r. r. r.", "aD aD sS sS"},
    {TileEvent::SaveFailed, "a. a. a. a.", "l. l. l. l.", "u. u. u. u.", "r. r. r. r.", "sA sA sA sA"},
};
// clang-format on

char letter(TileState state) { return "alurs"[static_cast<int>(state)]; }
char letter(TileAction action) {
    switch (action) {
        case TileAction::None:
            return '.';
        case TileAction::StartLoad:
            return 'L';
        case TileAction::CancelLoad:
            return 'C';
        case TileAction::StartFill:
            return 'F';
        case TileAction::StartSave:
            return 'S';
        case TileAction::RetrySave:
            return 'A';
        case TileAction::Rescue:
            return 'R';
        case TileAction::Drop:
            return 'D';
    }
    return '?';
}

TEST(TileState, TheWholeTable) {
    for (const Row& row : kTable) {
        const std::string_view cells[] = {row.absent, row.loading, row.uploading, row.resident, row.saving};
        for (const TileState state : kStates)
            for (std::size_t facts = 0; facts < 4; ++facts) {
                const TileStep step =
                    next_step(state, row.event, {.modified = (facts & 2) != 0, .textures_current = (facts & 1) != 0});
                const std::string found{letter(step.next), letter(step.action)};
                EXPECT_EQ(found, cells[static_cast<std::size_t>(state)].substr(facts * 3, 2))
                    << letter(state) << " event " << static_cast<int>(row.event) << " facts " << facts;
            }
    }
}

/// A tile whose content is the number of edits it has seen, and an owner that does what the steps say. Edits fall on it
/// at any time; those on a tile that is not in memory wait. Events come in any order, also those that nobody expects.
struct ModelTile {
    TileState state = TileState::Absent;
    std::optional<int> memory;  ///< edits in the codes in memory
    int store = 0;              ///< edits in the store's codes
    int truth = 0, waiting = 0;
    std::deque<int> saves;  ///< on their way to the store, in order
    bool loading = false, textures_current = false;

    void edit() {
        ++truth;
        if (memory)
            ++*memory, textures_current = false;
        else
            ++waiting;
    }
    void happen(TileEvent event) {
        if (event == TileEvent::Loaded || event == TileEvent::LoadFailed) {
            if (!loading) return;  // nobody was asked
            loading = false;
            if (event == TileEvent::Loaded && state == TileState::Loading) {
                memory = (saves.empty() ? store : saves.back()) + waiting;  // the worker saves before it loads
                waiting = 0;
            }
        }
        if (event == TileEvent::Saved || event == TileEvent::SaveFailed) {
            if (saves.empty()) return;
            if (event == TileEvent::Saved) store = saves.front();
            saves.pop_front();
        }
        if (event == TileEvent::Displaced) textures_current = false;
        if (event == TileEvent::Filled && state == TileState::Uploading) textures_current = true;
        const bool modified = memory && (*memory != store || !saves.empty());
        const TileStep step = next_step(state, event, {modified, textures_current});
        state = step.next;
        switch (step.action) {
            case TileAction::StartLoad:
                loading = true;
                break;
            case TileAction::CancelLoad:
                loading = false;
                break;
            case TileAction::StartSave:
            case TileAction::RetrySave:
                ASSERT_TRUE(memory) << "nothing to save";
                if (saves.empty() || saves.back() != *memory) saves.push_back(*memory);  // else it is on its way
                break;
            case TileAction::Drop:
                ASSERT_TRUE(memory) << "nothing to drop";
                ASSERT_EQ(*memory, store) << "dropped an edit";
                ASSERT_TRUE(saves.empty());
                memory.reset();
                textures_current = false;
                break;
            default:
                break;
        }
    }
    void check() const {
        ASSERT_EQ((memory ? *memory : store) + waiting, truth);
        ASSERT_EQ(memory.has_value(), state != TileState::Absent && state != TileState::Loading);
        ASSERT_TRUE(state != TileState::Saving || !saves.empty()) << "nobody would ever wake it";
        ASSERT_TRUE(state != TileState::Loading || loading) << "nobody would ever wake it";
        ASSERT_TRUE(state != TileState::Resident || memory);
    }
};

TEST(TileState, NoOrderOfEventsLosesAnEdit) {
    std::set<std::pair<TileState, TileState>> changes;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SplitMix64 random{seed};
        ModelTile tile;
        for (int i = 0; i < 1000; ++i) {
            const TileState before = tile.state;
            const std::uint64_t choice = random.next() % 10;
            if (choice >= 8)
                tile.edit();
            else
                tile.happen(kEvents[choice]);
            changes.insert({before, tile.state});
            tile.check();
            if (HasFatalFailure()) FAIL() << "seed " << seed << " step " << i;
        }
    }
    // Five stays, and from Absent 1 arrow, Loading 2, Uploading 3, Resident 3, Saving 3: all were gone along.
    EXPECT_EQ(changes.size(), 5u + 12u);
}

TEST(TileState, AQuietTileComesToRest) {
    for (const bool wanted : {true, false})
        for (std::uint64_t seed = 0; seed < 200; ++seed) {
            SplitMix64 random{seed};
            ModelTile tile;
            for (int i = 0; i < 50; ++i) {
                if (random.next() % 4 == 0) tile.edit();
                tile.happen(kEvents[random.next() % 8]);
            }
            for (int i = 0; i < 8; ++i)
                for (const TileEvent event : {wanted ? TileEvent::Wanted : TileEvent::Unwanted, TileEvent::Loaded,
                                              TileEvent::Filled, TileEvent::Saved})
                    tile.happen(event);
            EXPECT_EQ(tile.state, wanted ? TileState::Resident : TileState::Absent) << seed;
            EXPECT_EQ(wanted ? *tile.memory : tile.store + tile.waiting, tile.truth) << seed;
        }
}

}  // namespace
}  // namespace tilth
