// The state hash as ground.h defines it, laid out here byte by byte and hashed in one go.
#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <tuple>

#include "ground/support.h"
#include "tilth/core/hash.h"

namespace tilth {
namespace {

std::uint64_t hash_of(const std::vector<unsigned char>& bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

void put(std::vector<unsigned char>& bytes, std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes.push_back(static_cast<unsigned char>(value >> (8 * i)));
}

StateHash by_definition(const Ground& ground) {
    std::vector<unsigned char> coarse, detail;
    const GridSpec& posts = ground.map(MapKind::Coarse).grid;
    for (int z = 0; z < posts.depth; ++z)
        for (int x = 0; x < posts.width; ++x) put(coarse, ground.coarse_code({x, z}), 4);
    const GridSpec& texels = ground.map(MapKind::Detail).grid;
    const int tile = ground.settings().tile_size;
    for (int tile_z = 0; tile_z * tile < texels.depth; ++tile_z)
        for (int tile_x = 0; tile_x * tile < texels.width; ++tile_x)
            for (int page_z = 0; page_z < tile / 64; ++page_z)
                for (int page_x = 0; page_x < tile / 64; ++page_x) {
                    std::vector<unsigned char> page;
                    for (const int index : {tile_z, tile_x, page_z, page_x})
                        put(page, static_cast<std::uint64_t>(index), 8);
                    bool zero = true;
                    for (int z = 0; z < 64; ++z)
                        for (int x = 0; x < 64; ++x) {
                            const std::uint32_t code = ground.detail().code(
                                {tile_x * tile + page_x * 64 + x, tile_z * tile + page_z * 64 + z});
                            zero = zero && code == 0x80000000u;
                            put(page, code, 4);
                        }
                    if (!zero) detail.insert(detail.end(), page.begin(), page.end());
                }
    return {hash_of(coarse), hash_of(detail)};
}

TEST(StateHash, IsTheHashOfTheDefinedBytes) {
    for (const HeightPrecision precision : test::kBothPrecisions)
        for (const int tile : {64, 128, 192}) {
            auto ground = test::flat_ground(150, {.tile_size = tile, .precision = precision});
            EXPECT_EQ(ground->hash().detail, 0x2d06800538d394c2u);  // of nothing
            EXPECT_EQ(ground->hash(), by_definition(*ground));
            std::mt19937 random(22);
            for (int i = 0; i < 30; ++i)
                test::stamp(*ground, {.shape = {static_cast<std::uint32_t>(random() % 6)},
                                      .centre = {random() % 150 + 0.3, random() % 150 + 0.6},
                                      .radius_m = 1 + random() % 12 * 1.0,
                                      .amplitude_m = 0.1});
            EXPECT_EQ(ground->hash(), by_definition(*ground)) << "tile " << tile;
        }
}

TEST(StateHash, PagesThatAreAllZeroDoNotCount) {
    auto ground = test::flat_ground(65);
    const StateHash untouched = ground->hash();
    StampRequest request{.shape = {0}, .centre = {30, 30}, .radius_m = 3, .amplitude_m = 0, .map = MapChoice::Detail};
    test::stamp(*ground, request);
    EXPECT_FALSE(ground->detail().pages().empty());
    EXPECT_EQ(ground->hash(), untouched);
    request.amplitude_m = 0.25;
    const StampRecord record = test::issued(*ground, request);
    ground->apply(record);
    EXPECT_NE(ground->hash().detail, untouched.detail);
    EXPECT_EQ(ground->hash().coarse, untouched.coarse);
    ground->apply(negated(record));
    EXPECT_EQ(ground->hash(), untouched);
}

// S17: a hash per kind of stamp, kept. The right answers are asked for in the other tests; this one notices that a
// change of arithmetic breaks the logs of worlds that exist. Changing a value here needs a new version of the record.
TEST(StateHash, OfOldStampsStaysWhatItWas) {
    std::vector<std::string> got;
    for (std::uint32_t shape = 0; shape < 8; ++shape)
        for (const HeightPrecision precision : test::kBothPrecisions) {
            auto ground = test::flat_ground(33, {.precision = precision});
            std::vector<std::uint16_t> texels;
            for (int i = 0; i < 35; ++i) texels.push_back(static_cast<std::uint16_t>(i * 1800));
            ASSERT_TRUE(ground->shapes().add_image("image", 7, 5, texels).ok());
            ASSERT_TRUE(ground->shapes().add_profile("profile", [](double t) { return 1 - t * t * t; }).ok());
            for (int rule = 0; rule < 5; ++rule)
                test::stamp(*ground, {.shape = {shape},
                                      .centre = {16.3 + rule, 15.9},
                                      .radius_m = 1.75 + rule,
                                      .amplitude_m = rule == 1 ? -0.4 : 0.4,
                                      .map = MapChoice::Detail,
                                      .rule = static_cast<StampRule>(rule),
                                      .rotation_rad = 0.75,
                                      .mirror = rule == 2,
                                      .key = 99});
            got.push_back(hex16(ground->hash().detail));
        }
    const std::vector<std::string> kept = {
        // profiles, image, user profile; bits32 and bits16 of each
        "efa3bf2e349576d4", "190b9e0286c5720f", "d9b98968f6675b38", "c4a78ef715f000cd",
        "72fd8197396bf6dc", "edf1d191cff1ca00", "e06ef68f41df0027", "92d60fb3bbd3ad1a",
        "bbd3f6530c068ab4", "9e2ed13b7efb6b65", "c1237dc2ea3e3a3a", "9c8ded29d868dc6e",
        "6e57340b8a46cfb3", "162fcdc0fe6764f6", "1758450606f58cf9", "2f3324643d0d74f5"};
    ASSERT_EQ(got.size(), kept.size()) << testing::PrintToString(got);
    for (std::size_t i = 0; i < got.size(); ++i)
        EXPECT_EQ(got[i], kept[i]) << "shape " << i / 2 << (i % 2 == 0 ? " bits32" : " bits16");
}

}  // namespace
}  // namespace tilth
