#include "demo/window/commands.h"

#include <algorithm>
#include <cmath>

#include "demo/scenario/names.h"

namespace tilth::demo {

namespace {

constexpr double kLookRadiansAPixel = 0.0035;  // taste: a 900-pixel sweep turns by half a circle
constexpr double kShiftFactor = 8;
constexpr double kDepthOfRadius = 0.2;  // taste: the slope of a natural crater
constexpr int kRules = 5;

double axis(const Input& input, Key plus, Key minus) {
    return double(input.held.contains(plus)) - double(input.held.contains(minus));
}

}  // namespace

Commands commands_of(const Input& input, double speed_m_per_s) {
    Commands out;
    const double step_m = speed_m_per_s * (input.held.contains(Key::Shift) ? kShiftFactor : 1) * input.dt_s;
    out.move = {axis(input, Key::D, Key::A) * step_m, axis(input, Key::E, Key::Q) * step_m,
                axis(input, Key::W, Key::S) * step_m};
    if (input.right_down) {
        out.yaw_rad = input.mouse_dx * kLookRadiansAPixel;
        out.pitch_rad = -input.mouse_dy * kLookRadiansAPixel;
    }
    out.stamp = input.left_pressed;
    out.drag = input.left_down && !input.left_pressed;
    const bool control = input.held.contains(Key::Control);
    for (const Key key : input.pressed) {
        out.help |= key == Key::F1;
        out.undo |= control && key == Key::Z;
        out.redo |= control && key == Key::Y;
        out.save |= key == Key::F5;
        out.overlay |= key == Key::F2;
        out.teleport |= key == Key::T;
        out.walk |= key == Key::G;
        out.screenshot |= key == Key::F12;
        out.quit |= key == Key::Escape;
    }
    return out;
}

Brush changed(Brush brush, const Input& input, std::size_t shapes, double least_radius_m, double most_radius_m) {
    for (const Key key : input.pressed) {
        if (key >= Key::Digit1 && key <= Key::Digit9) {
            const auto index = static_cast<std::size_t>(key) - static_cast<std::size_t>(Key::Digit1);
            if (index < shapes) brush.shape = index;
        }
        if (key == Key::BracketRight) brush.shape = (brush.shape + 1) % shapes;
        if (key == Key::BracketLeft) brush.shape = (brush.shape + shapes - 1) % shapes;
        if (key == Key::X) brush.digs = !brush.digs;
        if (key == Key::R) brush.rule = static_cast<StampRule>((static_cast<int>(brush.rule) + 1) % kRules);
    }
    if (input.wheel != 0) {
        brush.radius_m = std::clamp(brush.radius_m * std::pow(1.1, input.wheel), least_radius_m, most_radius_m);
        brush.depth_m = brush.radius_m * kDepthOfRadius;
    }
    return brush;
}

ShownDetail changed(ShownDetail shown, const Input& input) {
    const bool back = input.held.contains(Key::Shift);
    const auto next = [back](auto value, const std::vector<std::string>& names) {
        const std::size_t step = back ? names.size() - 1 : 1;
        return static_cast<decltype(value)>((static_cast<std::size_t>(value) + step) % names.size());
    };
    for (const Key key : input.pressed) {
        if (key == Key::F3) shown.backend = next(shown.backend, kBackendNames);
        if (key == Key::F4) shown.preset = next(shown.preset, kPresetNames);
        if (key == Key::F6) shown.debug = next(shown.debug, kDebugNames);
        if (key == Key::F7) shown.phong = !shown.phong;
    }
    return shown;
}

std::string title_of(const ShownDetail& shown) {
    std::string title = std::string(name_of(shown.backend)) + " " + std::string(name_of(shown.preset));
    if (shown.phong) title += ", phong";
    if (shown.debug != DebugView::Off) title += ", shows " + kDebugNames[static_cast<std::size_t>(shown.debug)];
    return title;
}

StampRequest stamp_of(const Brush& brush, WorldPos centre, double ground_m, double coarse_from_m) {
    const bool coarse = brush.radius_m >= coarse_from_m;
    StampRequest request{.shape = {},
                         .centre = centre,
                         .radius_m = brush.radius_m,
                         .amplitude_m = brush.digs ? -brush.depth_m : brush.depth_m,
                         .map = coarse ? MapChoice::Coarse : MapChoice::Detail,
                         .rule = brush.rule,
                         .level_m = {},
                         .rotation_rad = 0,
                         .mirror = false,
                         .key = {}};
    if (brush.rule == StampRule::Smooth) request.amplitude_m = 0.5;
    if (brush.rule == StampRule::Set) request.amplitude_m = 0;
    if (coarse && (brush.rule == StampRule::Min || brush.rule == StampRule::Max || brush.rule == StampRule::Set))
        request.level_m = ground_m;
    return request;
}

std::string help_text() {
    return "W A S D move, E Q up and down, Shift faster, right button looks around\n"
           "left button stamps, dragging lays a path; wheel changes the radius\n"
           "1-9 or [ ] choose the stamp, X digs or piles up, R changes the rule\n"
           "G walks and leaves boot prints, or flies again; T teleports to the cursor (off the ground: to the far "
           "corner)\n"
           "F2 residency map: yellow loading, orange uploading, green resident, framed drawn, red dot dirty, violet "
           "saving\n"
           "F3 backend that shows fine detail, F4 its preset, F6 debug view (wireframe, level, tile, backend, fetches, "
           "error): the next, with Shift the one before; F7 curves coarse triangles (Phong tessellation), or no "
           "longer\n"
           "Ctrl+Z takes the last stroke back, Ctrl+Y does it again; a drag is one stroke, and so is a walk\n"
           "F5 saves (with --store DIR every stroke is kept in any case)\n"
           "F12 screenshot, F1 this help, Esc leaves\n";
}

}  // namespace tilth::demo
