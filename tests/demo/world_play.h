// Plays scenarios on worlds in a scratch folder, in this process: a context is opened once, or none.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "demo/player/player.h"
#include "demo/scenario/read_scenario.h"
#include "demo/world/open_world.h"
#include "demo/world/stamp_folder.h"
#include "demo/world/world_session.h"

namespace tilth::test {

/// What a run left.
struct PlayedWorld {
    bool good = false;
    demo::RunReport report;
    std::string messages;  ///< of opening, and of steps that failed
};

class WorldPlay : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() / (std::string("tilth_demo_") + info->test_suite_name() + "_" +
                                                            info->name() + "_" + std::to_string(getpid()));
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

    /// A world that is opened, and not played yet.
    struct Opened {
        std::optional<demo::Scenario> scenario;
        std::unique_ptr<demo::WorldSession> world;
        std::ostringstream messages;
    };
    /// `terrain`: lines below [terrain]. Without a context there are no tiles, and only the CPU stamps.
    std::unique_ptr<Opened> open(const std::string& terrain, const std::vector<std::string>& steps) const {
        auto opened = std::make_unique<Opened>();
        std::string toml = "[terrain]\n" + terrain;
        for (const std::string& step : steps) toml += "[[step]]\n" + step + "\n";
        demo::Problems problems;
        opened->scenario = demo::parse_scenario(toml, folder_ / "made_up.toml",
                                                {demo::shape_names(kStamps), demo::has_stat}, problems);
        EXPECT_TRUE(opened->scenario) << problems.report("F");
        if (!opened->scenario) return opened;
        opened->world = demo::WorldSession::open(
            {opened->scenario->terrain, demo::load_heights(opened->scenario->terrain, problems), kStamps, get_proc_},
            problems, opened->messages);
        if (!opened->world) opened->messages << problems.report("F");
        return opened;
    }

    static PlayedWorld played(Opened& opened) {
        PlayedWorld result;
        if (opened.world) {
            demo::Player player(*opened.world, *opened.scenario, nullptr, {}, opened.messages);
            result.good = player.play();
            result.report = player.report(true);
            EXPECT_TRUE(opened.world->flush());
        }
        result.messages = opened.messages.str();
        return result;
    }

    [[nodiscard]] PlayedWorld play(const std::string& terrain, const std::vector<std::string>& steps) const {
        return played(*open(terrain, steps));
    }
    /// Of a run in which nothing may fail.
    [[nodiscard]] StateHash hash_after(const std::string& terrain, const std::vector<std::string>& steps) const {
        const PlayedWorld world = play(terrain, steps);
        EXPECT_TRUE(world.good) << world.messages;
        EXPECT_EQ(world.messages, "");
        return world.report.hash;
    }

    inline static const std::string kStamps = TILTH_SOURCE_DIR "/stamps";
    gl::GetProc get_proc_ = nullptr;
    std::filesystem::path folder_;
};

/// Ground of 8 x 8 tiles of 64 texels; hills, so that a coarse level is another one everywhere.
inline const std::string kHills =
    "heights = \"ridged:seed=3,size=129,relief=30\"\ntexels_per_post = 4\ntile_size = 64\nexecutor = \"cpu\"\n";

/// Strokes of every kind and rule, on both maps. Those with coarse `min`, `max` and `set` ask for original heights.
inline const std::string kCoarse =
    "random = { seed = 5, count = 6, region = [[10, 10], [118, 118]], radius = [9, 16], amplitude = [-3, 3] }";
inline const std::string kDetail =
    "random = { seed = 6, count = 10, region = [[10, 10], [118, 118]], radius = [0.5, 4], amplitude = [-0.3, 0.3] }";
inline const std::string kBoots =
    "path = { shape = \"boot\", points = [[30, 60], [60, 64]], spacing = 4, alternate = 1, radius = 2, amplitude = "
    "-0.1, rule = \"min\" }";
inline const std::string kHeap =
    "stamp = { shape = \"gaussian\", centre = [64, 64], radius = 6, amplitude = 0.3, repeat = 3 }";
inline const std::string kWalk =
    "walk = { to = [40, 70], speed = 20, dt = 0.1, stride = 5, print = { shape = \"tyre\", radius = 1.5, amplitude = "
    "-0.1, rule = \"max\", level = 0.2 } }";

}  // namespace tilth::test
