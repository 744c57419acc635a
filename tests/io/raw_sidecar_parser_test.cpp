#include "tilth/io/raw_sidecar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "io/scratch_folder.h"
#include "tilth/io/height_file.h"

namespace tilth::io {
namespace {

using test::ScratchFolder;

const char* const kGood = "width = 3\ndepth = 2\nendian = little\nmin_m = -10\nmax_m = 55.535\n";

TEST(RawSidecar, CorpusIsReadAsItsNamesSay) {
    int good = 0, bad = 0;
    for (const auto& entry : std::filesystem::directory_iterator(TILTH_SOURCE_DIR "/tests/io/corpus")) {
        if (entry.path().extension() != ".txt") continue;
        const std::string name = entry.path().filename().string();
        const std::vector<char> bytes = ScratchFolder::bytes_of_file(entry.path().string());
        const RawKind kind = name.find(".r16") != std::string::npos ? RawKind::R16 : RawKind::R32f;
        const auto sidecar = parse_sidecar({bytes.data(), bytes.size()}, kind, name);
        if (name.starts_with("good")) {
            EXPECT_TRUE(sidecar.ok()) << name << sidecar.error().message;
            ++good;
            continue;
        }
        ++bad;
        ASSERT_FALSE(sidecar.ok()) << name;
        std::string key = name.substr(0, name.find('.'));
        for (const char* known : {"width", "depth", "endian", "min_m", "max_m", "no_data", "height"})
            if (key.ends_with(known)) key = known;
        EXPECT_EQ(sidecar.error().code, ErrorCode::FileFormat);
        EXPECT_NE(sidecar.error().message.find(name), std::string::npos) << sidecar.error().message;
        EXPECT_NE(sidecar.error().message.find(key), std::string::npos) << sidecar.error().message;
    }
    EXPECT_EQ(good, 2);
    EXPECT_EQ(bad, 20);
}

TEST(RawSidecar, MeansWhatItSays) {
    const auto sidecar = parse_sidecar("width=3\n depth = 2 # posts\r\n\nendian=big\nmin_m=-10\nmax_m=5e2\nno_data=7",
                                       RawKind::R16, "s");
    ASSERT_TRUE(sidecar.ok()) << sidecar.error().message;
    EXPECT_EQ(sidecar->width, 3);
    EXPECT_EQ(sidecar->depth, 2);
    EXPECT_TRUE(sidecar->big_endian);
    EXPECT_EQ(sidecar->min_m, -10);
    EXPECT_EQ(sidecar->max_m, 500);
    EXPECT_EQ(sidecar->no_data, 7);
    EXPECT_TRUE(std::isnan(*parse_sidecar("width=3\ndepth=2\nendian=big\nno_data=nan", RawKind::R32f, "s")->no_data));
}

TEST(RawSidecar, WhatIsWrittenReadsBackEqual) {
    const RawSidecar written{
        .width = 16384, .depth = 1, .big_endian = true, .min_m = -0.1, .max_m = 1.0 / 3, .no_data = 65535};
    const auto read = parse_sidecar(sidecar_text(written, RawKind::R16), RawKind::R16, "s");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->width, written.width);
    EXPECT_EQ(read->depth, written.depth);
    EXPECT_EQ(read->big_endian, written.big_endian);
    EXPECT_EQ(read->min_m, written.min_m);
    EXPECT_EQ(read->max_m, written.max_m);
    EXPECT_EQ(read->no_data, written.no_data);
}

TEST(RawSidecar, CutAndFlippedSidecarsNeverCrash) {
    const std::string whole = std::string(kGood) + "no_data = 12 # comment\n";
    for (std::size_t cut = 0; cut < whole.size(); ++cut) (void)parse_sidecar(whole.substr(0, cut), RawKind::R16, "cut");
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (int bit = 0; bit < 8; ++bit) {
            std::string flipped = whole;
            flipped[at] = static_cast<char>(flipped[at] ^ (1 << bit));
            const auto sidecar = parse_sidecar(flipped, RawKind::R16, "flipped.txt");
            if (!sidecar.ok()) {
                EXPECT_NE(sidecar.error().message.find("flipped.txt"), std::string::npos);
            }
        }
}

std::string raw16(std::initializer_list<int> values, bool big_endian) {
    std::string bytes;
    for (const int v : values) {
        const char low = static_cast<char>(v & 0xff), high = static_cast<char>(v >> 8);
        bytes += big_endian ? high : low;
        bytes += big_endian ? low : high;
    }
    return bytes;
}

TEST(RawFile, SixteenBitsSpanTheRangeInBothByteOrders) {
    const ScratchFolder folder;
    for (const bool big : {false, true}) {
        folder.put("map.r16.txt", std::string("width = 3\ndepth = 2\nendian = ") + (big ? "big" : "little") +
                                      "\nmin_m = 236\nmax_m = 1076\n");
        const auto read = read_heights(folder.put("map.r16", raw16({0, 1, 256, 32768, 65534, 65535}, big)));
        ASSERT_TRUE(read.ok()) << read.error().message;
        EXPECT_EQ((*read)->width(), 3);
        EXPECT_EQ((*read)->depth(), 2);
        const int values[] = {0, 1, 256, 32768, 65534, 65535};
        for (int i = 0; i < 6; ++i)  // half a float's ulp at 1 076 m is 6.1e-5 m
            EXPECT_NEAR((*read)->height_m({i % 3, i / 3}), 236 + 840.0 * values[i] / 65535, 6.2e-5);
        EXPECT_EQ((*read)->min_m(), 236);
        EXPECT_EQ((*read)->max_m(), 1076);
    }
}

TEST(RawFile, FloatsAreTakenAsTheyAreAndEndingsInAnyCase) {
    const ScratchFolder folder;
    const float values[] = {0.1f, -1e-30f, 8848.86f, 3.0f};
    std::string bytes(reinterpret_cast<const char*>(values), sizeof values), swapped;
    for (std::size_t i = 0; i < bytes.size(); ++i) swapped += bytes[i / 4 * 4 + 3 - i % 4];
    folder.put("a.R32F.txt", std::string("width = 2\ndepth = 2\nendian = little\n"));
    folder.put("b.r32f.txt", std::string("width = 2\ndepth = 2\nendian = big\n"));
    for (const std::string& path : {folder.put("a.R32F", bytes), folder.put("b.r32f", swapped)}) {
        const auto read = read_heights(path);
        ASSERT_TRUE(read.ok()) << read.error().message;
        for (int i = 0; i < 4; ++i) EXPECT_EQ((*read)->height_m({i % 2, i / 2}), double{values[i]});
    }
}

TEST(RawFile, WrongSizesMissingFilesAndHolesAreErrorsThatNameTheFile) {
    const ScratchFolder folder;
    const auto message = [&](const std::string& name, const HeightFileOptions& options = {}) {
        const auto read = read_heights(folder.path(name), options);
        EXPECT_FALSE(read.ok());
        return read.ok() ? std::string() : read.error().message;
    };
    const auto has = [](const std::string& whole, const std::string& part) {
        return whole.find(part) != std::string::npos;
    };

    folder.put("alone.r16", raw16({0, 1, 2, 3, 4, 5}, false));
    EXPECT_TRUE(has(message("alone.r16"), folder.path("alone.r16.txt"))) << message("alone.r16");
    folder.put("gone.r16.txt", std::string(kGood));
    EXPECT_TRUE(has(message("gone.r16"), folder.path("gone.r16"))) << message("gone.r16");

    folder.put("map.r16.txt", std::string(kGood));
    for (const int bytes : {0, 1, 11, 13, 24}) {
        folder.put("map.r16", std::string(static_cast<std::size_t>(bytes), 'a'));
        EXPECT_TRUE(has(message("map.r16"), folder.path("map.r16"))) << message("map.r16");
        EXPECT_TRUE(has(message("map.r16"), "12")) << message("map.r16");
    }

    folder.put("hole.r16", raw16({5, 1, 2, 3, 5, 4}, false));
    folder.put("hole.r16.txt", std::string(kGood) + "no_data = 5\n");
    EXPECT_TRUE(has(message("hole.r16"), "2 of 6")) << message("hole.r16");
    EXPECT_TRUE(has(message("hole.r16"), "(0, 0)")) << message("hole.r16");
    HeightFileOptions options;
    options.no_data_replacement_m = 1;
    EXPECT_TRUE(read_heights(folder.path("hole.r16"), options).ok());
    options.scale_m = 2;
    EXPECT_TRUE(has(message("hole.r16", options), "min_m"));

    folder.put("nan.r32f", std::string("\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xc0\x7f", 16));
    folder.put("nan.r32f.txt", std::string("width = 2\ndepth = 2\nendian = little\n"));
    EXPECT_TRUE(has(message("nan.r32f"), "(1, 1)")) << message("nan.r32f");
    EXPECT_TRUE(has(message("nan.r32f"), folder.path("nan.r32f")));

    folder.put("long.r16", raw16({0, 1, 2, 3, 4, 5}, false));
    folder.put("long.r16.txt", std::string(100000, '#'));
    EXPECT_TRUE(has(message("long.r16"), "65536")) << message("long.r16");
}

}  // namespace
}  // namespace tilth::io
