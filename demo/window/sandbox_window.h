// The interactive sandbox: flies over a world and dents it.
#pragma once

#include <filesystem>
#include <string>

#include "demo/player/viewer.h"
#include "demo/scenario/scenario.h"
#include "tilth/terrain.h"

struct GLFWwindow;

namespace tilth::demo {

struct WindowSettings {
    ViewPart view;
    double low_m = 0, high_m = 100;  ///< range of the original heights, for the tint
    Viewer start;
    ShownDetail shown;                ///< as the world shows it
    std::filesystem::path out = ".";  ///< where F12 writes screenshot-N.png
    long frames = 0;                  ///< leave after so many; 0: when the user does
    bool script = false;              ///< feeds `scripted_input` in place of keys and mouse
};

/// Runs until Esc, the window's cross or the last frame. `window`'s context is current and the world's.
/// Fails when GL refuses something.
Result<void> run_window(GLFWwindow* window, Terrain& terrain, const WindowSettings& settings);

}  // namespace tilth::demo
