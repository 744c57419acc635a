// Where a walk's frames and footprints lie, how long a wait is: closed forms.
#include <gtest/gtest.h>

#include "demo/player/walk_plan.h"

namespace tilth::demo {
namespace {

WalkStep walk_to(WorldPos to, double speed, double dt) { return {.to = to, .speed_m_per_s = speed, .dt_s = dt}; }

TEST(WalkPlan, StepsAreEqualAndTheLastOneEndsAtTheGoal) {
    const WalkPlan plan = plan_walk({1, 2}, walk_to({4, 6}, 2.0, 0.5));  // 3-4-5: 5 m at 1 m a frame
    EXPECT_EQ(plan.frames, 5);
    EXPECT_EQ(plan.length_m, 5);
    EXPECT_NEAR(plan.position(1).x, 1.6, 1e-12);
    EXPECT_NEAR(plan.position(1).z, 2.8, 1e-12);
    EXPECT_EQ(plan.position(5), (WorldPos{4, 6}));
    EXPECT_EQ(plan_walk({0, 0}, walk_to({5.25, 0}, 2.0, 0.5)).frames, 6) << "a rest is a frame of its own";
}

TEST(WalkPlan, RoundingMakesNoExtraFrame) {
    EXPECT_EQ(plan_walk({0, 0}, walk_to({0.3, 0}, 1.0, 0.1)).frames, 3);             // 0.1 * 3 > 0.3 in doubles
    EXPECT_EQ(plan_walk({0, 0}, walk_to({136.8, 0}, 2.28, 1.0 / 60)).frames, 3600);  // one minute
}

TEST(WalkPlan, AWalkToWhereOneStandsHasNoFrames) { EXPECT_EQ(plan_walk({3, 3}, walk_to({3, 3}, 1, 1)).frames, 0); }

TEST(WalkPlan, FarFromTheOriginTheGoalIsStillExact) {
    const WalkPlan plan = plan_walk({1e7, 1e7}, walk_to({1e7 + 10, 1e7}, 1.0, 0.1));
    EXPECT_EQ(plan.frames, 100);
    EXPECT_NEAR(plan.position(50).x, 1e7 + 5, 1e-8);
}

TEST(Prints, OneAtTheStartThenOneEveryStride) {
    EXPECT_EQ(prints_until(0, 0.75), 1u);
    EXPECT_EQ(prints_until(0.749, 0.75), 1u);
    EXPECT_EQ(prints_until(0.75, 0.75), 2u);
    EXPECT_EQ(prints_until(0.1 * 3, 0.1), 4u);
    EXPECT_EQ(prints_until(7.5, 0.75), 11u);
}

TEST(WaitPlan, SecondsAreAsManyFramesAsItTakes) {
    WaitStep wait;
    wait.seconds = 1.0;
    wait.dt_s = {0.016667};
    EXPECT_EQ(plan_wait(wait).frames, 60);
    wait.dt_s = {1.0 / 60};
    EXPECT_EQ(plan_wait(wait).frames, 60);
    wait.dt_s = {0.3};
    EXPECT_EQ(plan_wait(wait).frames, 4);
    wait.dt_s = {0.1, 0.4};  // 0.1 0.5 0.6 1.0
    EXPECT_EQ(plan_wait(wait).frames, 4);
    wait.dt_s = {0, 0.5};
    EXPECT_EQ(plan_wait(wait).frames, 4);
    wait.seconds = 0.0;
    EXPECT_EQ(plan_wait(wait).frames, 0);
    wait.seconds = 1000.0;
    wait.dt_s = {0.001};
    EXPECT_EQ(plan_wait(wait).frames, 1'000'000);
}

TEST(WaitPlan, AListIsCycled) {
    const WaitPlan plan = plan_wait({.frames = 5, .seconds = {}, .dt_s = {0.01, 0.02}});
    EXPECT_EQ(plan.frames, 5);
    EXPECT_EQ(plan.dt(0), 0.01);
    EXPECT_EQ(plan.dt(3), 0.02);
    EXPECT_EQ(plan.dt(4), 0.01);
}

}  // namespace
}  // namespace tilth::demo
