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

/// Does what a scenario's steps do to a ground that was never closed, and keeps the detail hashes where it expects
/// some. What is undone was never stamped: the strokes that are left are applied to new ground.
class Replay {
public:
    Replay(std::shared_ptr<const HeightSource> heights, const GroundSettings& settings)
        : heights_(std::move(heights)), settings_(settings), ground_(untouched()) {}

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
        begin_stroke();
        StampRequest request = step.request;
        request.shape = *ground_->shapes().find(step.shape);
        apply(request);
    }
    void run(const PathStep& step) {
        begin_stroke();
        PathRequest path{step.stamp.request, step.points, step.spacing_m, step.alternate_m};
        path.stamp.shape = *ground_->shapes().find(step.stamp.shape);
        const auto stamps = stamps_along(path);
        ASSERT_TRUE(stamps);
        for (const StampRequest& stamp : *stamps) apply(stamp);
    }
    void run(const WalkStep& step) {
        if (step.print) {
            begin_stroke();
            PathRequest path{step.print->request, {at_, step.to}, step.stride_m, step.alternate_m};
            path.stamp.shape = *ground_->shapes().find(step.print->shape);
            const auto prints = stamps_along(path);
            ASSERT_TRUE(prints);
            for (const StampRequest& print : *prints) apply(print);
        }
        at_ = step.to;
    }
    void run(const UndoStep& step) { turn(done_, undone_, step.strokes); }
    void run(const RedoStep& step) { turn(undone_, done_, step.strokes); }
    void run(const RandomStep& step) {
        begin_stroke();
        RandomStamps random{step.seed,        step.count, step.region, step.radius_m,
                            step.amplitude_m, step.map,   {},          step.rules};
        for (const std::string& name : step.shapes) random.shapes.push_back(*ground_->shapes().find(name));
        for (const StampRequest& request : random_stamps(random, *ground_)) apply(request);
    }
    void run(const ExpectStep& step) {
        const auto* hash = std::get_if<ExpectHash>(&step.what);
        if (hash == nullptr || !hash->detail) return;
        EXPECT_EQ(*hash->detail, hex16(ground_->hash().detail));
        if (hash->coarse) {
            EXPECT_EQ(*hash->coarse, hex16(ground_->hash().coarse));
        }
        ++hashes_;
    }
    void apply(const StampRequest& request) {
        const auto record = ground_->issue(request);
        ASSERT_TRUE(record) << record.error().message;
        ground_->apply(*record);
        done_.back().push_back(*record);
    }

    using Stroke = std::vector<StampRecord>;
    void begin_stroke() {
        undone_.clear();
        done_.emplace_back();
    }
    void turn(std::vector<Stroke>& from, std::vector<Stroke>& to, std::int64_t strokes) {
        for (std::int64_t i = 0; i < strokes; ++i) {
            ASSERT_FALSE(from.empty());
            to.push_back(std::move(from.back()));
            from.pop_back();
        }
        ground_ = untouched();
        for (const Stroke& stroke : done_)
            for (const StampRecord& record : stroke) ground_->apply(record);
    }
    [[nodiscard]] std::unique_ptr<Ground> untouched() const {
        auto ground = Ground::create(heights_, settings_);
        EXPECT_TRUE(ground) << ground.error().message;
        EXPECT_TRUE(add_stamps(kStamps, (*ground)->shapes()));
        return std::move(*ground);
    }

    std::shared_ptr<const HeightSource> heights_;
    GroundSettings settings_;
    std::unique_ptr<Ground> ground_;
    std::vector<Stroke> done_, undone_;
    WorldPos at_;
    int hashes_ = 0;
};

TEST(ScenarioHash, IsThatOfAGroundWithoutTiles) {
    for (const char* name : {"footprints", "mines", "keeps"}) {
        SCOPED_TRACE(name);
        Problems problems;
        const auto scenario = read_scenario(std::string(TILTH_SOURCE_DIR "/demo/scenarios/") + name + ".toml",
                                            {shape_names(kStamps), has_stat}, problems);
        ASSERT_TRUE(scenario) << problems.report(name);
        const auto heights = load_heights(scenario->terrain.heights);
        ASSERT_TRUE(heights) << heights.error().message;
        Replay replay(*heights, scenario->terrain.settings.ground);
        replay.play(*scenario);
        EXPECT_GE(replay.hashes_seen(), 1);
    }
}

}  // namespace
}  // namespace tilth::demo
