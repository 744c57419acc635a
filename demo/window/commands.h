// What keys and mouse mean: input of one frame to camera motion, brush changes and actions. Pure; no window, no GL.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "demo/scenario/shown_detail.h"
#include "tilth/core/vec.h"
#include "tilth/ground/stamp.h"

namespace tilth::demo {

enum class Key {
    W,
    A,
    S,
    D,
    Q,
    E,
    Shift,
    Control,  // held
    Digit1,
    Digit2,
    Digit3,
    Digit4,
    Digit5,
    Digit6,
    Digit7,
    Digit8,
    Digit9,
    BracketLeft,
    BracketRight,
    X,
    R,
    T,
    G,
    Y,
    Z,
    F1,
    F2,
    F3,
    F4,
    F5,
    F6,
    F7,
    F12,
    Escape,  // pressed
};

/// One frame's input.
struct Input {
    std::set<Key> held;                 ///< keys that are down
    std::vector<Key> pressed;           ///< keys that went down in this frame, in order
    double mouse_dx = 0, mouse_dy = 0;  ///< pixels, right and down
    double wheel = 0;                   ///< notches, away from the user
    bool left_down = false, left_pressed = false, right_down = false;
    double dt_s = 0;
};

/// What a click leaves on the ground.
struct Brush {
    std::size_t shape = 0;  ///< index in the library's order
    double radius_m = 3;
    double depth_m = 0.6;  ///< follows the radius
    bool digs = true;
    StampRule rule = StampRule::Add;
};

/// What the frame's input asks for.
struct Commands {
    Vec3d move;  ///< right, up, forward of the camera, metres
    double yaw_rad = 0, pitch_rad = 0;
    bool stamp = false;     ///< a click: one stamp at the cursor
    bool drag = false;      ///< the button is held: the path goes on to the cursor
    bool teleport = false;  ///< to the cursor
    bool walk = false;      ///< walking on, or flying again
    bool overlay = false;   ///< the residency map, on or off
    bool undo = false, redo = false;
    bool save = false;  ///< in the background
    bool help = false, screenshot = false, quit = false;
};

/// Motion and actions. `speed_m_per_s` without Shift; Shift is eight times as fast.
Commands commands_of(const Input& input, double speed_m_per_s);

/// The brush after the frame's input. Radius by a tenth a notch within `least_radius_m`..`most_radius_m`.
Brush changed(Brush brush, const Input& input, std::size_t shapes, double least_radius_m, double most_radius_m);

/// How detail is shown after the frame's input: each key takes the next of its kind, with Shift the one before;
/// F7 curves coarse triangles, or no longer.
ShownDetail changed(ShownDetail shown, const Input& input);

/// "hybrid high", and what else there is: "hybrid high, phong, shows fetches".
std::string title_of(const ShownDetail& shown);

/// The stamp that a brush leaves where the ground was `ground_m` high under the cursor: `min` and `max` cut or fill to
/// a level, `set` makes it flat, `smooth` takes half the bumps away. Brushes of less than `coarse_from_m` radius work
/// on the detail map, where levels are offsets from undisturbed ground: theirs is 0. The shape's number is the caller's
/// to set.
StampRequest stamp_of(const Brush& brush, WorldPos centre, double ground_m, double coarse_from_m);

/// The keys, for people.
std::string help_text();

}  // namespace tilth::demo
