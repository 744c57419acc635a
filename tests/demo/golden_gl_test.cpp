// The tour's pictures are those that were accepted by eye (golden/README.md), by either route to a context.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>

#include "demo/gl/gl_route.h"
#include "demo/picture_compare.h"
#include "demo/run_program.h"
#include "demo/stats/run_report.h"

namespace tilth::test {
namespace {

using demo::Json;
namespace fs = std::filesystem;

const fs::path kGolden = TILTH_SOURCE_DIR "/tests/demo/golden";
constexpr const char* kPictures[] = {"tour_1_hills", "tour_2_craters", "tour_3_boots", "tour_4_tracks", "tour_5_all"};

void expect_golden(const fs::path& folder, const std::string& name) {
    const fs::path drawn = folder / (name + ".png"), accepted = kGolden / (name + ".png");
    const auto actual = io::read_png_rgb8(drawn.string());
    ASSERT_TRUE(actual) << actual.error().message;
    const auto expected = io::read_png_rgb8(accepted.string());
    ASSERT_TRUE(expected) << expected.error().message;
    if (!same_size(*actual, *expected)) {
        ADD_FAILURE() << name << " has another size than the accepted picture:"
                      << leave_side_by_side(folder, name, *actual, *expected);
        return;
    }
    const PictureDistance d = distance_between(*actual, *expected);
    std::cout << name << ": mean " << d.mean_steps << "/255, far off " << 100 * d.share_far_off << " %" << std::endl;
    if (alike(d)) return;
    ADD_FAILURE() << std::setprecision(3) << name << " is not the accepted picture: mean difference " << d.mean_steps
                  << "/255 (allowed " << kMeanStepsAllowed << "), " << 100 * d.share_far_off
                  << " % of pixels off by more than " << kFarOffSteps << "/255 (allowed " << 100 * kShareFarOffAllowed
                  << " %); compare by eye:" << leave_side_by_side(folder, name, *actual, *expected)
                  << "\nIf the new one is right, golden/README.md says how to accept it.";
}

TEST(Golden, TheTourLooksAsAcceptedAndLeavesTheSameBitsByEveryRoute) {
    std::vector<Json> hashes;
    for (const std::string route : {"egl", "osmesa"}) {
        SCOPED_TRACE(route);
        if (const auto opened = demo::GlRoute::offscreen(route); !opened) {
            std::cout << "skipped " << route << ": " << opened.error().message << std::endl;
            continue;
        }
        const fs::path folder = fs::path(TILTH_BINARY_DIR) / "test-output" / "demo" / "golden" / route;
        fs::remove_all(folder);
        fs::create_directories(folder);
        const std::string stats = (folder / "stats.json").string();
        const Ran ran = run_sandbox_program("--headless --scenario '" TILTH_SOURCE_DIR
                                            "/demo/scenarios/tour.toml' --size 480x270 --context " +
                                            route + " --out '" + folder.string() + "' --stats '" + stats + "'");
        ASSERT_EQ(ran.status, 0) << ran.output;
        const Json json = Json::parse(std::ifstream(stats));
        std::cout << route << ": " << json["context"]["renderer"].get<std::string>() << std::endl;
        hashes.push_back(json["hash"]);
        for (const char* name : kPictures) expect_golden(folder, name);
    }
    ASSERT_FALSE(hashes.empty()) << "no route opened";
    for (const Json& hash : hashes) {
        EXPECT_EQ(hash["coarse"], hashes.front()["coarse"]);
        EXPECT_EQ(hash["detail"], hashes.front()["detail"]);
    }
}

}  // namespace
}  // namespace tilth::test
