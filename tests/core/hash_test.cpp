#include "tilth/core/hash.h"

#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstring>
#include <vector>

namespace tilth {
namespace {

// XXH3-64 of nothing, seed 0: the specification's value.
constexpr std::uint64_t kHashOfNothing = 0x2d06800538d394c2u;

TEST(Hash, OfNothingIsTheSpecifiedValue) {
    EXPECT_EQ(hash_bytes({}), kHashOfNothing);
    EXPECT_EQ(StateHasher().digest(), kHashOfNothing);
}

// Lengths on both sides of XXH3's branches (16, 128, 240) and of its 256-byte buffer, fed in uneven pieces.
TEST(Hash, StreamingIsTheHashOfTheLittleEndianBytes) {
    for (const std::size_t words : {1u, 3u, 4u, 5u, 31u, 33u, 59u, 61u, 63u, 65u, 4096u, 100003u}) {
        std::vector<std::uint32_t> values(words);
        for (std::size_t i = 0; i < words; ++i) values[i] = static_cast<std::uint32_t>(i * 2654435761u + words);
        std::vector<std::byte> bytes;
        for (const std::uint32_t value : values)
            for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::byte>(value >> shift));
        const std::int64_t last = -0x0123456789abcdef;
        for (int shift = 0; shift < 64; shift += 8)
            bytes.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(last) >> shift));

        StateHasher hasher;
        const std::span<const std::uint32_t> all = values;
        for (std::size_t at = 0, piece = 1; at < words; at += piece, piece = piece * 3 + 1)
            hasher.add_u32(all.subspan(at, std::min(piece, words - at)));
        hasher.add_i64(last);
        EXPECT_EQ(hasher.digest(), XXH3_64bits(bytes.data(), bytes.size())) << words;
        EXPECT_EQ(hash_bytes(bytes), XXH3_64bits(bytes.data(), bytes.size())) << words;
    }
}

TEST(Hash, HexHasSixteenDigits) {
    EXPECT_EQ(hex16(0), "0000000000000000");
    EXPECT_EQ(hex16(0x0123456789abcdefu), "0123456789abcdef");
    EXPECT_EQ(hex16(~std::uint64_t{0}), "ffffffffffffffff");
    EXPECT_EQ(hex16(kHashOfNothing), "2d06800538d394c2");
}

}  // namespace
}  // namespace tilth
