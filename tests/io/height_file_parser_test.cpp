#include "tilth/io/height_file.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "io/scratch_folder.h"
#include "io/tiny_tiff.h"
#include "tilth/io/height_writer.h"
#include "tilth/io/image_codec.h"
#include "tilth/io/png.h"
#include "tilth/io/tiff_no_data.h"

namespace tilth::io {
namespace {

using test::ScratchFolder;
using test::TinyTiff;

/// The error of a reading that must fail; its message must name the file.
Error refused(const std::string& path, const HeightFileOptions& options = {}) {
    const auto read = read_heights(path, options);
    EXPECT_FALSE(read.ok()) << path;
    if (read.ok()) return {};
    EXPECT_NE(read.error().message.find(path), std::string::npos) << read.error().message;
    return read.error();
}

#define EXPECT_REFUSED_FOR(why, ...)                                                  \
    do {                                                                              \
        const Error refusal_ = refused(__VA_ARGS__);                                  \
        EXPECT_NE(refusal_.message.find(why), std::string::npos) << refusal_.message; \
    } while (false)

std::vector<std::uint32_t> counting(std::uint32_t count) {
    std::vector<std::uint32_t> values;
    for (std::uint32_t i = 0; i < count; ++i) values.push_back(i * 1000);
    return values;
}

TEST(HeightFile, ReadsTiffInBothByteOrdersAndSizes) {
    const ScratchFolder folder;
    for (int variant = 0; variant < 4; ++variant) {
        TinyTiff tiff(4, 3, counting(12));
        if (variant & 1) tiff.big_endian();
        if (variant & 2) tiff.big_tiff();
        const auto read = read_heights(folder.put("map.tif", tiff.bytes()));
        ASSERT_TRUE(read.ok()) << variant << read.error().message;
        EXPECT_EQ((*read)->width(), 4);
        EXPECT_EQ((*read)->depth(), 3);
        for (int z = 0; z < 3; ++z)
            for (int x = 0; x < 4; ++x) EXPECT_EQ((*read)->height_m({x, z}), 1000 * (z * 4 + x)) << variant;
    }
}

TEST(HeightFile, SignedAndFloatSamplesKeepTheirValues) {
    const ScratchFolder folder;
    const std::int16_t sixteen[] = {-32768, -1, 0, 32767};
    std::vector<std::uint32_t> bits;
    for (const std::int16_t v : sixteen) bits.push_back(static_cast<std::uint16_t>(v));
    const auto read = read_heights(folder.put("signed.tif", TinyTiff(2, 2, bits).set(339, 2).bytes()));
    ASSERT_TRUE(read.ok()) << read.error().message;
    for (int i = 0; i < 4; ++i) EXPECT_EQ((*read)->height_m({i % 2, i / 2}), sixteen[i]);

    const float floats[] = {-413.25f, 1e-30f, 8848.86f, 0.1f};
    bits.clear();
    for (const float v : floats) bits.push_back(std::bit_cast<std::uint32_t>(v));
    const auto real = read_heights(folder.put("float.tif", TinyTiff(2, 2, bits).set(258, 32).set(339, 3).bytes()));
    ASSERT_TRUE(real.ok()) << real.error().message;
    for (int i = 0; i < 4; ++i) EXPECT_EQ((*real)->height_m({i % 2, i / 2}), double{floats[i]});
}

TEST(HeightFile, TheDescriptionGivesScaleAndOffsetAndOptionsWin) {
    const ScratchFolder folder;
    const std::string path = folder.put(
        "map.tif",
        TinyTiff(2, 2, {0, 1, 2, 65535}).set(270, "tilth: scale=0.0127 offset=249 source=somewhere").bytes());
    const auto read = read_heights(path);
    ASSERT_TRUE(read.ok());
    for (const auto& [x, z, value] : {std::tuple{0, 0, 0}, {1, 0, 1}, {0, 1, 2}, {1, 1, 65535}})
        EXPECT_EQ((*read)->height_m({x, z}), double{static_cast<float>(value * 0.0127 + 249)});

    HeightFileOptions options;
    options.scale_m = 0.5;
    const auto scaled = read_heights(path, options);
    ASSERT_TRUE(scaled.ok());
    EXPECT_EQ((*scaled)->height_m({1, 1}), 65535 * 0.5 + 249);
    options.offset_m = -100;
    EXPECT_EQ((*read_heights(path, options))->height_m({1, 1}), 65535 * 0.5 - 100);

    EXPECT_REFUSED_FOR("scale", folder.put("a.tif", TinyTiff(2, 2, counting(4)).set(270, "tilth: scale=0").bytes()));
    EXPECT_REFUSED_FOR("scale", folder.put("b.tif", TinyTiff(2, 2, counting(4)).set(270, "tilth: scale=1x").bytes()));
    EXPECT_REFUSED_FOR("offset",
                       folder.put("c.tif", TinyTiff(2, 2, counting(4)).set(270, "tilth: offset=nan").bytes()));
    EXPECT_TRUE(read_heights(folder.put("d.tif", TinyTiff(2, 2, counting(4)).set(270, "scale=0").bytes())).ok());
}

TEST(HeightFile, EightBitsNeedPermission) {
    const ScratchFolder folder;
    const std::string path = folder.put("grey8.tif", TinyTiff(2, 2, {0, 7, 200, 255}).set(258, 8).bytes());
    EXPECT_REFUSED_FOR("8-bit", path);
    EXPECT_REFUSED_FOR("steps", path);
    HeightFileOptions options;
    options.allow_8bit = true;
    const auto read = read_heights(path, options);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ((*read)->height_m({1, 1}), 255);
    EXPECT_EQ((*read)->height_m({1, 0}), 7);
}

TEST(HeightFile, NoDataIsAnErrorUnlessReplaced) {
    const ScratchFolder folder;
    TinyTiff tiff(3, 2, {5, 6, 7, 9999, 8, 9999});
    const std::string path = folder.put("holes.tif", tiff.set(42113, "9999").bytes());
    const Error error = refused(path);
    EXPECT_EQ(error.code, ErrorCode::FileFormat);
    EXPECT_NE(error.message.find("2 of 6"), std::string::npos) << error.message;
    EXPECT_NE(error.message.find("(0, 1)"), std::string::npos) << error.message;

    HeightFileOptions options;
    options.no_data_replacement_m = -12.5;
    const auto filled = read_heights(path, options);
    ASSERT_TRUE(filled.ok()) << filled.error().message;
    EXPECT_EQ((*filled)->height_m({0, 1}), -12.5);
    EXPECT_EQ((*filled)->height_m({2, 1}), -12.5);
    EXPECT_EQ((*filled)->height_m({1, 1}), 8);

    options = {};
    options.no_data = 6;  // the option wins: 9999 becomes a height, 6 a hole
    EXPECT_REFUSED_FOR("1 of 6", path, options);
    options.no_data = 12345;
    EXPECT_TRUE(read_heights(path, options).ok());
}

TEST(HeightFile, NoDataTagIsReadInEveryKindOfTiff) {
    const ScratchFolder folder;
    for (int variant = 0; variant < 4; ++variant)
        for (const char* value : {"7", "-32768", "1.5"}) {  // held in the entry itself, or beside it
            TinyTiff tiff(2, 2, {7, 0x8000, 1, 2});
            if (variant & 1) tiff.big_endian();
            if (variant & 2) tiff.big_tiff();
            const std::string bytes = tiff.set(339, 2).set(42113, value).bytes();
            EXPECT_EQ(gdal_no_data_text(std::as_bytes(std::span(bytes))), value) << variant;
            EXPECT_EQ(read_heights(folder.put("map.tif", bytes)).ok(), value[0] == '1') << variant << " " << value;
        }
    EXPECT_REFUSED_FOR("GDAL_NODATA", folder.put("word.tif", TinyTiff(2, 2, counting(4)).set(42113, "none").bytes()));
}

TEST(HeightFile, NoDataOfFloatsMayBeNanInfOrRoundedText) {
    const ScratchFolder folder;
    const auto tiff_with = [](float hole) {
        return TinyTiff(2, 2, {0, 0, std::bit_cast<std::uint32_t>(hole), 0}).set(258, 32).set(339, 3);
    };
    constexpr float kInf = std::numeric_limits<float>::infinity();
    const std::pair<float, const char*> holes[] = {{std::nanf(""), "nan"},
                                                   {-kInf, "-inf"},
                                                   {-std::numeric_limits<float>::max(), "-3.40282346638529e+38"},
                                                   {-9999.0f, "-9999"},
                                                   {0.1f, "0.1"}};
    HeightFileOptions replace;
    replace.no_data_replacement_m = 3;
    for (const auto& [hole, name] : holes) {
        const std::string path = folder.put("map.tif", tiff_with(hole).set(42113, name).bytes());
        EXPECT_REFUSED_FOR("no data", path);
        const auto read = read_heights(path, replace);
        ASSERT_TRUE(read.ok()) << name << read.error().message;
        EXPECT_EQ((*read)->height_m({0, 1}), 3);
        EXPECT_EQ((*read)->height_m({1, 1}), 0);
    }
    // Not declared: never guessed.
    EXPECT_REFUSED_FOR("(0, 1)", folder.put("nan.tif", tiff_with(std::nanf("")).bytes()), replace);
    EXPECT_REFUSED_FOR("infinite", folder.put("inf.tif", tiff_with(kInf).bytes()), replace);
    EXPECT_EQ((*read_heights(folder.put("low.tif", tiff_with(-9999.0f).bytes()), replace))->min_m(), -9999);
}

TEST(HeightFile, ChannelsMustBeOneOrEqual) {
    const ScratchFolder folder;
    const auto rgb = [](const std::vector<std::uint32_t>& samples) {
        return TinyTiff(2, 2, samples).set(277, 3).set(262, 2);
    };
    const auto equal = read_heights(folder.put("equal.tif", rgb({1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4}).bytes()));
    ASSERT_TRUE(equal.ok()) << equal.error().message;
    EXPECT_EQ((*equal)->height_m({1, 1}), 4);
    EXPECT_EQ((*equal)->height_m({0, 1}), 3);
    EXPECT_REFUSED_FOR("(1, 0)", folder.put("rgb.tif", rgb({1, 1, 1, 2, 2, 3, 3, 3, 3, 4, 4, 4}).bytes()));

    ImageInfo info;
    info.width = info.height = 2;
    info.channels = 4;
    info.type = SampleType::U16;
    const std::vector<std::uint16_t> rgba(16, 1000);
    ASSERT_TRUE(write_image(folder.path("rgba.png"), ImageFormat::Png, info, std::as_bytes(std::span(rgba))).ok());
    EXPECT_REFUSED_FOR("alpha", folder.path("rgba.png"));
}

TEST(HeightFile, WhatOtherTypesWouldMeanIsSaid) {
    const ScratchFolder folder;
    EXPECT_REFUSED_FOR("32-bit", folder.put("u32.tif", TinyTiff(2, 2, counting(4)).set(258, 32).bytes()));
    EXPECT_REFUSED_FOR("inverted", folder.put("white.tif", TinyTiff(2, 2, counting(4)).set(262, 0).bytes()));
    EXPECT_REFUSED_FOR("at least 2", folder.put("thin.tif", TinyTiff(1, 4, counting(4)).bytes()));
}

TEST(HeightFile, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
    const ScratchFolder folder;
    EXPECT_REFUSED_FOR("16384", folder.put("wide.tif", TinyTiff(16385, 2, counting(4)).bytes()));
    refused(folder.put("huge.tif", TinyTiff(0x7fffffff, 0x7fffffff, counting(4)).bytes()));
    refused(folder.put("negative.tif", TinyTiff(0xffffffff, 0xffffffff, counting(4)).bytes()));
    refused(folder.put("zero.tif", TinyTiff(0, 0, counting(4)).bytes()));
    EXPECT_REFUSED_FOR("can hold", folder.put("claims.tif", TinyTiff(16384, 16384, counting(4)).bytes()));
    refused(folder.put("claims_zip.tif", TinyTiff(16384, 16384, counting(4)).set(259, 8).bytes()));

    // A PNG whose header says 16 384 x 16 384, with its checksum right: 28 bytes behind it cannot hold that.
    const unsigned char png[] = {0x89, 'P', 'N', 'G',  13, 10, 26, 10,   0, 0,  0, 13, 'I', 'H', 'D',
                                 'R',  0,   0,   0x40, 0,  0,  0,  0x40, 0, 16, 0, 0,  0,   0};
    std::string bytes(reinterpret_cast<const char*>(png), sizeof png);
    std::uint32_t crc = 0xffffffff;
    for (const char c : bytes.substr(12)) {
        crc ^= static_cast<unsigned char>(c);
        for (int i = 0; i < 8; ++i) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(~crc >> shift & 0xff);
    bytes += std::string("\0\0\0\4IDAT\0\0\0\0\0\0\0\0\0\0\0\0IEND\xae\x42\x60\x82", 28);
    EXPECT_REFUSED_FOR("can hold", folder.put("claims.png", bytes));
}

TEST(HeightFile, WhatIsNoImageIsRefused) {
    const ScratchFolder folder;
    EXPECT_EQ(refused(folder.path("missing.tif")).code, ErrorCode::NotFound);
    EXPECT_REFUSED_FOR("empty", folder.put("empty.png", std::string()));
    EXPECT_REFUSED_FOR("not a PNG", folder.put("text.png", std::string("P5 2 2 255 aaaa")));
    EXPECT_REFUSED_FOR("not a PNG", folder.put("jpeg.tif", std::string("\xff\xd8\xff\xe0 JFIF")));
    EXPECT_REFUSED_FOR("regular file", std::filesystem::temp_directory_path().string());
    refused(folder.put("magic.png", std::string("\x89PNG\r\n\x1a\n", 8)));
    refused(folder.put("magic.exr", std::string("\x76\x2f\x31\x01", 4)));
    refused(folder.put("magic.tif", std::string("II\x2a\0", 4)));
}

TEST(HeightFile, OptionsThatMakeNoSenseAreRefused) {
    const ScratchFolder folder;
    const std::string path = folder.put("map.tif", TinyTiff(2, 2, counting(4)).bytes());
    HeightFileOptions options;
    options.scale_m = 0;
    EXPECT_REFUSED_FOR("scale", path, options);
    options.scale_m = std::nan("");
    EXPECT_REFUSED_FOR("scale", path, options);
    options = {};
    options.offset_m = INFINITY;
    EXPECT_REFUSED_FOR("offset", path, options);
    options = {};
    options.no_data_replacement_m = std::nan("");
    EXPECT_EQ(refused(path, options).code, ErrorCode::InvalidArgument);
}

// A length in a file is believed only as far as the file reaches: the decoder is not even asked.
TEST(HeightFile, LengthsBeyondTheFileAreRefusedBeforeDecoding) {
    const ScratchFolder folder;
    const auto damaged = [&](const char* name, std::size_t at, char value) {
        std::vector<char> bytes = folder.get(name);
        bytes[at] = value;
        return folder.put(std::string("damaged_") + name, bytes);
    };
    const std::vector<float> floats(9, 1.5f);
    const std::vector<std::uint16_t> values(9, 7);
    ASSERT_TRUE(write_heights_u16(folder.path("a.png"), values, 3, 3, {}).ok());
    ASSERT_TRUE(write_floats(folder.path("a.exr"), floats, 3, 3).ok());
    EXPECT_REFUSED_FOR("a chunk of", damaged("a.png", 33, 0x7f));  // highest byte of the second chunk's length

    const std::vector<char> exr = folder.get("a.exr");
    const std::string text(exr.begin(), exr.end());
    const std::size_t channels = text.find(std::string("channels\0chlist\0", 16)) + 16;
    EXPECT_REFUSED_FOR("an attribute of", damaged("a.exr", channels + 3, 0x40));
    const std::size_t window = text.find(std::string("dataWindow\0box2i\0", 17)) + 17 + 4;
    EXPECT_REFUSED_FOR("16384", damaged("a.exr", window + 11, 0x40));  // highest byte of the last column
    EXPECT_REFUSED_FOR("16384", damaged("a.exr", window + 15, -1));    // last row before the first
}

// ---- damage: every prefix and every flipped bit of small valid files is an error that names the file, or an image
// ----

/// Valid files of every format that is read.
std::vector<std::pair<std::string, std::string>> valid_files(const ScratchFolder& folder) {
    std::vector<std::uint16_t> values;
    std::vector<float> floats;
    for (int i = 0; i < 24 * 17; ++i) {
        values.push_back(static_cast<std::uint16_t>(i * 7919));
        floats.push_back(static_cast<float>(i) * 1.25f - 100);
    }
    EXPECT_TRUE(write_heights_u16(folder.path("valid.png"), values, 24, 17, {0.01, 5}).ok());
    EXPECT_TRUE(write_heights_u16(folder.path("valid.tif"), values, 24, 17, {0.01, 5}).ok());
    EXPECT_TRUE(write_floats(folder.path("valid_float.tif"), floats, 24, 17).ok());
    EXPECT_TRUE(write_floats(folder.path("valid.exr"), floats, 24, 17).ok());
    std::vector<std::pair<std::string, std::string>> files;
    for (const char* name : {"valid.png", "valid.tif", "valid_float.tif", "valid.exr"}) {
        const std::vector<char> bytes = folder.get(name);
        files.emplace_back(name, std::string(bytes.begin(), bytes.end()));
        EXPECT_TRUE(read_heights(folder.path(name)).ok()) << name;
    }
    files.emplace_back("tags.tif", TinyTiff(4, 3, counting(12)).set(42113, "9999").set(270, "tilth: scale=2").bytes());
    files.emplace_back("big.tif", TinyTiff(4, 3, counting(12)).big_tiff().big_endian().set(42113, "-32768").bytes());
    return files;
}

TEST(HeightFile, EveryTruncationIsAnErrorThatNamesTheFile) {
    const ScratchFolder folder;
    for (const auto& [name, whole] : valid_files(folder)) {
        const std::string extension = name.substr(name.find('.'));
        // What may be cut without loss: the closing chunk of a PNG (12 bytes), and what a TIFF keeps behind the
        // samples.
        const std::size_t spare = extension == ".png" ? 12 : extension == ".tif" ? whole.size() : 0;
        std::size_t refusals = 0, cuts = 0;
        for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 100, ++cuts) {
            const std::string path = folder.put("cut" + extension, whole.substr(0, length));
            const auto read = read_heights(path);
            refusals += !read.ok();
            if (read.ok()) {
                EXPECT_GE(length + spare, whole.size()) << name << " cut to " << length;
            } else {
                EXPECT_NE(read.error().message.find(path), std::string::npos) << read.error().message;
            }
        }
        EXPECT_GT(refusals, cuts * 3 / 4) << name;
    }
}

TEST(HeightFile, NoFlippedBitCrashes) {
    const ScratchFolder folder;
    for (const auto& [name, whole] : valid_files(folder)) {
        const std::size_t step = 1 + whole.size() / 100;
        for (std::size_t at = 0; at < whole.size(); at += at < 128 ? 1 : step) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at * 5 % 8)));
            const std::string path = folder.put("flipped.bin", damaged);
            const auto read = read_heights(path);
            if (read.ok()) {
                EXPECT_LE((*read)->width(), kMaxImageSide);
                EXPECT_TRUE(std::isfinite((*read)->min_m()) && std::isfinite((*read)->max_m()));
            } else {
                EXPECT_NE(read.error().message.find(path), std::string::npos) << read.error().message;
            }
        }
    }
}

}  // namespace
}  // namespace tilth::io
