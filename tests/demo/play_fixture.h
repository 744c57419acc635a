// Plays a scenario with the real program, into a folder of the test's own.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "demo/run_program.h"
#include "demo/stats/run_report.h"

namespace tilth::test {

using demo::Json;
namespace fs = std::filesystem;

class Play : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::path(TILTH_BINARY_DIR) / "test-output" / "demo" / info->name();
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    [[nodiscard]] std::string stats_path() const { return (folder_ / "stats.json").string(); }

    Ran play(const std::string& scenario, const std::string& flags) {
        return run_sandbox_program("--headless --scenario '" + scenario + "' --out '" + folder_.string() +
                                   "' --stats '" + stats_path() + "' " + flags);
    }
    Json stats() const { return Json::parse(std::ifstream(stats_path())); }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text;
        return (folder_ / name).string();
    }
    fs::path folder_;
};

}  // namespace tilth::test
