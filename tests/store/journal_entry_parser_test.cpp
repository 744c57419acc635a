// Journal entries: every field comes back, and nothing that is not exactly an entry is taken for one.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "store/journal_support.h"
#include "tilth/store/journal_entry.h"

namespace tilth {
namespace {

using test::kSalt;

Edit full_stamp() {
    Edit edit{.kind = EditKind::Stamp, .begins_stroke = true, .record = {}};
    edit.record = {.sequence = 0x0807060504030201,
                   .centre_x = 0x1817161514131211,
                   .centre_z = -0x2827262524232221,
                   .shape_hash = 0x3837363534333231,
                   .shape = 0x44434241,
                   .radius = 0x54535251,
                   .amplitude = 0x64636261,
                   .level = 0x74737271,
                   .rotation = 0x84838281,
                   .key = 0x94939291,
                   .map = MapKind::Detail,
                   .rule = StampRule::Set,
                   .negative = 1,
                   .mirror = 0,
                   .reserved = 0};
    return edit;
}

/// The checksum as FORMATS.md says it, by its own formula.
void seal(JournalBytes& bytes, std::uint64_t number) {
    const auto sum =
        static_cast<std::uint32_t>(XXH3_64bits_withSeed(bytes.data(), 60, kSalt + number * 11400714819323198485ull));
    std::memcpy(bytes.data() + 60, &sum, 4);
}

TEST(JournalEntry, EveryFieldComesBack) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
    std::mt19937_64 random(3);
    for (int i = 0; i < 2000; ++i) {
        const Edit edit = test::random_edit(random);
        const std::uint64_t number = random();
        const std::optional<Edit> back = decode_entry(encode_entry(edit, number, kSalt), number, kSalt);
        ASSERT_TRUE(back.has_value());
        ASSERT_EQ(*back, edit);
    }
    for (const EditKind kind : {EditKind::Stamp, EditKind::Undo, EditKind::Redo})
        for (const bool begins : {false, true})
            for (const std::uint64_t sequence : {std::uint64_t{0}, std::uint64_t{1}, kMost}) {
                Edit edit{.kind = kind, .begins_stroke = begins, .record = {}};
                edit.record.sequence = sequence;
                EXPECT_EQ(decode_entry(encode_entry(edit, 1, 0), 1, 0), edit);
            }
}

// The bytes of FORMATS.md, written out.
TEST(JournalEntry, FieldsLieWhereTheFormatSays) {
    const unsigned char expected[60] = {
        0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08,  // sequence
        0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0x17, 0x18,  // centre_x
        0xdf, 0xdd, 0xdc, 0xdb, 0xda, 0xd9, 0xd8, 0xd7,  // centre_z, two's complement
        0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38,  // shape_hash
        0x41, 0x42, 0x43, 0x44, 0x51, 0x52, 0x53, 0x54,  // shape, radius
        0x61, 0x62, 0x63, 0x64, 0x71, 0x72, 0x73, 0x74,  // amplitude, level
        0x81, 0x82, 0x83, 0x84, 0x91, 0x92, 0x93, 0x94,  // rotation, key
        1,    3,    5,    1,                             // detail, set, negative + begins a stroke, stamp
    };
    const JournalBytes bytes = encode_entry(full_stamp(), 7, kSalt);
    EXPECT_EQ(std::memcmp(bytes.data(), expected, sizeof expected), 0);
    JournalBytes sealed = bytes;
    seal(sealed, 7);
    EXPECT_EQ(bytes, sealed);
}

TEST(JournalEntry, EveryFlippedBitIsRefused) {
    std::vector<Edit> edits = test::random_edits(8);
    edits.push_back(full_stamp());
    edits.push_back({.kind = EditKind::Undo, .begins_stroke = false, .record = {}});
    for (const Edit& edit : edits) {
        const JournalBytes good = encode_entry(edit, 12, kSalt);
        for (std::size_t bit = 0; bit < 512; ++bit) {
            JournalBytes bytes = good;
            bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
            ASSERT_FALSE(decode_entry(bytes, 12, kSalt).has_value()) << "bit " << bit;
        }
    }
}

TEST(JournalEntry, AnotherPlaceOrWorldIsRefused) {
    const JournalBytes bytes = encode_entry(full_stamp(), 100, kSalt);
    EXPECT_TRUE(decode_entry(bytes, 100, kSalt).has_value());
    for (std::uint64_t number = 0; number < 4096; ++number)
        if (number != 100) {
            ASSERT_FALSE(decode_entry(bytes, number, kSalt).has_value()) << number;
            ASSERT_FALSE(decode_entry(bytes, 100, kSalt + number + 1).has_value()) << number;
        }
}

TEST(JournalEntry, WhatWasNeverWrittenIsRefused) {
    for (const int fill : {0x00, 0xff, 0xaa}) {
        JournalBytes bytes{};
        bytes.fill(static_cast<std::byte>(fill));
        for (std::uint64_t number = 0; number < 1000; ++number)
            ASSERT_FALSE(decode_entry(bytes, number, kSalt).has_value());
    }
    // All zeros are no entry whatever the checksum is: the kind says so.
    JournalBytes zeros{};
    seal(zeros, 1);
    EXPECT_FALSE(decode_entry(zeros, 1, kSalt).has_value());
    std::mt19937_64 random(4);
    for (int i = 0; i < 100'000; ++i) {
        JournalBytes bytes{};
        for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
        ASSERT_FALSE(decode_entry(bytes, 1, kSalt).has_value());
    }
}

// With a checksum that is right, so that the fields alone decide.
TEST(JournalEntry, ValuesThatDoNotExistAreRefused) {
    const JournalBytes stamp = encode_entry(full_stamp(), 5, kSalt);
    const JournalBytes undo =
        encode_entry({.kind = EditKind::Undo, .begins_stroke = false, .record = {.sequence = 9}}, 5, kSalt);
    const auto with = [](JournalBytes bytes, std::size_t at, int value) {
        bytes[at] = static_cast<std::byte>(value);
        seal(bytes, 5);
        return decode_entry(bytes, 5, kSalt);
    };
    for (int value = 0; value < 256; ++value) {
        EXPECT_EQ(with(stamp, 56, value).has_value(), value <= 1) << "map " << value;
        EXPECT_EQ(with(stamp, 57, value).has_value(), value <= 4) << "rule " << value;
        EXPECT_EQ(with(stamp, 58, value).has_value(), value <= 7) << "flags " << value;
        EXPECT_EQ(with(stamp, 59, value).has_value(), value == 1) << "kind " << value;  // the rest has no fields
        EXPECT_EQ(with(undo, 59, value).has_value(), value >= 1 && value <= 3) << "kind " << value;
        EXPECT_EQ(with(undo, 58, value).has_value(), value == 0 || value == 4) << "flags of undo " << value;
    }
    for (std::size_t at = 8; at < 58; ++at) EXPECT_FALSE(with(undo, at, 1).has_value()) << "byte " << at << " of undo";
}

}  // namespace
}  // namespace tilth
