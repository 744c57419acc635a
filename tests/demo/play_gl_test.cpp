// The program plays a scenario from end to end, by both routes and both executors.
#include <gtest/gtest.h>

#include <iostream>

#include "demo/gl/gl_route.h"
#include "demo/play_fixture.h"
#include "tilth/io/png.h"

namespace tilth::test {
namespace {

const std::string kScenario = TILTH_SOURCE_DIR "/tests/demo/play.toml";

TEST_F(Play, EveryRouteAndExecutorLeavesTheSameBits) {
    std::vector<std::string> hashes;
    for (const std::string route : {"egl", "osmesa"}) {
        if (const auto opened = demo::GlRoute::offscreen(route); !opened) {
            std::cout << "skipped " << route << ": " << opened.error().message << std::endl;
            continue;
        }
        for (const std::string executor : {"cpu", "gpu"}) {
            SCOPED_TRACE(route + " " + executor);
            const Ran ran = play(kScenario, "--context " + route + " --executor " + executor);
            ASSERT_EQ(ran.status, 0) << ran.output;
            EXPECT_EQ(ran.output, "") << "a good run says nothing";
            const Json json = stats();
            EXPECT_EQ(json["context"]["route"], route);
            EXPECT_EQ(json["context"]["executor"], executor);
            EXPECT_FALSE(json["context"]["renderer"].get<std::string>().empty());
            EXPECT_TRUE(json["failures"].empty());
            EXPECT_EQ(json["frames"]["count"], 12);
            EXPECT_GT(json["frames"]["cpu_ms"]["p50"], 0);
            EXPECT_GT(json["total"]["deform"]["texels"], 0);
            EXPECT_GT(json["total"]["render"]["primitives"], 0);
            EXPECT_EQ(json["queries"].size(), 2u);
            EXPECT_EQ(json["queries"][0].size(), 2u);
            if (executor == "gpu") {
                EXPECT_GT(json["total"]["deform"]["passes"], 0);
            }
            hashes.push_back(json["hash"].dump());
        }
    }
    ASSERT_GE(hashes.size(), 2u) << "no route opened";
    for (const std::string& hash : hashes) EXPECT_EQ(hash, hashes.front());
}

TEST_F(Play, OutputsAreWhatWasAskedFor) {
    ASSERT_EQ(play(kScenario, "--size 96x64").status, 0);
    const auto before = io::read_png_rgb8((folder_ / "before.png").string()),
               after = io::read_png_rgb8((folder_ / "after.png").string());
    ASSERT_TRUE(before && after);
    EXPECT_EQ(before->width, 96) << "the flag overrides the file";
    EXPECT_EQ(before->height, 64);
    EXPECT_NE(before->pixels, after->pixels);
    const std::uint8_t sky[3] = {51, 102, 153};  // clear = [0.2, 0.4, 0.6], stored as it is
    for (int c = 0; c < 3; ++c) EXPECT_EQ(before->pixels[std::size_t(c)], sky[c]) << "top row first: the sky";
    const std::size_t middle_of_last_row = (std::size_t(63) * 96 + 48) * 3;
    EXPECT_NE(std::vector<std::uint8_t>(before->pixels.begin() + std::ptrdiff_t(middle_of_last_row),
                                        before->pixels.begin() + std::ptrdiff_t(middle_of_last_row) + 3),
              std::vector<std::uint8_t>(sky, sky + 3));
    for (const char* file : {"before.exr", "d.tif", "s.exr"}) EXPECT_GT(fs::file_size(folder_ / file), 0u) << file;
    std::ifstream csv(folder_ / "sub" / "h.csv");
    std::vector<std::string> lines;
    for (std::string line; std::getline(csv, line);) lines.push_back(line);
    ASSERT_EQ(lines.size(), 6u);  // 3 x 2 posts, borders included
    EXPECT_EQ(lines[0].substr(0, 6), "60,60,");
    EXPECT_EQ(lines[5].substr(0, 6), "62,61,");
}

TEST_F(Play, ShowSwitchesHowDetailIsShownAndBack) {
    const auto scenario_with = [](const std::string& steps) {
        return "[terrain]\nheights = \"flat:size=129,height=0\"\nspacing = 0.1\ntile_size = 512\n"
               "[view]\nsize = [96, 64]\n"
               "[[step]]\nstamp = { shape = \"crater\", centre = [5.5, 4], radius = 0.6, amplitude = -0.3, map = "
               "\"detail\" }\n"
               "[[step]]\ncamera = { eye = [4, 4], above_ground = 1, look_at = [5.5, 0, 4] }\n" +
               steps;
    };
    const auto picture = [&](const std::string& name) {
        const auto read = io::read_png_rgb8((folder_ / (name + ".png")).string());
        EXPECT_TRUE(read) << name;
        return read ? read->pixels : std::vector<std::uint8_t>();
    };
    const auto shot = [](const std::string& name) { return "[[step]]\nscreenshot = \"" + name + ".png\"\n"; };
    const auto show = [](const std::string& what) { return "[[step]]\nshow = { " + what + " }\n"; };
    const std::string scenario = write(
        "show.toml",
        scenario_with(shot("none") + show("backend = \"parallax\", preset = \"exact\"") + shot("parallax") +
                      show("backend = \"geometry\"") + shot("geometry") + show("debug = \"level\"") + shot("level") +
                      show("backend = \"none\", preset = \"medium\", debug = \"off\"") + shot("again")));
    const Ran ran = play(scenario, "");
    ASSERT_EQ(ran.status, 0) << ran.output;
    EXPECT_EQ(picture("again"), picture("none"));
    EXPECT_NE(picture("parallax"), picture("none"));
    EXPECT_NE(picture("geometry"), picture("none"));
    EXPECT_NE(picture("geometry"), picture("parallax"));
    EXPECT_NE(picture("level"), picture("geometry"));
    const std::string by_flag = write("flag.toml", scenario_with(shot("by_flag")));
    ASSERT_EQ(play(by_flag, "--backend geometry --preset exact").status, 0);
    EXPECT_EQ(picture("by_flag"), picture("geometry")) << "the preset stayed when the backend changed";
}

TEST_F(Play, AFailedStepIsNamedAndTheRunGoesOn) {
    const std::string scenario = write("fails.toml",
                                       "[terrain]\nheights = \"flat:size=65,height=10\"\n[view]\nsize = [64, 48]\n"
                                       "[[step]]\nexpect = { height_at = [9, 9], value = 11, within = 0.5 }\n"
                                       "[[step]]\nquery = { kind = \"height\", at = [[9.5, 9.25]] }\n"
                                       "[[step]]\nscreenshot = \"/proc/no/such/folder.png\"\n"
                                       "[[step]]\nexpect = { stat = \"queries.0.0\", equals = 10 }\n"
                                       "[[step]]\nexpect = { hash = { detail = \"0000000000000000\" } }\n");
    const Ran ran = play(scenario, "");
    EXPECT_EQ(ran.status, 1);
    EXPECT_NE(ran.output.find("fails.toml:6: step 1: "), std::string::npos) << ran.output;
    EXPECT_NE(ran.output.find("fails.toml:10: step 3: "), std::string::npos) << ran.output;
    EXPECT_NE(ran.output.find("fails.toml:14: step 5: "), std::string::npos) << ran.output;
    EXPECT_EQ(ran.output.find("step 2:"), std::string::npos);
    EXPECT_EQ(ran.output.find("step 4:"), std::string::npos);
    const Json json = stats();
    EXPECT_EQ(json["failures"].size(), 3u) << "statistics are written all the same";
    EXPECT_EQ(json["queries"], Json::parse("[[10.0]]"));
}

TEST_F(Play, AMillionRepeatsAreAMillionStamps) {
    const std::string scenario =
        write("repeat.toml",
              "[terrain]\nheights = \"flat:size=65,height=0\"\nexecutor = \"cpu\"\n[view]\nsize = [16, 16]\n"
              "[[step]]\nstamp = { shape = \"disc\", centre = [32, 32], radius = 7, amplitude = 0.00000762939453125, "
              "map = \"coarse\", repeat = 1000000 }\n"
              "[[step]]\nexpect = { height_at = [32, 32], value = 7.62939453125, within = 0 }\n");
    const Ran ran = play(scenario, "");
    EXPECT_EQ(ran.status, 0) << ran.output;
}

TEST_F(Play, AddThenTheSameTakenAwayIsUntouchedGround) {
    const std::string scenario =
        write("back.toml",
              "[terrain]\nheights = \"ridged:seed=3,size=129,relief=30\"\n[view]\nsize = [16, 16]\n"
              "[[step]]\nstamp = { shape = \"boot\", centre = [31.7, 40.2], radius = 3.3, amplitude = -0.37, rotation "
              "= 0.9 }\n"
              "[[step]]\nwait = { frames = 1, dt = 0.01 }\n"
              "[[step]]\nstamp = { shape = \"boot\", centre = [31.7, 40.2], radius = 3.3, amplitude = 0.37, rotation = "
              "0.9 }\n"
              "[[step]]\nexpect = { hash = { detail = \"2d06800538d394c2\" } }\n");
    for (const char* executor : {"cpu", "gpu"}) {
        const Ran ran = play(scenario, std::string("--executor ") + executor);
        EXPECT_EQ(ran.status, 0) << executor << ": " << ran.output;
    }
}

}  // namespace
}  // namespace tilth::test
