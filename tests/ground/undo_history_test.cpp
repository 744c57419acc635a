// The lists of strokes: what can be undone, what is forgotten when, and what it all costs.
#include "tilth/ground/undo_history.h"

#include <gtest/gtest.h>

#include <random>

namespace tilth {
namespace {

StampRecord numbered(std::uint64_t sequence) { return {.sequence = sequence}; }

std::shared_ptr<const PageCodes> page() { return std::make_shared<const PageCodes>(PageCodes{}); }

/// `count` strokes of one stamp and one image each.
UndoHistory history_of(int count, std::uint64_t bound) {
    UndoHistory history(bound);
    for (int i = 1; i <= count; ++i)
        history.add(numbered(static_cast<std::uint64_t>(i)), true).stroke->keep_image(MapKind::Detail, {i, 0}, page());
    return history;
}

std::uint64_t sum_of_bytes(const UndoHistory& history) {
    std::uint64_t sum = 0;
    for (const StrokePtr& stroke : history.done()) sum += stroke->bytes();
    for (const StrokePtr& stroke : history.undone()) sum += stroke->bytes();
    return sum;
}

TEST(UndoHistory, IsLastInFirstOut) {
    UndoHistory history(1u << 20);
    history.add(numbered(1), true);
    const GroundEdit second = history.add(numbered(2), false);
    history.add(numbered(3), true);
    EXPECT_EQ(second.position, 1u);
    EXPECT_EQ(history.undoable(), 2u);
    EXPECT_EQ((*history.undo())->records, std::vector{numbered(3)});
    EXPECT_EQ((*history.undo())->records, (std::vector{numbered(1), numbered(2)}));
    EXPECT_FALSE(history.undo().ok());
    EXPECT_EQ(history.redoable(), 2u);
    EXPECT_EQ(*history.redo(), second.stroke);
    EXPECT_EQ((*history.redo())->records, std::vector{numbered(3)});
    EXPECT_FALSE(history.redo().ok());
}

TEST(UndoHistory, WhatIsUndoneIsForgottenWithTheNextStamp) {
    UndoHistory history = history_of(3, 1u << 20);
    const StrokePtr last = *history.undo();
    ASSERT_FALSE(last->forgotten);
    history.add(numbered(4), true);
    EXPECT_EQ(history.redoable(), 0u);
    EXPECT_FALSE(history.redo().ok());
    EXPECT_TRUE(last->forgotten);
    EXPECT_TRUE(last->records.empty() && last->detail.empty());
    EXPECT_EQ(history.undoable(), 3u);
    EXPECT_EQ(history.next_number(), 5u);  // numbers are not used twice
}

TEST(UndoHistory, UndoingRecordsAreTheAddsBackwardsAndNegated) {
    Stroke stroke;
    StampRecord digs{.sequence = 1, .negative = 1}, sets{.sequence = 2, .rule = StampRule::Set}, heaps{.sequence = 3};
    for (const StampRecord& record : {digs, sets, heaps}) stroke.append(record);
    digs.negative = 0, heaps.negative = 1;
    EXPECT_EQ(undoing_records(stroke), (std::vector{heaps, digs}));
}

TEST(UndoHistory, TheFirstImageOfAPageStays) {
    Stroke stroke;
    const auto first = page();
    stroke.keep_image(MapKind::Coarse, {1, 2}, first);
    const std::uint64_t version = stroke.version;
    stroke.keep_image(MapKind::Coarse, {1, 2}, page());
    EXPECT_EQ(stroke.coarse.at({1, 2}), first);
    EXPECT_EQ(stroke.version, version);
    stroke.keep_image(MapKind::Detail, {1, 2}, nullptr);  // another map
    EXPECT_GT(stroke.version, version);
    EXPECT_EQ(stroke.detail.at({1, 2}), nullptr);
}

TEST(UndoHistory, ForgetsTheOldestFirstAndRefusesToGoThere) {
    const std::uint64_t one = history_of(1, 1u << 20).bytes();
    EXPECT_GE(one, sizeof(PageCodes) + sizeof(StampRecord));
    UndoHistory history = history_of(10, 4 * one);
    EXPECT_EQ(history.bytes(), 10 * one);  // until it is trimmed
    history.trim();
    EXPECT_EQ(history.bytes(), 4 * one);
    EXPECT_EQ(history.undoable(), 4u);
    for (std::uint64_t sequence = 10; sequence > 6; --sequence)
        EXPECT_EQ((*history.undo())->records.front().sequence, sequence);
    const Result<StrokePtr> refused = history.undo();
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(refused.error().message.find("0 strokes"), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find("6 older ones"), std::string::npos) << refused.error().message;
    EXPECT_EQ(history.redoable(), 4u);
}

TEST(UndoHistory, StrokesToRedoGoLastTheFarthestFirst) {
    const std::uint64_t one = history_of(1, 1u << 20).bytes();
    UndoHistory history = history_of(5, 2 * one);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(history.undo().ok());  // 3 is redone first, 5 last
    history.trim();
    EXPECT_EQ(history.undoable(), 0u);
    ASSERT_EQ(history.redoable(), 2u);
    EXPECT_EQ((*history.redo())->number, 3u);
    EXPECT_EQ((*history.redo())->number, 4u);
}

TEST(UndoHistory, AStrokeThatOutgrowsTheBoundIsRefusedWhole) {
    UndoHistory history(1000);
    const GroundEdit first = history.add(numbered(1), true);
    first.stroke->keep_image(MapKind::Detail, {}, page());
    history.trim();
    EXPECT_TRUE(first.stroke->forgotten);
    // Its later stamps alone must not be undone.
    EXPECT_EQ(history.add(numbered(2), false).stroke, nullptr);
    EXPECT_FALSE(history.undo().ok());
    EXPECT_NE(history.add(numbered(3), true).stroke, nullptr);  // the next stroke can
    EXPECT_EQ(history.undoable(), 1u);
}

TEST(UndoHistory, ABoundOfZeroKeepsNothingButWhatIsReplayed) {
    UndoHistory history(0);
    EXPECT_EQ(history.add(numbered(1), true).stroke, nullptr);
    EXPECT_FALSE(history.undo().ok());
    EXPECT_EQ(history.bytes(), 0u);
    history.set_replaying(true);
    EXPECT_NE(history.add(numbered(2), true).stroke, nullptr);
    history.trim();
    EXPECT_TRUE(history.undo().ok());
    EXPECT_TRUE(history.redo().ok());
    history.set_replaying(false);
    history.trim();
    EXPECT_FALSE(history.undo().ok());
    EXPECT_EQ(history.bytes(), 0u);
}

TEST(UndoHistory, AnUndoOnItsWayKeepsWhatItNeeds) {
    UndoHistory history = history_of(1, 1u << 20);
    const StrokePtr stroke = *history.undo();
    {
        GroundEdit edit = undo_edit(stroke);
        history.add(numbered(2), true);  // the stroke leaves the history ...
        EXPECT_EQ(history.find(1), nullptr);
        EXPECT_EQ(history.bytes(), sum_of_bytes(history));
        EXPECT_FALSE(stroke->forgotten);  // ... and stays for the edit
        EXPECT_EQ(stroke->detail.size(), 1u);
        const GroundEdit copy = edit;
        edit = {};
        EXPECT_FALSE(stroke->forgotten);
        stroke->keep_image(MapKind::Detail, {7, 7}, page());  // of a stamp that waited until now
        EXPECT_EQ(stroke->detail.size(), 2u);
    }
    EXPECT_TRUE(stroke->forgotten);
    EXPECT_TRUE(stroke->detail.empty());
    EXPECT_EQ(history.bytes(), sum_of_bytes(history));
}

TEST(UndoHistory, AnUndoThatArrivesForgetsNothingByItself) {
    UndoHistory history = history_of(2, 1u << 20);
    const StrokePtr stroke = *history.undo();
    undo_edit(stroke);
    EXPECT_FALSE(stroke->forgotten);
    EXPECT_EQ(*history.redo(), stroke);
}

TEST(UndoHistory, FindsByNumberInBothLists) {
    UndoHistory history = history_of(6, 1u << 20);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(history.undo().ok());
    for (std::uint64_t number = 1; number <= 6; ++number) {
        ASSERT_NE(history.find(number), nullptr) << number;
        EXPECT_EQ(history.find(number)->number, number);
    }
    EXPECT_EQ(history.find(0), nullptr);
    EXPECT_EQ(history.find(7), nullptr);
}

TEST(UndoHistory, RestoredListsGoOnWhereTheyWere) {
    UndoHistory history = history_of(5, 1u << 20);
    ASSERT_TRUE(history.undo().ok() && history.undo().ok());
    const auto copies = [](const auto& strokes) {
        std::vector<StrokePtr> made;
        for (const StrokePtr& stroke : strokes) {
            made.push_back(std::make_shared<Stroke>());
            made.back()->number = stroke->number;
            made.back()->records = stroke->records;
            made.back()->detail = stroke->detail;
        }
        return made;
    };
    UndoHistory restored(1u << 20);
    restored.add(numbered(99), true);
    restored.restore(copies(history.done()), copies(history.undone()), history.next_number());
    EXPECT_EQ(restored.bytes(), history.bytes());
    EXPECT_EQ(restored.next_number(), 6u);
    EXPECT_EQ((*restored.redo())->number, 4u);
    EXPECT_EQ((*restored.undo())->number, 4u);
    EXPECT_EQ((*restored.undo())->number, 3u);
    EXPECT_EQ(restored.undoable(), 2u);
}

// The sum that `trim` relies on is kept up by every operation; counted afresh it is the same.
TEST(UndoHistory, BytesAreThoseOfItsStrokes) {
    std::mt19937 random(5);
    UndoHistory history(300'000);
    std::vector<GroundEdit> on_their_way;
    std::size_t forgotten = 0;
    for (std::uint64_t i = 1; i < 3000; ++i) {
        switch (random() % 6) {
            case 0:
                if (const Result<StrokePtr> stroke = history.undo()) on_their_way.push_back(undo_edit(*stroke));
                break;
            case 1:
                if (history.redoable() > 0) {
                    ASSERT_TRUE(history.redo().ok());
                }
                break;
            case 2: {
                const std::size_t before = history.undoable() + history.redoable();
                history.trim();
                forgotten += before - history.undoable() - history.redoable();
                ASSERT_LE(history.bytes(), 300'000u);
                break;
            }
            case 3:
                if (!on_their_way.empty()) on_their_way.erase(on_their_way.begin());
                break;
            default: {
                const GroundEdit edit = history.add(numbered(i), random() % 3 != 0);
                if (edit.stroke != nullptr && random() % 2 == 0)
                    edit.stroke->keep_image(random() % 2 == 0 ? MapKind::Coarse : MapKind::Detail,
                                            {static_cast<int>(random() % 9), 0}, random() % 3 == 0 ? nullptr : page());
            }
        }
        ASSERT_EQ(history.bytes(), sum_of_bytes(history)) << "step " << i;
    }
    EXPECT_GT(forgotten, 100u);
}

}  // namespace
}  // namespace tilth
