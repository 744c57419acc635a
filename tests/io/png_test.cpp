#include "tilth/io/png.h"

#include <gtest/gtest.h>

#include "io/scratch_folder.h"
#include "tilth/io/image_codec.h"

namespace tilth::io {
namespace {

using test::ScratchFolder;

std::vector<std::uint8_t> every_value(std::size_t count) {
    std::vector<std::uint8_t> pixels(count);
    for (std::size_t i = 0; i < count; ++i) pixels[i] = static_cast<std::uint8_t>(i * 151);
    return pixels;
}

TEST(Png, PicturesReadBackExactly) {
    const ScratchFolder folder;
    const std::vector<std::uint8_t> rgb = every_value(33 * 21 * 3), rgba = every_value(33 * 21 * 4);
    ASSERT_TRUE(write_png_rgb8(folder.path("a.png"), 33, 21, rgb).ok());
    const auto read = read_png_rgb8(folder.path("a.png"));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->width, 33);
    EXPECT_EQ(read->height, 21);
    EXPECT_EQ(read->pixels, rgb);

    // Colour survives any alpha, 0 too: nothing is multiplied or divided.
    ASSERT_TRUE(write_png_rgba8(folder.path("b.png"), 33, 21, rgba).ok());
    const auto image = read_image(folder.path("b.png"), [](const ImageInfo&) { return Result<void>(); });
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_TRUE(std::ranges::equal(image->as<std::uint8_t>(), rgba));
    const auto colour = read_png_rgb8(folder.path("b.png"));
    ASSERT_TRUE(colour.ok());
    for (std::size_t i = 0; i < 33 * 21 * 3; ++i) ASSERT_EQ(colour->pixels[i], rgba[i / 3 * 4 + i % 3]);
}

// The 26th to 29th bytes of a PNG are colour type (2 RGB, 6 RGBA), compression, filter and interlace method.
TEST(Png, IsEightBitAndNotInterlaced) {
    const ScratchFolder folder;
    ASSERT_TRUE(write_png_rgb8(folder.path("a.png"), 5, 4, every_value(60)).ok());
    ASSERT_TRUE(write_png_rgba8(folder.path("b.png"), 5, 4, every_value(80)).ok());
    for (const auto& [name, colour_type] : {std::pair{"a.png", 2}, {"b.png", 6}}) {
        const std::vector<char> bytes = folder.get(name);
        ASSERT_GT(bytes.size(), 33u);
        EXPECT_EQ(bytes[24], 8);
        EXPECT_EQ(bytes[25], colour_type);
        EXPECT_EQ(bytes[28], 0);
    }
}

TEST(Png, RefusesWhatItCannotMean) {
    const ScratchFolder folder;
    EXPECT_FALSE(write_png_rgb8(folder.path("a.png"), 5, 4, every_value(59)).ok());
    EXPECT_FALSE(write_png_rgb8(folder.path("a.png"), 0, 0, {}).ok());
    EXPECT_FALSE(write_png_rgb8(folder.path("a.jpg"), 5, 4, every_value(60)).ok());
    EXPECT_EQ(folder.files(), 0u);
    EXPECT_EQ(read_png_rgb8(folder.path("missing.png")).error().code, ErrorCode::NotFound);

    ImageInfo info;
    info.width = info.height = 2;
    info.channels = 1;
    info.type = SampleType::U8;
    const std::vector<std::uint8_t> samples = every_value(4);
    ASSERT_TRUE(write_image(folder.path("grey.png"), ImageFormat::Png, info, std::as_bytes(std::span(samples))).ok());
    const auto grey = read_png_rgb8(folder.path("grey.png"));
    ASSERT_FALSE(grey.ok());
    EXPECT_NE(grey.error().message.find("RGB"), std::string::npos);
}

TEST(DepthExr, IsOneExactChannel) {
    const ScratchFolder folder;
    const std::vector<float> depth = {0.1f, 1e-30f, 1e30f, 0.5f, 1.0f, 0.0f};
    ASSERT_TRUE(write_depth_exr(folder.path("d.exr"), 3, 2, depth).ok());
    const auto image = read_image(folder.path("d.exr"), [](const ImageInfo&) { return Result<void>(); });
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ(image->info.channels, 1);
    EXPECT_TRUE(std::ranges::equal(image->as<float>(), depth));
    const std::vector<char> bytes = folder.get("d.exr");
    // The header's channel list: "channels" "chlist", size 19, then the channel's name.
    EXPECT_NE(std::string(bytes.begin(), bytes.end()).find(std::string("chlist\0\x13\0\0\0Z\0", 13)),
              std::string::npos);
    EXPECT_FALSE(write_depth_exr(folder.path("d.png"), 3, 2, depth).ok());
}

}  // namespace
}  // namespace tilth::io
