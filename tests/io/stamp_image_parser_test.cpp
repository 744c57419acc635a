#include "tilth/io/stamp_image_file.h"

#include <gtest/gtest.h>

#include "io/scratch_folder.h"
#include "io/tiny_tiff.h"
#include "tilth/io/image_codec.h"

namespace tilth::io {
namespace {

using test::ScratchFolder;
using test::TinyTiff;

std::string message(const std::string& path, const StampImageOptions& options = {}) {
    const auto stamp = read_stamp_image(path, options);
    EXPECT_FALSE(stamp.ok()) << path;
    if (stamp.ok()) return "";
    EXPECT_NE(stamp.error().message.find(path), std::string::npos) << stamp.error().message;
    return stamp.error().message;
}

bool has(const std::string& whole, const char* part) { return whole.find(part) != std::string::npos; }

TEST(StampImage, TexelsAreThoseOfTheFile) {
    const ScratchFolder folder;
    const auto tiff = read_stamp_image(folder.put("a.tif", TinyTiff(3, 2, {0, 1, 2, 255, 32768, 65535}).bytes()));
    ASSERT_TRUE(tiff.ok()) << tiff.error().message;
    EXPECT_EQ(tiff->width, 3);
    EXPECT_EQ(tiff->height, 2);
    EXPECT_EQ(tiff->texels, (std::vector<std::uint16_t>{0, 1, 2, 255, 32768, 65535}));

    const auto one = read_stamp_image(folder.put("one.tif", TinyTiff(1, 1, {40000}).bytes()));
    ASSERT_TRUE(one.ok()) << one.error().message;
    EXPECT_EQ(one->texels, (std::vector<std::uint16_t>{40000}));
}

// A PNG that claims gamma 2.2 and sRGB has the same texels as one that does not.
TEST(StampImage, ColourNotesAreIgnored) {
    const ScratchFolder folder;
    std::vector<std::uint16_t> values(16 * 16);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i * 257);
    ImageInfo info;
    info.width = info.height = 16;
    info.channels = 1;
    info.type = SampleType::U16;
    const auto plain = encode_image(ImageFormat::Png, info, std::as_bytes(std::span(values)), "plain");
    ASSERT_TRUE(plain.ok());
    std::string bytes(reinterpret_cast<const char*>(plain->data()), plain->size());
    // After the header (33 bytes): gAMA 45455, then sRGB with perceptual intent; both with their fixed checksums.
    const std::string notes("\0\0\0\4gAMA\0\0\xb1\x8f\x0b\xfc\x61\x05\0\0\0\1sRGB\0\xae\xce\x1c\xe9", 29);
    bytes.insert(33, notes);
    const auto stamp = read_stamp_image(folder.put("srgb.png", bytes));
    ASSERT_TRUE(stamp.ok()) << stamp.error().message;
    EXPECT_EQ(stamp->texels, values);
}

TEST(StampImage, EightBitsNeedPermissionAndWidenExactly) {
    const ScratchFolder folder;
    const std::string path = folder.put("grey8.tif", TinyTiff(2, 2, {0, 1, 128, 255}).set(258, 8).bytes());
    EXPECT_TRUE(has(message(path), "8-bit"));
    const auto stamp = read_stamp_image(path, {.allow_8bit = true});
    ASSERT_TRUE(stamp.ok());
    EXPECT_EQ(stamp->texels, (std::vector<std::uint16_t>{0, 257, 128 * 257, 65535}));
}

TEST(StampImage, RefusesEveryOtherKind) {
    const ScratchFolder folder;
    message(folder.put("zero.tif", TinyTiff(0, 0, {}).bytes()));
    EXPECT_TRUE(
        has(message(folder.put("wide.tif", TinyTiff(4097, 1, std::vector<std::uint32_t>(4097)).bytes())), "4096"));
    EXPECT_TRUE(has(message(folder.put("float.tif", TinyTiff(1, 1, {0}).set(258, 32).set(339, 3).bytes())), "16-bit"));
    EXPECT_TRUE(has(message(folder.put("signed.tif", TinyTiff(1, 1, {0}).set(339, 2).bytes())), "16-bit"));
    EXPECT_TRUE(
        has(message(folder.put("rgb.tif", TinyTiff(1, 1, {1, 2, 3}).set(277, 3).set(262, 2).bytes())), "channels"));
    EXPECT_TRUE(has(message(folder.put("text.png", std::string("no image"))), "not a PNG"));
    EXPECT_TRUE(has(message(folder.put("empty.png", std::string())), "empty"));
    EXPECT_TRUE(has(message(folder.path("missing.png")), "cannot be opened"));
    EXPECT_TRUE(
        read_stamp_image(folder.put("limit.tif", TinyTiff(4096, 1, std::vector<std::uint32_t>(4096)).bytes())).ok());
}

// The stamps that come with the library: the contract of stamps/make_stamps.py.
TEST(StampImage, TheLibrarysStampsHaveBlackBordersAndFullWeight) {
    int stamps = 0;
    for (const auto& entry : std::filesystem::directory_iterator(TILTH_SOURCE_DIR "/stamps")) {
        if (entry.path().extension() != ".png") continue;
        ++stamps;
        const auto stamp = read_stamp_image(entry.path().string());
        ASSERT_TRUE(stamp.ok()) << stamp.error().message;
        EXPECT_EQ(stamp->width, 256);
        EXPECT_EQ(stamp->height, 256);
        int steepest = 0;
        std::uint16_t most = 0;
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x) {
                const int here = stamp->texels[static_cast<std::size_t>(y * 256 + x)];
                most = std::max(most, static_cast<std::uint16_t>(here));
                const bool border = x < 2 || y < 2 || x > 253 || y > 253;
                ASSERT_FALSE(border && here != 0) << entry.path() << " " << x << ", " << y;
                if (x > 0)
                    steepest =
                        std::max(steepest, std::abs(here - stamp->texels[static_cast<std::size_t>(y * 256 + x - 1)]));
            }
        EXPECT_EQ(most, 65535) << entry.path();
        EXPECT_LT(steepest, 65535 / 2) << entry.path() << ": an edge is at least two texels wide";
        EXPECT_LT(std::filesystem::file_size(entry.path()), 150u * 1000) << entry.path();
    }
    EXPECT_GE(stamps, 8);
}

}  // namespace
}  // namespace tilth::io
