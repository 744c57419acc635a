// What keys and mouse mean, where the cursor's ray goes, how a dragged path is spaced. No window.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "demo/window/commands.h"
#include "demo/window/fly_camera.h"
#include "demo/window/foot_steps.h"
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
    const auto stamp = [&](double coarse_from_m) { return stamp_of(brush, {1, 2}, 30, coarse_from_m); };
    EXPECT_EQ(stamp(0).amplitude_m, -2);
    EXPECT_FALSE(stamp(0).level_m);
    brush.rule = StampRule::Min;
    EXPECT_EQ(stamp(0).level_m, 30);
    brush.rule = StampRule::Set;
    EXPECT_EQ(stamp(0).amplitude_m, 0) << "set flattens at the ground's height";
    brush.rule = StampRule::Smooth;
    EXPECT_TRUE(stamp(0).amplitude_m > 0 && stamp(0).amplitude_m <= 1);
}

TEST(Commands, SmallBrushesWorkOnTheDetailMap) {
    Brush brush{.radius_m = 2, .rule = StampRule::Min};
    EXPECT_EQ(stamp_of(brush, {1, 2}, 30, 2).map, MapChoice::Coarse);
    const StampRequest small = stamp_of(brush, {1, 2}, 30, 2.001);
    EXPECT_EQ(small.map, MapChoice::Detail);
    EXPECT_FALSE(small.level_m) << "an offset from undisturbed ground, not a height above the sea";
}

TEST(Commands, KeysOfTheTiles) {
    const Commands none = commands_of({}, 1);
    EXPECT_FALSE(none.overlay || none.walk || none.teleport);
    EXPECT_TRUE(commands_of({.pressed = {Key::F2}}, 1).overlay);
    EXPECT_TRUE(commands_of({.pressed = {Key::G}}, 1).walk);
    EXPECT_TRUE(commands_of({.pressed = {Key::T}}, 1).teleport);
    for (const char* key : {"G ", "T ", "F2 "}) EXPECT_NE(help_text().find(key), std::string::npos) << key;
}

TEST(Commands, KeysOfUndoAndSaving) {
    EXPECT_FALSE(commands_of({.pressed = {Key::Z, Key::Y}}, 1).undo) << "only with Control";
    EXPECT_FALSE(commands_of({.pressed = {Key::Z, Key::Y}}, 1).redo);
    const Commands undo = commands_of({.held = {Key::Control}, .pressed = {Key::Z}}, 1),
                   redo = commands_of({.held = {Key::Control}, .pressed = {Key::Y}}, 1);
    EXPECT_TRUE(undo.undo && !undo.redo && !undo.save);
    EXPECT_TRUE(redo.redo && !redo.undo && !redo.save);
    EXPECT_FALSE(commands_of({.held = {Key::Control, Key::Z}}, 1).undo) << "a key that is held down undoes once";
    EXPECT_TRUE(commands_of({.pressed = {Key::F5}}, 1).save);
    for (const char* key : {"Ctrl+Z ", "Ctrl+Y ", "F5 "}) EXPECT_NE(help_text().find(key), std::string::npos) << key;
}

TEST(Commands, KeysOfTheDetail) {
    const auto after = [](ShownDetail shown, std::vector<Key> keys, std::set<Key> held = {}) {
        return changed(shown, {.held = std::move(held), .pressed = std::move(keys)});
    };
    EXPECT_EQ(after({}, {}), ShownDetail{});
    EXPECT_EQ(after({}, {Key::F3}).backend, DetailBackend::Parallax);
    EXPECT_EQ(after({}, {Key::F3}, {Key::Shift}).backend, DetailBackend::Hybrid) << "before the first comes the last";
    EXPECT_EQ(after({}, {Key::F4}).preset, DetailPreset::High);
    EXPECT_EQ(after({}, {Key::F6}).debug, DebugView::Wireframe);
    EXPECT_EQ(after({}, {Key::F6}, {Key::Shift}).debug, DebugView::Error);
    EXPECT_EQ(after({}, {}, {Key::F3, Key::F4, Key::F6, Key::F7}), ShownDetail{})
        << "a key that is held down counts once";
    EXPECT_TRUE(after({}, {Key::F7}).phong);
    EXPECT_TRUE(after({.phong = true}, {Key::F3, Key::F4, Key::F6}).phong) << "another backend keeps it";
    ShownDetail shown;
    for (int i = 0; i < 5; ++i) shown = after(shown, {Key::F3});
    for (int i = 0; i < 4; ++i) shown = after(shown, {Key::F4});
    for (int i = 0; i < 7; ++i) shown = after(shown, {Key::F6});
    for (int i = 0; i < 2; ++i) shown = after(shown, {Key::F7});
    EXPECT_EQ(shown, ShownDetail{}) << "round";
    EXPECT_EQ(title_of({DetailBackend::Hybrid, DetailPreset::High}), "hybrid high");
    EXPECT_EQ(title_of({DetailBackend::None, DetailPreset::Low, DebugView::Fetches}), "none low, shows fetches");
    EXPECT_EQ(title_of({.phong = true}), "none medium, phong");
    for (const char* key : {"F3 ", "F4 ", "F6 ", "F7 "}) EXPECT_NE(help_text().find(key), std::string::npos) << key;
}

TEST(Commands, TheScriptUsesEveryKindOfCommand) {
    bool moves = false, looks = false, stamps = false, drags = false, helps = false, shoots = false, quits = false;
    bool maps = false, walks = false, teleports = false, undoes = false, redoes = false, saves = false;
    ShownDetail shown;
    for (long frame = 0; frame < 22; ++frame) {
        const Commands c = commands_of(scripted_input(frame), 1);
        moves |= c.move.z != 0, looks |= c.yaw_rad != 0, stamps |= c.stamp, drags |= c.drag;
        helps |= c.help, shoots |= c.screenshot, quits |= c.quit;
        maps |= c.overlay, walks |= c.walk, teleports |= c.teleport;
        shown = changed(shown, scripted_input(frame));
        undoes |= c.undo, redoes |= c.redo, saves |= c.save;
    }
    EXPECT_TRUE(moves && looks && stamps && drags && helps && shoots && maps && walks && teleports);
    EXPECT_TRUE(undoes && redoes && saves);
    EXPECT_TRUE(shown.backend != DetailBackend::None && shown.preset != DetailPreset::Medium);
    EXPECT_NE(shown.debug, DebugView::Off);
    EXPECT_TRUE(shown.phong);
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

TEST(FlyCamera, OnFootItKeepsItsHeightAndPace) {
    Commands ahead;
    ahead.move = {0, 5, 3};
    const FlyCamera down = walked(FlyCamera::looking({10, 5, 20}, {1, -4, 0}), ahead);
    EXPECT_NEAR(down.eye.x, 13, 1e-12) << "looking down slows nobody";
    EXPECT_EQ(down.eye.y, 5);
    EXPECT_NEAR(down.eye.z, 20, 1e-12);
    Commands aside;
    aside.move = {2, 0, 0}, aside.pitch_rad = 0.1;
    const FlyCamera right = walked(FlyCamera::looking({0, 0, 0}, {0, 0, -1}), aside);
    EXPECT_NEAR(right.eye.x, 2, 1e-12);
    EXPECT_NEAR(right.eye.z, 0, 1e-12);
    EXPECT_NEAR(right.pitch_rad, 0.1, 1e-12);
}

TEST(FarCorner, IsAcrossTheMap) {
    const GridSpec posts{.origin = {100, 200}, .spacing_m = 2, .width = 11, .depth = 6};
    EXPECT_EQ(far_corner(posts, {101, 201}), (WorldPos{120, 210}));
    EXPECT_EQ(far_corner(posts, {119, 201}), (WorldPos{100, 210}));
    EXPECT_EQ(far_corner(posts, {1e6, 1e6}), (WorldPos{100, 200}));
}

/// The print's place beside a way along `direction`, and which way its toes point, in the world. The image's own x axis
/// (mirrored first, then turned) is what shows ahead.
struct Foot {
    double along_m, left_m, toes_along, toes_left;
};
Foot foot_of(const StampRequest& print, Vec3d direction) {
    const double length = std::hypot(direction.x, direction.z), dx = direction.x / length, dz = direction.z / length;
    const double flip = print.mirror ? -1 : 1, toes_x = flip * std::cos(print.rotation_rad),
                 toes_z = -flip * std::sin(print.rotation_rad);
    return {print.centre.x * dx + print.centre.z * dz, print.centre.x * dz - print.centre.z * dx,
            toes_x * dx + toes_z * dz, toes_x * dz - toes_z * dx};
}

TEST(FootSteps, FeetAlternateWhateverTheFramesAndTheWay) {
    const BootSize boots;
    for (const Vec3d& direction : {Vec3d{1, 0, 0}, Vec3d{0, 0, 1}, Vec3d{-3, 0, 4}})
        for (const int frames : {3, 40, 1000}) {
            const double length = std::hypot(direction.x, direction.z);
            FootSteps steps;
            std::vector<StampRequest> prints = steps.step({0, 0}, boots, {6});
            for (int i = 1; i <= frames; ++i) {
                const double walked_m = 6.0 * i / frames;
                for (const StampRequest& print :
                     steps.step({direction.x / length * walked_m, direction.z / length * walked_m}, boots, {6}))
                    prints.push_back(print);
            }
            const double first_m = 6.0 / frames;  // with the first move
            ASSERT_EQ(prints.size(), std::size_t(std::floor((6.0 - first_m) / 0.75 + 1e-6)) + 1) << frames;
            for (std::size_t i = 0; i < prints.size(); ++i) {
                const Foot foot = foot_of(prints[i], direction);
                EXPECT_NEAR(foot.along_m, first_m + 0.75 * double(i), 1e-9);
                EXPECT_NEAR(foot.left_m, i % 2 == 0 ? 0.15 : -0.15, 1e-9) << "left foot first";
                EXPECT_EQ(prints[i].mirror, i % 2 == 0) << "the image is a right boot";
                EXPECT_NEAR(foot.toes_along, 1, 1e-6) << "toes ahead, mirrored or not";
                EXPECT_NEAR(foot.toes_left, 0, 1e-6);
                EXPECT_EQ(prints[i].map, MapChoice::Detail);
                EXPECT_EQ(prints[i].rule, StampRule::Min);
                EXPECT_EQ(prints[i].shape, ShapeId{6});
                EXPECT_EQ(prints[i].amplitude_m, -0.03);
                EXPECT_EQ(prints[i].radius_m, 0.17);
            }
        }
}

TEST(FootSteps, StandingAndJumpingLeaveNoTrail) {
    const BootSize boots;
    FootSteps steps;
    EXPECT_TRUE(steps.step({0, 0}, boots, {6}).empty());
    EXPECT_TRUE(steps.step({0, 0}, boots, {6}).empty()) << "who has not moved has not trodden";
    EXPECT_EQ(steps.step({0.1, 0}, boots, {6}).size(), 1u);
    EXPECT_TRUE(steps.step({0.1, 0}, boots, {6}).empty());
    EXPECT_TRUE(steps.step({500, 0}, boots, {6}).empty()) << "nobody walks half a kilometre in a frame";
    EXPECT_EQ(steps.step({500.1, 0}, boots, {6}).size(), 1u) << "and goes on there";
    steps.stop();
    EXPECT_TRUE(steps.step({501, 0}, boots, {6}).empty());
}

TEST(FootSteps, BootsAreTenTexelsLongWhereTexelsAreWide) {
    EXPECT_EQ(boots_for(1.0 / 30).radius_m, 0.17);
    EXPECT_EQ(boots_for(0.001).stride_m, 0.75);
    EXPECT_NEAR(boots_for(1.0 / 3).radius_m, 1.7, 1e-12);
    EXPECT_NEAR(boots_for(1.0 / 3).stride_m, 7.5, 1e-12);
    EXPECT_EQ(boots_for(1.0 / 3).eye_m, 2);
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
