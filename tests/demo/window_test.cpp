// What keys and mouse mean, where the cursor's ray goes, how a dragged path is spaced. No window.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "demo/window/commands.h"
#include "demo/window/fly_camera.h"
#include "demo/window/input_script.h"
#include "demo/window/path_brush.h"

namespace tilth::demo {
namespace {

TEST(Commands, HeldKeysMoveBySpeedAndTime) {
    Input input{.held = {Key::W, Key::D, Key::Q}, .dt_s = 0.5};
    Commands c = commands_of(input, 10);
    EXPECT_EQ(c.move, (Vec3d{5, -5, 5}));
    input.held.insert({Key::S, Key::Shift});
    c = commands_of(input, 10);
    EXPECT_EQ(c.move, (Vec3d{40, -40, 0})) << "opposite keys cancel, Shift is eight times as fast";
}

TEST(Commands, TheMouseTurnsOnlyWithTheRightButton) {
    Input input{.mouse_dx = 10, .mouse_dy = 10};
    EXPECT_EQ(commands_of(input, 1).yaw_rad, 0);
    input.right_down = true;
    EXPECT_GT(commands_of(input, 1).yaw_rad, 0);
    EXPECT_LT(commands_of(input, 1).pitch_rad, 0) << "mouse down looks down";
}

TEST(Commands, AClickStampsOnceThenDrags) {
    Input input{.left_down = true, .left_pressed = true};
    EXPECT_TRUE(commands_of(input, 1).stamp);
    EXPECT_FALSE(commands_of(input, 1).drag);
    input.left_pressed = false;
    EXPECT_FALSE(commands_of(input, 1).stamp);
    EXPECT_TRUE(commands_of(input, 1).drag);
}

TEST(Commands, KeysOfTheBrush) {
    const auto after = [](std::vector<Key> keys, double wheel = 0) {
        return changed(Brush{}, {.pressed = std::move(keys), .wheel = wheel}, 7, 1, 50);
    };
    EXPECT_EQ(after({Key::Digit5}).shape, 4u);
    EXPECT_EQ(after({Key::Digit9}).shape, 0u) << "there is no ninth shape";
    EXPECT_EQ(after({Key::BracketLeft}).shape, 6u) << "before the first comes the last";
    EXPECT_EQ(after({Key::Digit7, Key::BracketRight}).shape, 0u);
    EXPECT_FALSE(after({Key::X}).digs);
    EXPECT_TRUE(after({Key::X, Key::X}).digs);
    EXPECT_EQ(after({Key::R}).rule, StampRule::Min);
    EXPECT_EQ(after({Key::R, Key::R, Key::R, Key::R, Key::R}).rule, StampRule::Add);
    EXPECT_NEAR(after({}, 1).radius_m, Brush{}.radius_m * 1.1, 1e-12);
    EXPECT_EQ(after({}, 1000).radius_m, 50);
    EXPECT_EQ(after({}, -1000).radius_m, 1);
}

TEST(Commands, AStampAsksForWhatItsRuleNeeds) {
    Brush brush{.depth_m = 2, .digs = true};
    EXPECT_EQ(stamp_of(brush, {1, 2}, 30).amplitude_m, -2);
    EXPECT_FALSE(stamp_of(brush, {1, 2}, 30).level_m);
    brush.rule = StampRule::Min;
    EXPECT_EQ(stamp_of(brush, {1, 2}, 30).level_m, 30);
    brush.rule = StampRule::Set;
    EXPECT_EQ(stamp_of(brush, {1, 2}, 30).amplitude_m, 0) << "set flattens at the ground's height";
    brush.rule = StampRule::Smooth;
    const double share = stamp_of(brush, {1, 2}, 30).amplitude_m;
    EXPECT_TRUE(share > 0 && share <= 1);
}

TEST(Commands, TheScriptUsesEveryKindOfCommand) {
    bool moves = false, looks = false, stamps = false, drags = false, helps = false, shoots = false, quits = false;
    for (long frame = 0; frame < 12; ++frame) {
        const Commands c = commands_of(scripted_input(frame), 1);
        moves |= c.move.z != 0, looks |= c.yaw_rad != 0, stamps |= c.stamp, drags |= c.drag;
        helps |= c.help, shoots |= c.screenshot, quits |= c.quit;
    }
    EXPECT_TRUE(moves && looks && stamps && drags && helps && shoots);
    EXPECT_FALSE(quits) << "--frames ends it";
}

TEST(FlyCamera, LookingAndForwardAreInverse) {
    for (const Vec3d& f : {Vec3d{0, 0, -1}, Vec3d{1, 0, 0}, Vec3d{-1, -1, 1}, Vec3d{0.3, 0.5, 0.2}}) {
        const double length = std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z);
        const Vec3d got = FlyCamera::looking({}, f).forward();
        EXPECT_NEAR(got.x, f.x / length, 1e-12);
        EXPECT_NEAR(got.y, f.y / length, 1e-12);
        EXPECT_NEAR(got.z, f.z / length, 1e-12);
    }
}

TEST(FlyCamera, ForwardGoesWhereItLooksAndNeverOverTheTop) {
    FlyCamera camera = FlyCamera::looking({10, 5, 20}, {1, 0, 0});
    Commands c;
    c.move = {0, 0, 3};
    EXPECT_NEAR(moved(camera, c).eye.x, 13, 1e-12);
    c = {};
    c.move = {2, 1, 0};  // right of +x is +z
    EXPECT_NEAR(moved(camera, c).eye.z, 22, 1e-12);
    EXPECT_NEAR(moved(camera, c).eye.y, 6, 1e-12);
    c = {};
    c.pitch_rad = 10;
    EXPECT_LT(moved(camera, c).pitch_rad, std::numbers::pi / 2);
}

TEST(FlyCamera, RaysThroughThePicture) {
    const FlyCamera camera = FlyCamera::looking({}, {0, 0, -1});
    const View view{.eye = {},
                    .forward = camera.forward(),
                    .up = {0, 1, 0},
                    .fov_y_rad = std::numbers::pi / 2,
                    .width = 200,
                    .height = 100};
    const auto ray = [&](double x, double y) { return ray_through(view, camera.right(), x, y); };
    EXPECT_NEAR(ray(100, 50).x, 0, 1e-12);
    EXPECT_NEAR(ray(100, 50).z, -1, 1e-12);
    EXPECT_NEAR(ray(100, 0).y, 1, 1e-12) << "top edge at 45 degrees";
    EXPECT_NEAR(ray(200, 50).x, 2, 1e-12) << "right edge, twice as wide";
    EXPECT_NEAR(ray(0, 100).x, -2, 1e-12);
    EXPECT_NEAR(ray(0, 100).y, -1, 1e-12);
}

TEST(PathBrush, StampsAreSpacedByDistanceWhateverTheFrames) {
    const auto drawn = [](int frames) {
        PathBrush brush;
        std::vector<WorldPos> stamps = brush.press({0, 0});
        for (int i = 1; i <= frames; ++i)
            for (const WorldPos& at : brush.drag({10.0 * i / frames, 0}, 0.75)) stamps.push_back(at);
        return stamps;
    };
    for (const int frames : {1, 7, 100}) {
        const auto stamps = drawn(frames);
        ASSERT_EQ(stamps.size(), 14u) << frames;  // 0, 0.75, ... 9.75
        for (std::size_t i = 0; i < stamps.size(); ++i) EXPECT_NEAR(stamps[i].x, 0.75 * double(i), 1e-9);
    }
}

TEST(PathBrush, AStandingCursorStampsOnceAndAJumpLaysNoRoad) {
    PathBrush brush;
    EXPECT_EQ(brush.press({0, 0}).size(), 1u);
    EXPECT_TRUE(brush.drag({0, 0}, 1).empty());
    EXPECT_EQ(brush.drag({1e6, 0}, 1).size(), 1u);
    brush.release();
    EXPECT_EQ(brush.drag({5, 5}, 1).size(), 1u) << "a drag that missed its press starts a path";
}

}  // namespace
}  // namespace tilth::demo
