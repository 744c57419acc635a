// The one way in for edits: strokes, refusals, snapshots, and going on from any of them.
#include "tilth/store/editor.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "ground/random_edits.h"

namespace tilth {
namespace {

using test::kPlenty;
using test::RandomRequests;

StampRequest dent(double x_m = 10) {
    return {.shape = {0}, .centre = {x_m, 20}, .radius_m = 2, .amplitude_m = -0.2, .map = MapChoice::Detail};
}

/// Applies what the editor has queued.
void apply_queue(Editor& editor, Ground& ground) {
    for (const GroundEdit& edit : editor.take_queue()) apply_edit(ground, edit);
    editor.applied();
}

bool contains(const Result<void>& result, const std::string& part) {
    return !result.ok() && result.error().message.find(part) != std::string::npos;
}

TEST(Editor, StampsAreStrokesOfTheirOwnUnlessTheyAreSaidToBelongTogether) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    Editor editor(*ground, nullptr, kPlenty);
    const auto stamp = [&] { ASSERT_TRUE(editor.stamp(dent()).ok()); };
    stamp();
    stamp();
    EXPECT_EQ(editor.history().undoable(), 2u);
    editor.begin_stroke();
    EXPECT_EQ(editor.history().undoable(), 2u);  // not before its first stamp
    stamp();
    stamp();
    stamp();
    EXPECT_EQ(editor.history().undoable(), 3u);
    editor.begin_stroke();
    stamp();
    editor.end_stroke();
    stamp();
    EXPECT_EQ(editor.history().undoable(), 5u);
    EXPECT_EQ(editor.history().done()[2]->records.size(), 3u);
    EXPECT_EQ(editor.edits(), 7u);
    apply_queue(editor, *ground);
    EXPECT_TRUE(editor.is_empty());
}

TEST(Editor, AnUndoWithinAStrokeEndsIt) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    Editor editor(*ground, nullptr, kPlenty);
    ASSERT_TRUE(editor.stamp(dent()).ok());
    apply_queue(editor, *ground);
    const StateHash first = ground->hash();
    editor.begin_stroke();
    ASSERT_TRUE(editor.stamp(dent()).ok());
    ASSERT_TRUE(editor.undo().ok());
    ASSERT_TRUE(editor.stamp(dent(12)).ok());
    ASSERT_TRUE(editor.stamp(dent(13)).ok());
    editor.end_stroke();
    EXPECT_EQ(editor.history().undoable(), 2u);  // and the first stroke has no new stamps
    EXPECT_EQ(editor.history().done()[0]->records.size(), 1u);
    ASSERT_TRUE(editor.undo().ok());
    apply_queue(editor, *ground);
    EXPECT_EQ(ground->hash(), first);
}

TEST(Editor, WhatIsRefusedChangesNothing) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    Editor editor(*ground, nullptr, kPlenty);
    ASSERT_TRUE(editor.stamp(dent()).ok());
    ASSERT_TRUE(editor.undo().ok());
    const std::size_t queued = editor.take_queue().size();
    EXPECT_EQ(queued, 2u);
    StampRequest bad = dent();
    bad.radius_m = -1;
    EXPECT_FALSE(editor.stamp(bad).ok());
    EXPECT_FALSE(editor.undo().ok());
    StampRecord foreign = *ground->issue(dent());
    foreign.shape_hash ^= 1;
    EXPECT_TRUE(contains(editor.replay(foreign), "shape"));
    EXPECT_TRUE(editor.is_empty());
    EXPECT_EQ(editor.edits(), 2u);
    EXPECT_EQ(editor.history().redoable(), 1u);  // a refused stamp forgets nothing
    ASSERT_TRUE(editor.redo().ok());
    EXPECT_FALSE(editor.redo().ok());
    EXPECT_EQ(editor.edits(), 3u);
}

TEST(Editor, ReplayedRecordsKeepTheirNumbers) {
    const auto ground = test::small_world(HeightPrecision::bits32), other = test::small_world(HeightPrecision::bits32);
    StampRecord record = *other->issue(dent());
    record.sequence = 40;
    Editor editor(*ground, nullptr, kPlenty);
    ASSERT_TRUE(editor.replay(record).ok());
    EXPECT_EQ(editor.stamp(dent())->sequence, 41u);
    const std::vector<GroundEdit> queue = editor.take_queue();
    ASSERT_EQ(queue.size(), 2u);
    EXPECT_EQ(queue[0].record, record);
    EXPECT_NE(queue[0].stroke, queue[1].stroke);
}

TEST(Editor, NothingIsForgottenWhileEditsAreInTheQueue) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    Editor editor(*ground, nullptr, 1);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(editor.stamp(dent()).ok());
    editor.applied();  // not yet
    EXPECT_EQ(editor.history().undoable(), 3u);
    EXPECT_EQ(editor.take_queue().size(), 3u);
    editor.applied();
    EXPECT_EQ(editor.history().undoable(), 0u);
}

TEST(Editor, RedoIsTheStampsAgain) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    Editor editor(*ground, nullptr, kPlenty);
    editor.begin_stroke();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(editor.stamp(dent(10 + i)).ok());
    const std::vector<GroundEdit> issued = editor.take_queue();
    ASSERT_TRUE(editor.undo().ok());
    ASSERT_EQ(editor.take_queue().size(), 1u);
    ASSERT_TRUE(editor.redo().ok());
    const std::vector<GroundEdit> again = editor.take_queue();
    ASSERT_EQ(again.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(again[i].record, issued[i].record);
        EXPECT_EQ(again[i].stroke, issued[i].stroke);
        EXPECT_EQ(again[i].position, i);
    }
}

// ---- snapshots and recovery ----

/// Strokes as a store keeps them: what each snapshot says has changed, and the lists of the last one.
struct StoredHistory {
    std::map<std::uint64_t, Stroke> strokes;
    HistorySnapshot last;

    void commit(HistorySnapshot snapshot) {
        for (const Stroke& stroke : snapshot.changed) strokes[stroke.number] = stroke;
        last = std::move(snapshot);
    }
    [[nodiscard]] std::vector<StrokePtr> read(const std::vector<std::uint64_t>& numbers) const {
        std::vector<StrokePtr> read;
        for (const std::uint64_t number : numbers) {
            const Stroke& stored = strokes.at(number);
            read.push_back(std::make_shared<Stroke>());
            read.back()->number = number;
            read.back()->records = stored.records;
            read.back()->coarse = stored.coarse;
            read.back()->detail = stored.detail;
        }
        return read;
    }
};

/// A world after some edit, as a store has it.
struct Saved {
    Ground ground;
    std::uint64_t edits, next_sequence;
    StoredHistory history;

    [[nodiscard]] RecoveredWorld recovered(const std::vector<Edit>& all) const {
        RecoveredWorld world;
        world.next_sequence = next_sequence;
        world.done = history.read(history.last.done);
        world.undone = history.read(history.last.undone);
        world.next_stroke = history.last.next_number;
        world.tail.assign(all.begin() + static_cast<std::ptrdiff_t>(edits), all.end());
        return world;
    }
};

/// A world with everything that happened to it: each edit, the state after it, and what a save then would have kept.
struct Lived {
    std::unique_ptr<Ground> ground;
    Editor editor;
    std::vector<Edit> edits;
    std::vector<StateHash> states;
    std::vector<Saved> saves;

    Lived(HeightPrecision precision, std::uint64_t bound)
        : ground(test::small_world(precision)), editor(*ground, nullptr, bound) {
        settle();
    }
    /// After each edit.
    void settle() {
        apply_queue(editor, *ground);
        ASSERT_EQ(editor.edits(), edits.size());
        states.push_back(ground->hash());
        Snapshot snapshot = editor.begin_snapshot();
        StoredHistory history = saves.empty() ? StoredHistory{} : saves.back().history;
        history.commit(std::move(snapshot.history));
        saves.push_back({*ground, snapshot.edits, snapshot.next_sequence, std::move(history)});
    }
    void live(std::uint32_t seed, int strokes) {
        RandomRequests random(seed);
        for (int i = 0; i < strokes; ++i) {
            const double what = random.real(0, 1);
            if (what < 0.25 && editor.history().undoable() > 0) {
                turn(EditKind::Undo, editor.history().done().back());
            } else if (what < 0.35 && editor.history().redoable() > 0) {
                turn(EditKind::Redo, editor.history().undone().back());
            } else {
                editor.begin_stroke();
                const std::int32_t count = random.whole(1, 5);
                for (std::int32_t k = 0; k < count; ++k) {
                    const Result<StampRecord> record = editor.stamp(random.next(*ground));
                    ASSERT_TRUE(record.ok());
                    edits.push_back({.begins_stroke = k == 0, .record = *record});
                    settle();
                }
                editor.end_stroke();
            }
        }
    }
    void turn(EditKind kind, const StrokePtr& stroke) {
        edits.push_back({.kind = kind, .record = {.sequence = stroke->records.front().sequence}});
        ASSERT_TRUE((kind == EditKind::Undo ? editor.undo() : editor.redo()).ok());
        settle();
    }
};

class EditorRecovery : public testing::TestWithParam<HeightPrecision> {};
INSTANTIATE_TEST_SUITE_P(Both, EditorRecovery, testing::ValuesIn(test::kBothPrecisions), [](const auto& param) {
    return param.param == HeightPrecision::bits32 ? "bits32" : "bits16";
});

// Replay from any snapshot, also one within a stroke; and then undo all the way, as the world that never closed.
TEST_P(EditorRecovery, FromAnySnapshotTheRestOfTheEditsGivesTheSameWorld) {
    for (const std::uint64_t bound : {kPlenty, std::uint64_t{400'000}}) {
        Lived lived(GetParam(), bound);
        lived.live(17, 20);
        std::vector<StateHash> undone_states;  // of the world that never closed
        const std::uint64_t next_sequence = lived.ground->next_sequence();
        {
            UndoHistory& history = lived.editor.history();
            while (history.undoable() > 0) {
                ASSERT_TRUE(lived.editor.undo().ok());
                apply_queue(lived.editor, *lived.ground);
                undone_states.push_back(lived.ground->hash());
            }
        }
        ASSERT_GT(undone_states.size(), 1u);
        ASSERT_GT(lived.edits.size(), 30u);
        for (const Saved& saved : lived.saves) {
            Ground ground = saved.ground;
            Editor editor(ground, nullptr, bound);
            RecoveredWorld recovered = saved.recovered(lived.edits);
            const Result<void> done = editor.recover(recovered);
            ASSERT_TRUE(done.ok()) << done.error().message;
            for (const GroundEdit& edit : editor.take_queue()) apply_edit(ground, edit);
            ASSERT_EQ(ground.hash(), lived.states.back()) << "from edit " << saved.edits;
            ASSERT_EQ(ground.next_sequence(), next_sequence);
            ASSERT_GE(editor.history().undoable(), undone_states.size());  // nothing is forgotten while it replays
            editor.applied();
            ASSERT_LE(editor.history().bytes(), bound);
            std::size_t undone = 0;
            while (editor.history().undoable() > 0) {
                ASSERT_TRUE(editor.undo().ok());
                apply_queue(editor, ground);
                if (undone < undone_states.size()) {
                    ASSERT_EQ(ground.hash(), undone_states[undone]) << "from edit " << saved.edits;
                }
                ++undone;
            }
            ASSERT_GE(undone + 1, undone_states.size());
        }
    }
}

// What a snapshot says has changed is enough, and is no more than what did.
TEST(EditorSnapshot, NamesWhatChangedSinceTheLastOne) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    Editor editor(*ground, nullptr, kPlenty);
    const auto changed = [&] {
        std::vector<std::uint64_t> numbers;
        const Snapshot snapshot = editor.begin_snapshot();
        for (const Stroke& stroke : snapshot.history.changed) numbers.push_back(stroke.number);
        return numbers;
    };
    using Numbers = std::vector<std::uint64_t>;
    EXPECT_EQ(changed(), Numbers{});
    ASSERT_TRUE(editor.stamp(dent()).ok());
    editor.begin_stroke();
    ASSERT_TRUE(editor.stamp(dent()).ok());
    apply_queue(editor, *ground);
    EXPECT_EQ(changed(), (Numbers{1, 2}));
    EXPECT_EQ(changed(), Numbers{});
    ASSERT_TRUE(editor.stamp(dent()).ok());  // more of stroke 2
    apply_queue(editor, *ground);
    const Snapshot failed = editor.begin_snapshot();
    ASSERT_EQ(failed.history.changed.size(), 1u);
    EXPECT_EQ(failed.history.changed.front().number, 2u);
    editor.snapshot_failed(failed);
    EXPECT_EQ(changed(), Numbers{2}) << "again";
    ASSERT_TRUE(editor.undo().ok());
    apply_queue(editor, *ground);
    const Snapshot snapshot = editor.begin_snapshot();
    EXPECT_TRUE(snapshot.history.changed.empty());  // it only went from one list to the other
    EXPECT_EQ(snapshot.history.done, Numbers{1});
    EXPECT_EQ(snapshot.history.undone, Numbers{2});
    EXPECT_EQ(snapshot.history.next_number, 3u);
    EXPECT_EQ(snapshot.edits, 4u);
    EXPECT_EQ(snapshot.next_sequence, 4u);
    editor.history().find(1)->keep_image(MapKind::Detail, {3, 3}, nullptr);  // as late stamps do
    EXPECT_EQ(changed(), Numbers{1});
}

TEST(EditorSnapshot, DoesNotNameWhatItWasRecoveredFrom) {
    Lived lived(HeightPrecision::bits32, kPlenty);
    lived.live(4, 6);
    const Saved& saved = lived.saves.back();
    Ground ground = saved.ground;
    Editor editor(ground, nullptr, kPlenty);
    RecoveredWorld recovered = saved.recovered(lived.edits);
    ASSERT_TRUE(editor.recover(recovered).ok());
    const Snapshot snapshot = editor.begin_snapshot();
    EXPECT_TRUE(snapshot.history.changed.empty());
    EXPECT_EQ(snapshot.history.done, saved.history.last.done);
    EXPECT_EQ(snapshot.history.undone, saved.history.last.undone);
}

TEST(EditorRecovery, WithoutUndoStillReplaysTheUndosThatHappened) {
    Lived lived(HeightPrecision::bits32, kPlenty);
    lived.live(23, 25);
    ASSERT_TRUE(std::any_of(lived.edits.begin(), lived.edits.end(),
                            [](const Edit& edit) { return edit.kind == EditKind::Undo; }));
    Ground ground = lived.saves.front().ground;
    Editor editor(ground, nullptr, 0);
    RecoveredWorld recovered = lived.saves.front().recovered(lived.edits);
    ASSERT_TRUE(editor.recover(recovered).ok());
    apply_queue(editor, ground);
    EXPECT_EQ(ground.hash(), lived.states.back());
    EXPECT_EQ(editor.history().bytes(), 0u);
    EXPECT_FALSE(editor.undo().ok());
    ASSERT_TRUE(editor.stamp(dent()).ok());
    EXPECT_EQ(editor.take_queue().front().stroke, nullptr);
}

TEST(EditorRecovery, AnEditThatDoesNotFitIsNamedAndThoseBeforeItAreKept) {
    Lived lived(HeightPrecision::bits32, kPlenty);
    for (int i = 0; i < 3; ++i) {
        const Result<StampRecord> record = lived.editor.stamp(dent(10 + i));
        ASSERT_TRUE(record.ok());
        lived.edits.push_back({.record = *record});
        lived.settle();
    }
    lived.turn(EditKind::Undo, lived.editor.history().done().back());
    const auto refused = [&](const std::vector<Edit>& edits, std::size_t queued) {
        Ground ground = lived.saves.front().ground;
        Editor editor(ground, nullptr, kPlenty);
        RecoveredWorld recovered = lived.saves.front().recovered(edits);
        const Result<void> done = editor.recover(recovered);
        EXPECT_FALSE(done.ok());
        EXPECT_EQ(editor.take_queue().size(), queued);
        return done.ok() ? std::string() : done.error().message;
    };
    std::vector<Edit> edits = lived.edits;
    edits[1].record.shape = 77;
    EXPECT_NE(refused(edits, 1).find("edit 2 of the journal: shape: 77"), std::string::npos) << refused(edits, 1);
    edits = lived.edits;
    edits[3].record.sequence = 2;
    EXPECT_NE(refused(edits, 3).find("edit 4"), std::string::npos) << refused(edits, 3);
    edits = lived.edits;
    edits[3].kind = EditKind::Redo;
    EXPECT_NE(refused(edits, 3).find("edit 4"), std::string::npos) << refused(edits, 3);
    edits = lived.edits;
    edits.erase(edits.begin(), edits.begin() + 3);
    EXPECT_NE(refused(edits, 0).find("edit 1"), std::string::npos) << refused(edits, 0);
}

TEST(EditorRecovery, NumbersGoOnBehindThoseThatWereUsed) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    Editor editor(*ground, nullptr, kPlenty);
    RecoveredWorld recovered;
    recovered.next_sequence = 40;
    recovered.next_stroke = 7;
    ASSERT_TRUE(editor.recover(recovered).ok());
    EXPECT_EQ(editor.stamp(dent())->sequence, 40u);
    EXPECT_EQ(editor.history().done().back()->number, 7u);
}

TEST(EditorRecovery, RefusesAHistoryThatCannotBeUndone) {
    const auto ground = test::small_world(HeightPrecision::bits32);
    const StampRecord good = *ground->issue(dent());
    const auto refused = [&](const auto& spoil) {
        Editor editor(*ground, nullptr, kPlenty);
        RecoveredWorld recovered;
        recovered.next_stroke = 6;
        recovered.done.push_back(std::make_shared<Stroke>());
        recovered.done.back()->number = 5;
        recovered.done.back()->records = {good};
        spoil(*recovered.done.back());
        return contains(editor.recover(recovered), "stroke 5");
    };
    EXPECT_FALSE(refused([](Stroke&) {}));
    EXPECT_TRUE(refused([](Stroke& stroke) { stroke.records.clear(); }));
    EXPECT_TRUE(refused([](Stroke& stroke) { stroke.records[0].shape = 1000; }));
    EXPECT_TRUE(refused([](Stroke& stroke) { stroke.coarse[{0, 0}] = nullptr; }));
}

}  // namespace
}  // namespace tilth
