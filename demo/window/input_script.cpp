#include "demo/window/input_script.h"

namespace tilth::demo {

Input scripted_input(long frame) {
    Input input;
    input.dt_s = 1.0 / 60;
    switch (frame) {
        case 0:
            input.pressed = {Key::F1};
            break;
        case 1:
            input.held = {Key::W, Key::E, Key::Shift};
            break;
        case 2:
            input.right_down = true, input.mouse_dx = 20, input.mouse_dy = 10;
            break;
        case 3:
            input.pressed = {Key::Digit5}, input.wheel = 3;
            break;
        case 4:
            input.left_down = input.left_pressed = true;
            break;
        case 5:
        case 6:
            input.left_down = true, input.mouse_dx = 40;
            break;
        case 7:
            input.pressed = {Key::X, Key::R};
            break;
        case 8:
            input.pressed = {Key::F12};
            break;
        case 9:
            input.pressed = {Key::F2, Key::G};
            break;
        case 10:
        case 11:
            input.held = {Key::W, Key::Shift};
            break;
        case 12:
            input.pressed = {Key::F12};
            break;
        case 13:
            input.pressed = {Key::T};
            break;
        case 14:
            input.pressed = {Key::G};
            break;
        case 15:
        case 16:
            input.held = {Key::Control}, input.pressed = {Key::Z};
            break;
        case 17:
            input.held = {Key::Control}, input.pressed = {Key::Y};
            break;
        case 18:
            input.pressed = {Key::F5};
            break;
        case 19:
            input.pressed = {Key::F3, Key::F4};
            break;
        case 20:
            input.pressed = {Key::F6};
            break;
        case 21:
            input.pressed = {Key::F7};
            break;
        default:
            break;
    }
    return input;
}

}  // namespace tilth::demo
