// Pages and records as bytes: whatever goes in comes out, and whatever is not what was written is refused.
#include "tilth/store/page_codec.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <thread>

#include "tilth/core/hash.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/source/analytic_sources.h"
#include "tilth/source/ridged_source.h"

namespace tilth {
namespace {

using Bytes = std::vector<std::byte>;
constexpr std::size_t kTexels = std::size_t(kPageTexels) * kPageTexels;
constexpr std::uint64_t kMiB = 1u << 20;
constexpr const char* kWhere = "pages-1.tlp at 4711";

template <class T>
T taken(Result<T> result) {
    EXPECT_TRUE(result.ok()) << result.error().message;
    return *std::move(result);
}

std::uint32_t kept_by(HeightPrecision precision) { return precision == HeightPrecision::bits16 ? 0xffff'0000u : ~0u; }

std::string name_of(HeightPrecision precision) { return precision == HeightPrecision::bits16 ? "bits16" : "bits32"; }

PageCodes random_page(std::uint32_t seed, HeightPrecision precision) {
    std::mt19937 random(seed);
    PageCodes codes;
    for (std::uint32_t& code : codes) code = random() & kept_by(precision);
    return codes;
}

PageCodes uniform_page(std::uint32_t code) {
    PageCodes codes;
    codes.fill(code);
    return codes;
}

/// Pages as stamps leave them: a few on otherwise flat ground, many over each other; and mountains.
std::vector<PageCodes> realistic_pages(HeightPrecision precision) {
    std::vector<PageCodes> pages;
    for (const std::int64_t count : {30, 3000}) {
        auto ground = taken(Ground::create(std::make_unique<FlatSource>(65, 10.0), {.origin = {},
                                                                                    .spacing_m = 0.1,
                                                                                    .quantum_m = {},
                                                                                    .texels_per_post = 3,
                                                                                    .tile_size = 64,
                                                                                    .precision = precision}));
        RandomStamps stamps;
        stamps.seed = 3;
        stamps.count = count;
        stamps.region = {WorldPos{0, 0}, WorldPos{6.4, 6.4}};
        stamps.radius_m = {0.1, 0.4};
        stamps.amplitude_m = {-0.1, 0.1};
        stamps.map = MapChoice::Detail;
        for (std::uint32_t shape = 0; shape < kBuiltinProfiles; ++shape) stamps.shapes.push_back({shape});
        stamps.rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth};
        for (const StampRequest& request : random_stamps(stamps, *ground)) ground->apply(taken(ground->issue(request)));
        for (const auto& [index, codes] : ground->detail().pages()) pages.push_back(*codes);
    }
    auto mountains = taken(Ground::create(make_ridged_source({.seed = 2, .size = 129}),
                                          {.origin = {}, .quantum_m = {}, .detail = false, .precision = precision}));
    PageCodes page;
    for (std::int32_t z = 0; z < kPageTexels; ++z)
        std::copy_n(mountains->coarse().row(z + 64) + 64, kPageTexels, page.data() + z * kPageTexels);
    pages.push_back(page);
    return pages;
}

/// A page of one print, as most are: small on disk.
PageCodes print_page() {
    PageCodes codes = uniform_page(kMidCode);
    for (std::size_t z = 20; z < 30; ++z)
        for (std::size_t x = 31; x < 37; ++x)
            codes[z * kPageTexels + x] -= static_cast<std::uint32_t>(123'457 * (x - 30) * (z - 19));
    return codes;
}

void expect_round_trip(const PageCodes& codes, HeightPrecision precision) {
    const Bytes blob = encode_page(codes, precision);
    EXPECT_LE(blob.size(), 16u * 1024 + 512);
    const auto back = decode_page(blob, kWhere);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(**back, codes);
}

/// Refused with `where` in front, or read as what was written: never as something else.
void expect_refused_or_same(std::span<const std::byte> blob, const PageCodes& codes, std::size_t& refused) {
    const auto back = decode_page(blob, kWhere);
    if (back) {
        EXPECT_EQ(**back, codes);
        return;
    }
    ++refused;
    EXPECT_EQ(back.error().code, ErrorCode::FileFormat);
    EXPECT_EQ(back.error().message.rfind(kWhere, 0), 0u) << back.error().message;
}

// ------------------------------------------------------------------------------ blobs by hand, as FORMATS.md has them

void put(Bytes& bytes, std::uint64_t value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
}

Bytes page_header(int form, int code_bytes, std::uint32_t code, std::uint64_t hash) {
    Bytes bytes;
    put(bytes, 1, 1);
    put(bytes, static_cast<std::uint64_t>(form), 1);
    put(bytes, static_cast<std::uint64_t>(code_bytes), 1);
    put(bytes, 0, 1);
    put(bytes, code, 4);
    put(bytes, hash, 8);
    return bytes;
}

/// A zstd frame (RFC 8878) with one block that is not compressed: content size in eight bytes, single segment.
Bytes plain_frame(std::span<const std::byte> content, std::uint64_t said_size) {
    Bytes bytes;
    put(bytes, 0xFD2FB528u, 4);
    put(bytes, 0xE0, 1);
    put(bytes, said_size, 8);
    put(bytes, content.size() << 3 | 1, 3);
    bytes.insert(bytes.end(), content.begin(), content.end());
    return bytes;
}

Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// Byte planes by the definition, texel by texel, in whole numbers: no word arithmetic.
Bytes gradient_planes(const PageCodes& codes, int code_bytes) {
    const std::int64_t range = std::int64_t{1} << (8 * code_bytes);
    const auto at = [&](int x, int z) -> std::int64_t {
        return x < 0 || z < 0 ? 0 : codes[static_cast<std::size_t>(z * 64 + x)] >> (32 - 8 * code_bytes);
    };
    Bytes planes(kTexels * static_cast<std::size_t>(code_bytes));
    for (int z = 0; z < 64; ++z)
        for (int x = 0; x < 64; ++x) {
            std::int64_t difference = at(x, z) - at(x - 1, z) - at(x, z - 1) + at(x - 1, z - 1);
            difference = ((difference % range) + range) % range;
            if (difference >= range / 2) difference -= range;
            const std::int64_t folded = difference >= 0 ? 2 * difference : -2 * difference - 1;
            for (int b = 0; b < code_bytes; ++b)
                planes[static_cast<std::size_t>(b * 4096 + z * 64 + x)] =
                    static_cast<std::byte>(folded >> (8 * (code_bytes - 1 - b)));
        }
    return planes;
}

Bytes word_bytes(const PageCodes& codes, int code_bytes) {
    Bytes bytes;
    for (const std::uint32_t code : codes) put(bytes, code >> (32 - 8 * code_bytes), code_bytes);
    return bytes;
}

TEST(PageCodec, ReadsBlobsWrittenByHand) {
    for (const int code_bytes : {2, 4}) {
        const auto precision = code_bytes == 2 ? HeightPrecision::bits16 : HeightPrecision::bits32;
        const PageCodes codes = random_page(5, precision);
        const std::uint64_t hash = hash_bytes(std::as_bytes(std::span(codes)));
        for (const int form : {1, 2}) {
            const Bytes content = form == 1 ? word_bytes(codes, code_bytes) : gradient_planes(codes, code_bytes);
            const auto back =
                decode_page(page_header(form, code_bytes, 0, hash) + plain_frame(content, content.size()), kWhere);
            ASSERT_TRUE(back.ok()) << form << " " << code_bytes << ": " << back.error().message;
            EXPECT_EQ(**back, codes) << form << " " << code_bytes;
        }
    }
}

TEST(PageCodec, APageOfOneCodeIsItsHeader) {
    for (const std::uint32_t code : {0u, 1u, kMidCode, 0xffff'ffffu, 0x7fff'0000u})
        for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
            const PageCodes codes = uniform_page(code);
            EXPECT_EQ(encode_page(codes, precision), page_header(0, 0, code, hash_of(codes)));
            expect_round_trip(codes, precision);
        }
}

TEST(PageCodec, ChecksumIsOfTheCodesAsLittleEndianWords) {
    const PageCodes codes = random_page(9, HeightPrecision::bits32);
    StateHasher hasher;
    hasher.add_u32(codes);
    EXPECT_EQ(hash_of(codes), hasher.digest());
}

// ------------------------------------------------------------------------------ round trips

TEST(PageCodec, AnyPageComesBack) {
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
        SCOPED_TRACE(name_of(precision));
        for (std::uint32_t seed = 0; seed < 50; ++seed) expect_round_trip(random_page(seed, precision), precision);
        expect_round_trip(print_page(), precision);
        const std::vector<PageCodes> pages = realistic_pages(precision);
        EXPECT_GE(pages.size(), 10u);
        for (const PageCodes& codes : pages) expect_round_trip(codes, precision);
        // Differences that leave the range in every direction.
        PageCodes extremes = uniform_page(0);
        for (std::size_t i = 0; i < kTexels; ++i)
            if ((i * 2654435761u >> 7 & 1) != 0) extremes[i] = 0xffff'ffffu & kept_by(precision);
        expect_round_trip(extremes, precision);
    }
}

TEST(PageCodec, OneTexelApartFromTheRestIsKept) {
    for (const std::size_t texel : {std::size_t{0}, std::size_t{63}, std::size_t{64}, kTexels - 1}) {
        PageCodes codes = uniform_page(kMidCode);
        codes[texel] ^= 0x10000u;
        for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16})
            expect_round_trip(codes, precision);
    }
}

TEST(PageCodec, LowHalvesComeBackEvenWithBits16) {
    expect_round_trip(random_page(1, HeightPrecision::bits32), HeightPrecision::bits16);
    PageCodes codes = uniform_page(kMidCode);
    codes[kTexels - 1] += 1;  // one bit, in the last texel
    expect_round_trip(codes, HeightPrecision::bits16);
}

TEST(PageCodec, Bits16LeavesTheLowHalfOut) {
    // Nothing can be saved on random codes but the half that is not there.
    EXPECT_LT(encode_page(random_page(2, HeightPrecision::bits16), HeightPrecision::bits16).size(), 8192u + 64);
    EXPECT_GT(encode_page(random_page(2, HeightPrecision::bits32), HeightPrecision::bits32).size(), 16384u);
}

TEST(PageCodec, APrintTakesFewBytes) { EXPECT_LT(encode_page(print_page(), HeightPrecision::bits32).size(), 400u); }

TEST(PageCodec, SameCodesSameBytes) {
    const std::vector<PageCodes> pages = realistic_pages(HeightPrecision::bits32);
    std::vector<Bytes> first;
    for (const PageCodes& codes : pages) first.push_back(encode_page(codes, HeightPrecision::bits32));
    // In another order, between other work, on a fresh thread.
    std::thread([&] {
        for (std::size_t i = pages.size(); i-- > 0;) {
            (void)encode_page(random_page(static_cast<std::uint32_t>(i), HeightPrecision::bits16),
                              HeightPrecision::bits16);
            EXPECT_EQ(encode_page(pages[i], HeightPrecision::bits32), first[i]);
        }
    }).join();
}

// ------------------------------------------------------------------------------ damage

TEST(PageCodec, EveryDamagedByteIsNoticed) {
    std::size_t tried = 0, refused = 0;
    const auto all_values = [&](const PageCodes& codes, HeightPrecision precision) {
        Bytes blob = encode_page(codes, precision);
        for (std::byte& byte : blob) {
            const std::byte was = byte;
            for (int flip = 1; flip < 256; ++flip, ++tried) {
                byte = was ^ static_cast<std::byte>(flip);
                expect_refused_or_same(blob, codes, refused);
            }
            byte = was;
        }
    };
    all_values(uniform_page(kMidCode + 5), HeightPrecision::bits32);
    all_values(print_page(), HeightPrecision::bits32);
    PageCodes high = print_page();
    for (std::uint32_t& code : high) code &= 0xffff'0000u;
    all_values(high, HeightPrecision::bits16);
    // zstd has bits that say nothing (unused ones of its headers), so not all are refused, but nearly.
    EXPECT_GT(refused, tried * 99 / 100);
}

TEST(PageCodec, EveryDamagedHeaderIsRefused) {
    for (const PageCodes& codes : {uniform_page(77), print_page(), random_page(4, HeightPrecision::bits16)})
        for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
            Bytes blob = encode_page(codes, precision);
            for (std::size_t i = 0; i < 16; ++i)
                for (int flip = 1; flip < 256; ++flip) {
                    blob[i] ^= static_cast<std::byte>(flip);
                    EXPECT_FALSE(decode_page(blob, kWhere).ok()) << "byte " << i << " by " << flip;
                    blob[i] ^= static_cast<std::byte>(flip);
                }
        }
}

/// Flips up to 8 bits, or cuts, or lengthens, or overwrites a stretch, or throws all away.
Bytes damaged(const Bytes& blob, std::mt19937& random) {
    const auto below = [&](std::size_t n) { return random() % n; };
    Bytes bytes = blob;
    switch (random() % 5) {
        case 0:
            for (std::size_t n = 1 + below(8); n > 0; --n)
                bytes[below(bytes.size())] ^= static_cast<std::byte>(1u << below(8));
            break;
        case 1:
            bytes.resize(below(bytes.size()));
            break;
        case 2:
            for (std::size_t n = 1 + below(40); n > 0; --n) bytes.push_back(static_cast<std::byte>(random()));
            break;
        case 3:
            for (std::size_t i = below(bytes.size()), n = 1 + below(64); n > 0 && i < bytes.size(); ++i, --n)
                bytes[i] = static_cast<std::byte>(random());
            break;
        default:
            bytes.resize(below(300));
            for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
            // Half of the garbage gets past the first checks.
            if (random() % 2 == 0 && bytes.size() > 20)
                std::copy_n(blob.begin(), std::min<std::size_t>(20, blob.size()), bytes.begin());
    }
    return bytes;
}

TEST(PageCodec, TenThousandDamagedBlobs) {
    std::mt19937 random(1);
    std::vector<std::pair<PageCodes, Bytes>> pages;
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
        for (const PageCodes& codes : realistic_pages(precision))
            pages.emplace_back(codes, encode_page(codes, precision));
        pages.emplace_back(uniform_page(99), encode_page(uniform_page(99), precision));
        pages.emplace_back(random_page(8, precision), encode_page(random_page(8, precision), precision));
    }
    std::size_t refused = 0;
    for (int i = 0; i < 10'000; ++i) {
        const auto& [codes, blob] = pages[random() % pages.size()];
        expect_refused_or_same(damaged(blob, random), codes, refused);
    }
    EXPECT_GT(refused, 9'900u);
}

TEST(PageCodec, RefusesEveryTruncation) {
    for (const PageCodes& codes : {uniform_page(1), print_page()}) {
        const Bytes blob = encode_page(codes, HeightPrecision::bits32);
        for (std::size_t size = 0; size < blob.size(); ++size)
            EXPECT_FALSE(decode_page(std::span(blob).first(size), kWhere).ok()) << size;
    }
}

TEST(PageCodec, RefusesWhatStandsBehindThePage) {
    for (const PageCodes& codes : {uniform_page(1), print_page()}) {
        const Bytes blob = encode_page(codes, HeightPrecision::bits32);
        EXPECT_FALSE(decode_page(blob + Bytes(1), kWhere).ok());
        // zstd would skip this frame, and take this second one for more of the same.
        Bytes skippable;
        put(skippable, 0x184D2A50u, 4);
        put(skippable, 0, 4);
        EXPECT_FALSE(decode_page(blob + skippable, kWhere).ok());
        EXPECT_FALSE(decode_page(blob + plain_frame({}, 0), kWhere).ok());
    }
}

TEST(PageCodec, SaysWhichVersionItDoesNotKnow) {
    Bytes blob = encode_page(print_page(), HeightPrecision::bits32);
    blob[0] = std::byte{7};
    const auto back = decode_page(blob, kWhere);
    ASSERT_FALSE(back.ok());
    EXPECT_NE(back.error().message.find("version 7"), std::string::npos) << back.error().message;
}

/// What `work` adds to the most memory that this process ever had.
std::uint64_t grown_bytes(const std::function<void()>& work) {
    const auto peak = [] {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
    };
    const std::uint64_t before = peak();
    work();
    return peak() - before;
}

TEST(PageCodec, BytesThatClaimGigabytesGetNone) {
    const PageCodes codes = print_page();
    const Bytes content = word_bytes(codes, 4);
    const Bytes header = page_header(1, 4, 0, hash_of(codes));
    EXPECT_TRUE(decode_page(header + plain_frame(content, kTexels * 4), kWhere).ok());
    EXPECT_LT(grown_bytes([&] {
                  for (const std::uint64_t size : {kTexels * 4 - 1, kTexels * 4 + 1, kTexels * 2, std::size_t{0},
                                                   std::size_t{0xffff'ffffu}, std::size_t{1} << 32, ~std::size_t{2}})
                      EXPECT_FALSE(decode_page(header + plain_frame(content, size), kWhere).ok()) << size;
                  // The right size in front, but blocks that hold more: 64 MiB of zeros in 128 KiB steps.
                  Bytes long_frame;
                  put(long_frame, 0xFD2FB528u, 4);
                  put(long_frame, 0xE0, 1);
                  put(long_frame, kTexels * 4, 8);
                  for (int i = 0; i < 512; ++i)
                      put(long_frame, (128u << 10) << 3 | 1 << 1 | (i == 511), 3), put(long_frame, 0, 1);
                  EXPECT_FALSE(decode_page(header + long_frame, kWhere).ok());
              }),
              32 * kMiB);
}

// ------------------------------------------------------------------------------ records

Bytes sample_records(std::size_t size, std::size_t stride) {
    std::mt19937 random(static_cast<std::uint32_t>(size));
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i)
        bytes[i] = i % stride < stride / 2 ? static_cast<std::byte>(i / stride) : static_cast<std::byte>(random() % 7);
    return bytes;
}

TEST(RecordCodec, AnyBytesComeBack) {
    for (const std::size_t stride : {1, 2, 3, 64, 88, 1000, 65535})
        for (const std::size_t size : {0, 1, 2, 63, 64, 65, 6400, 100'003}) {
            const Bytes records = sample_records(size, stride);
            const Bytes blob = encode_records(records, stride);
            EXPECT_EQ(blob, encode_records(records, stride));
            const auto back = decode_records(blob, size, kWhere);
            ASSERT_TRUE(back.ok()) << stride << " " << size << ": " << back.error().message;
            EXPECT_EQ(*back, records) << stride << " " << size;
        }
}

Bytes records_header(int stride, std::uint32_t size, std::uint64_t hash) {
    Bytes bytes;
    put(bytes, 1, 1);
    put(bytes, 0, 1);
    put(bytes, static_cast<std::uint64_t>(stride), 2);
    put(bytes, size, 4);
    put(bytes, hash, 8);
    return bytes;
}

TEST(RecordCodec, ReadsABlobWrittenByHand) {
    // Records of three bytes: abc def, and two bytes of a third.
    const auto bytes_of = [](std::string_view letters) {
        const auto bytes = std::as_bytes(std::span(letters.data(), letters.size()));
        return Bytes(bytes.begin(), bytes.end());
    };
    const Bytes records = bytes_of("abcdefgh");
    const Bytes blob = records_header(3, 8, hash_bytes(records)) + plain_frame(bytes_of("adbecfgh"), 8);
    const auto back = decode_records(blob, 8, kWhere);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(*back, records);
}

TEST(RecordCodec, DamageIsNoticed) {
    const Bytes records = sample_records(6400, 64);
    const Bytes blob = encode_records(records, 64);
    std::mt19937 random(2);
    std::size_t refused = 0;
    const auto expect_refused_or_right = [&](std::span<const std::byte> bytes) {
        const auto back = decode_records(bytes, kMiB, kWhere);
        if (back) {
            EXPECT_EQ(*back, records);
            return;
        }
        ++refused;
        EXPECT_EQ(back.error().code, ErrorCode::FileFormat);
        EXPECT_EQ(back.error().message.rfind(kWhere, 0), 0u) << back.error().message;
    };
    Bytes one = blob;
    for (std::byte& byte : one) {
        for (int bit = 0; bit < 8; ++bit) {
            byte ^= static_cast<std::byte>(1 << bit);
            expect_refused_or_right(one);
            byte ^= static_cast<std::byte>(1 << bit);
        }
    }
    EXPECT_GT(refused, blob.size() * 8 * 99 / 100);
    refused = 0;
    for (int i = 0; i < 10'000; ++i) expect_refused_or_right(damaged(blob, random));
    EXPECT_GT(refused, 9'900u);
}

TEST(RecordCodec, KeepsToItsBound) {
    const Bytes records(100'000);
    const Bytes blob = encode_records(records, 64);
    EXPECT_LT(blob.size(), 100u);
    EXPECT_TRUE(decode_records(blob, 100'000, kWhere).ok());
    const auto refused = decode_records(blob, 99'999, kWhere);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("99999"), std::string::npos) << refused.error().message;
    EXPECT_LT(grown_bytes([&] {
                  const Bytes header = records_header(64, 0xffff'ffffu, 0);
                  EXPECT_FALSE(decode_records(header + plain_frame(records, 0xffff'ffffu), kMiB, kWhere).ok());
                  // The header alone claims it: the frame says otherwise, so whatever is allowed is not allocated.
                  EXPECT_FALSE(decode_records(header + plain_frame(records, records.size()), ~0ull, kWhere).ok());
              }),
              32 * kMiB);
}

}  // namespace
}  // namespace tilth
