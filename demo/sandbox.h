// The sandbox from its arguments to its exit status.
#pragma once

#include "demo/arguments.h"

namespace tilth::demo {

/// Reads the scenario (or makes the default world), opens context and world, plays, writes statistics, and opens the
/// window if there is to be one. Exit status: 0 all done, 1 a step failed, 2 nothing was started; messages on stderr.
int run_sandbox(const Arguments& arguments);

}  // namespace tilth::demo
