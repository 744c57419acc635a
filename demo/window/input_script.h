// A fixed piece of input for smoke tests of the window: every command once. Pure.
#pragma once

#include "demo/window/commands.h"

namespace tilth::demo {

/// Input of frame `frame` (from 0): help, fly, look, choose a crater, stamp, drag, next rule, screenshot,
/// residency map, walk, screenshot, teleport, fly, undo twice, redo, save, another
/// backend, preset and debug view, curved triangles. The cursor is
/// the picture's middle plus what `mouse_dx` and `mouse_dy` add up to.
Input scripted_input(long frame);

}  // namespace tilth::demo
