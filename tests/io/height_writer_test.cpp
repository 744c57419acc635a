#include "tilth/io/height_writer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>

#include "io/scratch_folder.h"
#include "tilth/io/file_bytes.h"
#include "tilth/io/height_file.h"
#include "tilth/io/image_codec.h"

namespace tilth::io {
namespace {

using test::ScratchFolder;

constexpr std::int32_t kWidth = 67, kDepth = 43;

std::vector<float> random_floats() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> height(-500, 9000);
    std::vector<float> floats(kWidth * kDepth);
    for (float& f : floats) f = height(random);
    floats[3] = std::numeric_limits<float>::denorm_min();
    floats[4] = -0.0f;
    return floats;
}

TEST(HeightWriter, FloatsReadBackToTheSameBits) {
    const ScratchFolder folder;
    const std::vector<float> floats = random_floats();
    for (const char* name : {"a.tif", "b.TIFF", "c.exr", "d.r32f"}) {
        ASSERT_TRUE(write_floats(folder.path(name), floats, kWidth, kDepth).ok()) << name;
        const auto read = read_heights(folder.path(name));
        ASSERT_TRUE(read.ok()) << read.error().message;
        ASSERT_EQ((*read)->width(), kWidth);
        ASSERT_EQ((*read)->depth(), kDepth);
        for (int z = 0; z < kDepth; ++z)
            for (int x = 0; x < kWidth; ++x) {
                const float wanted = floats[static_cast<std::size_t>(z * kWidth + x)];
                ASSERT_EQ((*read)->height_m({x, z}), double{wanted}) << name;
            }
    }
}

TEST(HeightWriter, SixteenBitHeightsReadBackExactly) {
    const ScratchFolder folder;
    std::vector<std::uint16_t> values(256 * 256);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::uint16_t>(i * 40503);  // every value once
    const HeightEncoding encoding{0.0127, 1.0 / 3};
    for (const char* name : {"a.tif", "a.png"}) {
        ASSERT_TRUE(write_heights_u16(folder.path(name), values, 256, 256, encoding).ok());
        const auto read = read_heights(folder.path(name));
        ASSERT_TRUE(read.ok()) << read.error().message;
        for (int z = 0; z < 256; ++z)
            for (int x = 0; x < 256; ++x)
                ASSERT_EQ((*read)->height_m({x, z}),
                          double{static_cast<float>(values[static_cast<std::size_t>(z * 256 + x)] * encoding.scale_m +
                                                    encoding.offset_m)});
    }
}

TEST(HeightWriter, QuantisedFloatsAreWithinHalfAStep) {
    const ScratchFolder folder;
    const std::vector<float> floats = random_floats();
    ASSERT_TRUE(write_floats(folder.path("a.r16"), floats, kWidth, kDepth).ok());
    const auto read = read_heights(folder.path("a.r16"));
    ASSERT_TRUE(read.ok()) << read.error().message;
    const auto [low, high] = std::minmax_element(floats.begin(), floats.end());
    EXPECT_EQ((*read)->min_m(), double{*low});
    EXPECT_EQ((*read)->max_m(), double{*high});
    const double half_step = (double{*high} - *low) / 65535 / 2, half_ulp = 0.00049;  // of a float near 9 000
    for (int i = 0; i < kWidth * kDepth; ++i)
        ASSERT_NEAR((*read)->height_m({i % kWidth, i / kWidth}), floats[static_cast<std::size_t>(i)],
                    half_step + half_ulp);

    const std::vector<float> level(4, 7.25f);
    ASSERT_TRUE(write_floats(folder.path("level.r16"), level, 2, 2).ok());
    EXPECT_EQ((*read_heights(folder.path("level.r16")))->max_m(), 7.25);
}

TEST(HeightWriter, CodesAreExactInTiffAndHighPlanesInR16) {
    const ScratchFolder folder;
    const std::vector<std::uint32_t> codes = {0, 1, 0x80000000u, 0xffffffffu, 0x12345678u, 0xfffe0001u};
    ASSERT_TRUE(write_codes(folder.path("codes.tif"), codes, 3, 2).ok());
    const auto image = read_image(folder.path("codes.tif"), [](const ImageInfo&) { return Result<void>(); });
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ(image->info.type, SampleType::U32);
    EXPECT_TRUE(std::ranges::equal(image->as<std::uint32_t>(), codes));

    ASSERT_TRUE(write_codes(folder.path("codes.r16"), codes, 3, 2).ok());
    const auto high = read_heights(folder.path("codes.r16"));
    ASSERT_TRUE(high.ok()) << high.error().message;
    for (int i = 0; i < 6; ++i) EXPECT_EQ((*high)->height_m({i % 3, i / 3}), codes[static_cast<std::size_t>(i)] >> 16);
    EXPECT_EQ(folder.get("codes.r16"),
              (std::vector<char>{0, 0, 0, 0, 0, '\x80', '\xff', '\xff', 0x34, 0x12, '\xfe', '\xff'}));

    for (const char* name : {"codes.exr", "codes.r32f", "codes.png", "codes", "codes.csv"}) {
        const auto refused = write_codes(folder.path(name), codes, 3, 2);
        ASSERT_FALSE(refused.ok()) << name;
        EXPECT_NE(refused.error().message.find(folder.path(name)), std::string::npos);
    }
}

TEST(HeightWriter, CsvHasARowATexelAndAllDigits) {
    const ScratchFolder folder;
    const std::vector<double> values = {0.1, -1e-300, 4294967295.0, 1.0 / 3, 99.5, 0};
    ASSERT_TRUE(write_csv(folder.path("a.csv"), {{500, 1e7}, 0.5}, values, 3, 2).ok());
    const std::vector<char> bytes = folder.get("a.csv");
    const std::string whole(bytes.begin(), bytes.end());
    EXPECT_EQ(whole.find_first_not_of("0123456789.,-+e\n"), std::string::npos);
    EXPECT_NE(whole.find("501,10000000,4294967295\n"), std::string::npos) << whole;

    std::size_t at = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::string line = whole.substr(at, whole.find('\n', at) - at);
        at += line.size() + 1;
        char* rest = nullptr;
        EXPECT_EQ(std::strtod(line.c_str(), &rest), 500 + 0.5 * static_cast<double>(i % 3)) << line;
        EXPECT_EQ(std::strtod(rest + 1, &rest), 1e7 + 0.5 * static_cast<double>(i / 3)) << line;
        EXPECT_EQ(std::strtod(rest + 1, &rest), values[i]) << line;
        EXPECT_EQ(*rest, '\0');
    }
    EXPECT_EQ(at, whole.size());

    ASSERT_TRUE(write_csv(folder.path("two.csv"), {{0, 0}, 1}, values, 3, 1, 2).ok());
    const std::vector<char> two = folder.get("two.csv");
    EXPECT_NE(std::string(two.begin(), two.end()).find("\n2,0,99.5,0\n"), std::string::npos);
}

TEST(HeightWriter, SlopesHaveTwoChannels) {
    const ScratchFolder folder;
    const std::vector<float> slopes = {1, -1, 2, -2, 3, -3, 4, -4};
    for (const char* name : {"s.tif", "s.exr"}) {
        ASSERT_TRUE(write_floats(folder.path(name), slopes, 2, 2, 2).ok());
        const auto image = read_image(folder.path(name), [](const ImageInfo&) { return Result<void>(); });
        ASSERT_TRUE(image.ok()) << image.error().message;
        EXPECT_EQ(image->info.channels, 2);
        EXPECT_TRUE(std::ranges::equal(image->as<float>(), slopes)) << name;
    }
    EXPECT_FALSE(write_floats(folder.path("s.r32f"), slopes, 2, 2, 2).ok());
}

TEST(HeightWriter, WhatCannotBeWrittenIsSaid) {
    const ScratchFolder folder;
    const std::vector<float> floats = {1, 2, 3, std::nanf("")};
    EXPECT_FALSE(write_floats(folder.path("a.r16"), floats, 2, 2).ok());
    EXPECT_FALSE(write_floats(folder.path("a.jpg"), floats, 2, 2).ok());
    EXPECT_FALSE(write_floats(folder.path("a.tif"), floats, 2, 3).ok());
    EXPECT_FALSE(write_floats(folder.path("a.tif"), floats, -2, -2).ok());
    EXPECT_FALSE(write_csv(folder.path("a.csv"), {}, std::vector<double>{1}, 2, 2).ok());
    EXPECT_EQ(folder.files(), 0u);
    const auto missing = write_floats(folder.path("no/such/folder/a.tif"), floats, 2, 2);
    ASSERT_FALSE(missing.ok());
    EXPECT_EQ(missing.error().code, ErrorCode::FileWrite);
    EXPECT_NE(missing.error().message.find("no/such/folder/a.tif"), std::string::npos);
}

/// Until the end of the scope, files may not grow beyond `bytes`: what a full disk does to a writer.
class FullDisk {
public:
    explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FullDisk() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    FullDisk(const FullDisk&) = delete;
    FullDisk& operator=(const FullDisk&) = delete;

private:
    void (*handler_)(int);
    rlimit before_{};
};

TEST(HeightWriter, AFullDiskIsReportedAndTheOldFileStays) {
    const ScratchFolder folder;
    const std::vector<float> floats(64 * 64, 1.5f);
    const std::vector<double> doubles(64 * 64, 1.5);
    const std::string old = "old content";
    for (const char* name : {"a.tif", "a.exr", "a.r32f", "a.csv"}) {
        const std::string path = folder.put(name, old);
        const std::string ending = path.substr(path.size() - 3);
        const auto done = [&] {
            // An EXR of equal floats packs into 400 bytes, the others need thousands; the sidecar 40.
            const FullDisk disk(200);
            return ending == "csv" ? write_csv(path, {}, doubles, 64, 64) : write_floats(path, floats, 64, 64);
        }();
        ASSERT_FALSE(done.ok()) << name;
        EXPECT_EQ(done.error().code, ErrorCode::FileWrite);
        EXPECT_NE(done.error().message.find(path), std::string::npos) << done.error().message;
        EXPECT_EQ(folder.get(name), std::vector<char>(old.begin(), old.end())) << name;
        EXPECT_FALSE(std::filesystem::exists(path + ".part")) << name;
    }
}

TEST(FileWriter, WhatIsNotCommittedIsGone) {
    const ScratchFolder folder;
    {
        auto writer = FileWriter::create(folder.path("a"));
        ASSERT_TRUE(writer.ok());
        writer->write(std::as_bytes(std::span("half")));
        EXPECT_EQ(folder.files(), 1u);
    }
    EXPECT_EQ(folder.files(), 0u);
}

}  // namespace
}  // namespace tilth::io
