// Counters, waiting stamps and strokes as bytes: there and back, and what is made of rubbish.
#include "tilth/store/world_blobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

using Bytes = std::vector<std::byte>;

StampRecord record(SplitMix64& random) {
    return {.sequence = random.next(),
            .centre_x = static_cast<std::int64_t>(random.next()),
            .centre_z = static_cast<std::int64_t>(random.next()),
            .shape_hash = random.next(),
            .shape = static_cast<std::uint32_t>(random.next()),
            .radius = static_cast<std::uint32_t>(random.next()),
            .amplitude = static_cast<std::uint32_t>(random.next()),
            .level = static_cast<std::uint32_t>(random.next()),
            .rotation = static_cast<std::uint32_t>(random.next()),
            .key = static_cast<std::uint32_t>(random.next()),
            .map = MapKind::Detail,
            .rule = static_cast<StampRule>(random.next() % 4),
            .negative = static_cast<std::uint8_t>(random.next() % 2),
            .mirror = static_cast<std::uint8_t>(random.next() % 2)};
}

std::shared_ptr<const PageCodes> page(SplitMix64& random) {
    auto codes = std::make_shared<PageCodes>();
    for (std::uint32_t& code : *codes) code = static_cast<std::uint32_t>(random.next());
    return codes;
}

Stroke stroke(SplitMix64& random, int records, int images) {
    Stroke made{.number = 1 + random.next() % kMostStrokeNumber, .version = random.next()};
    for (int i = 0; i < records; ++i) made.records.push_back(record(random));
    for (int i = 0; i < images; ++i) {
        made.detail[{i - 3, i * 7}] = i % 5 == 0 ? nullptr : page(random);
        if (i % 3 == 0) made.coarse[{i, -i}] = page(random);
    }
    return made;
}

bool same_images(const Stroke::Images& a, const Stroke::Images& b) {
    return std::ranges::equal(a, b, [](const auto& x, const auto& y) {
        return x.first == y.first && (x.second == nullptr) == (y.second == nullptr) &&
               (x.second == nullptr || *x.second == *y.second);
    });
}

TEST(WorldBlobs, CountersAreReadAsTheyWereWritten) {
    for (const WorldCounters& counters :
         {WorldCounters{},
          WorldCounters{.next_sequence = ~0ull, .next_stroke = 100, .done = {1, 5, 7}, .undone = {99, 8}},
          WorldCounters{.next_sequence = 7, .next_stroke = kMostStrokeNumber + 1, .done = {kMostStrokeNumber}}}) {
        const auto read = decode_counters(encode_counters(counters), "here");
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(*read, counters);
    }
}

TEST(WorldBlobs, CountersThatContradictThemselvesAreRefused) {
    for (const WorldCounters& counters :
         {WorldCounters{.next_stroke = 3, .done = {3}}, WorldCounters{.done = {0}},
          WorldCounters{.next_stroke = 9, .done = {2, 2}}, WorldCounters{.next_stroke = 9, .undone = {2, 4}}}) {
        const auto read = decode_counters(encode_counters(counters), "here");
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().code, ErrorCode::FileFormat);
        EXPECT_TRUE(read.error().message.starts_with("here")) << read.error().message;
    }
}

TEST(WorldBlobs, WaitingStampsAreReadAsTheyWereWritten) {
    SplitMix64 random{1};
    std::vector<WaitingStamp> stamps;
    for (int i = 0; i < 100; ++i)
        stamps.push_back({record(random), random.next(), static_cast<std::uint32_t>(random.next())});
    const auto read = decode_waiting(encode_waiting(stamps), "here");
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->size(), stamps.size());
    for (std::size_t i = 0; i < stamps.size(); ++i) {
        EXPECT_EQ((*read)[i].record, stamps[i].record);
        EXPECT_EQ((*read)[i].stroke, stamps[i].stroke);
        EXPECT_EQ((*read)[i].position, stamps[i].position);
    }
    stamps[7].record.rule = StampRule::Smooth;  // reads its neighbours, and cannot wait for one tile
    EXPECT_FALSE(decode_waiting(encode_waiting(stamps), "here"));
}

TEST(WorldBlobs, StrokesAreReadAsTheyWereWritten) {
    SplitMix64 random{2};
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16})
        for (const int images : {0, 1, 20}) {
            Stroke made = stroke(random, 1 + images, images);
            if (precision == HeightPrecision::bits16)
                for (Stroke::Images* list : {&made.coarse, &made.detail})
                    for (auto& [index, codes] : *list)
                        if (codes != nullptr) {
                            auto rounded = std::make_shared<PageCodes>(*codes);
                            for (std::uint32_t& code : *rounded) code &= 0xffff'0000u;
                            codes = rounded;
                        }
            const auto read = decode_stroke(encode_stroke(made, precision), made.number, "here");
            ASSERT_TRUE(read) << read.error().message;
            EXPECT_EQ((*read)->number, made.number);
            EXPECT_EQ((*read)->version, made.version);
            EXPECT_EQ((*read)->records, made.records);
            EXPECT_TRUE(same_images((*read)->coarse, made.coarse));
            EXPECT_TRUE(same_images((*read)->detail, made.detail));
        }
}

TEST(WorldBlobs, LargeStrokesHaveSeveralParts) {
    SplitMix64 random{3};
    const Stroke made = stroke(random, 140'000, 900);  // 9 MB of records; random pages do not compress: 20 MB
    auto parts = encode_stroke(made, HeightPrecision::bits32);
    ASSERT_GE(parts.size(), 4u);
    for (const Bytes& part : parts) EXPECT_LT(part.size(), 20u << 20);
    EXPECT_EQ(*parts_of_stroke(parts[0], "here"), parts.size());
    const auto read = decode_stroke(parts, made.number, "here");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ((*read)->records, made.records);
    EXPECT_TRUE(same_images((*read)->coarse, made.coarse));
    EXPECT_TRUE(same_images((*read)->detail, made.detail));

    EXPECT_FALSE(decode_stroke(parts, made.number + 1, "here")) << "parts of another stroke";
    std::swap(parts[0], parts[1]);
    EXPECT_FALSE(decode_stroke(parts, made.number, "here")) << "out of order";
    std::swap(parts[0], parts[1]);
    parts.pop_back();
    EXPECT_FALSE(decode_stroke(parts, made.number, "here")) << "one is missing";
}

/// Every cut, and many flips: an error, or what was written (a bit that means nothing).
void expect_no_surprise(const Bytes& good, const std::function<bool(const Bytes&)>& is_refused_or_right) {
    for (std::size_t size = 0; size < good.size(); size += 1 + size / 64)
        EXPECT_TRUE(is_refused_or_right(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))))
            << "cut at " << size;
    SplitMix64 random{4};
    for (int i = 0; i < 2000; ++i) {
        Bytes bad = good;
        for (std::uint64_t flips = 1 + random.next() % 3; flips > 0; --flips) {
            const std::uint64_t bit = random.next() % (8 * bad.size());
            bad[bit / 8] ^= std::byte{static_cast<unsigned char>(1u << (bit % 8))};
        }
        EXPECT_TRUE(is_refused_or_right(bad)) << "flips, round " << i;
    }
    Bytes longer = good;
    longer.push_back(std::byte{0});
    EXPECT_TRUE(is_refused_or_right(longer));
}

TEST(WorldBlobs, DamageIsNoticed) {
    const WorldCounters counters{.next_sequence = 12, .next_stroke = 20, .done = {1, 2, 3, 9}, .undone = {15, 4}};
    expect_no_surprise(encode_counters(counters), [&](const Bytes& bytes) {
        const auto read = decode_counters(bytes, "here");
        return !read || *read == counters;
    });
    SplitMix64 random{5};
    const std::vector<WaitingStamp> stamps{{record(random), 1, 2}, {record(random), 3, 4}};
    expect_no_surprise(encode_waiting(stamps), [&](const Bytes& bytes) {
        const auto read = decode_waiting(bytes, "here");
        return !read || (read->size() == 2 && (*read)[0].record == stamps[0].record &&
                         (*read)[1].record == stamps[1].record && (*read)[1].stroke == 3);
    });
    // A stroke's own header has no checksum of its own: the store's covers the blob. It must not crash or overrun.
    const Stroke made = stroke(random, 3, 4);
    expect_no_surprise(encode_stroke(made, HeightPrecision::bits32)[0], [&](const Bytes& bytes) {
        const auto read = decode_stroke({&bytes, 1}, made.number, "here");
        return !read || (*read)->records == made.records;
    });
}

}  // namespace
}  // namespace tilth
