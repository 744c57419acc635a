// The state hashes in demo/scenarios are those of a ground that applies every record at once, with no tile ever away.
#include <gtest/gtest.h>

#include "demo/scenario/read_scenario.h"
#include "demo/stats/run_report.h"
#include "demo/world/open_world.h"
#include "demo/world/stamp_folder.h"
#include "tilth/core/hash.h"
#include "tilth/ground/path.h"
#include "tilth/ground/random_stamps.h"

namespace tilth::demo {
namespace {

const std::string kStamps = TILTH_SOURCE_DIR "/stamps";

/// Does what a scenario's steps do to the ground, and keeps the detail hashes where it expects some.
class Replay {
public:
    explicit Replay(Ground& ground) : ground_(ground) {}

    void play(const Scenario& scenario) {
        for (const Step& step : scenario.steps) std::visit([this](const auto& action) { run(action); }, step.action);
    }
    [[nodiscard]] int hashes_seen() const { return hashes_; }

private:
    template <class Other>
    void run(const Other&) {}
    void run(const CameraStep& step) { at_ = {step.eye.x, step.eye.z}; }
    void run(const TeleportStep& step) { at_ = step.to; }
    void run(const StampStep& step) {
        StampRequest request = step.request;
        request.shape = *ground_.shapes().find(step.shape);
        apply(request);
    }
    void run(const WalkStep& step) {
        if (step.print) {
            PathRequest path{step.print->request, {at_, step.to}, step.stride_m, step.alternate_m};
            path.stamp.shape = *ground_.shapes().find(step.print->shape);
            const auto prints = stamps_along(path);
            ASSERT_TRUE(prints);
            for (const StampRequest& print : *prints) apply(print);
        }
        at_ = step.to;
    }
    void run(const RandomStep& step) {
        RandomStamps random{step.seed,        step.count, step.region, step.radius_m,
                            step.amplitude_m, step.map,   {},          step.rules};
        for (const std::string& name : step.shapes) random.shapes.push_back(*ground_.shapes().find(name));
        for (const StampRequest& request : random_stamps(random, ground_)) apply(request);
    }
    void run(const ExpectStep& step) {
        const auto* hash = std::get_if<ExpectHash>(&step.what);
        if (hash == nullptr || !hash->detail) return;
        EXPECT_EQ(*hash->detail, hex16(ground_.hash().detail));
        ++hashes_;
    }
    void apply(const StampRequest& request) {
        const auto record = ground_.issue(request);
        ASSERT_TRUE(record) << record.error().message;
        ground_.apply(*record);
    }

    Ground& ground_;
    WorldPos at_;
    int hashes_ = 0;
};

TEST(ScenarioHash, IsThatOfAGroundWithoutTiles) {
    for (const char* name : {"footprints", "mines"}) {
        SCOPED_TRACE(name);
        Problems problems;
        const auto scenario = read_scenario(std::string(TILTH_SOURCE_DIR "/demo/scenarios/") + name + ".toml",
                                            {shape_names(kStamps), has_stat}, problems);
        ASSERT_TRUE(scenario) << problems.report(name);
        const auto heights = load_heights(scenario->terrain.heights);
        ASSERT_TRUE(heights) << heights.error().message;
        auto ground = Ground::create(*heights, scenario->terrain.settings.ground);
        ASSERT_TRUE(ground) << ground.error().message;
        ASSERT_TRUE(add_stamps(kStamps, (*ground)->shapes()));
        Replay replay(**ground);
        replay.play(*scenario);
        EXPECT_GE(replay.hashes_seen(), 1);
    }
}

}  // namespace
}  // namespace tilth::demo
