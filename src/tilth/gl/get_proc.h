// How the library finds GL: the host hands in its own look-up function. No GL header here.
#pragma once

namespace tilth::gl {

/// Returns the address of the GL function called `name` in the current context, or nullptr.
/// `eglGetProcAddress`, `glfwGetProcAddress` and `OSMesaGetProcAddress` fit after a cast.
using GetProc = void* (*)(const char* name);

}  // namespace tilth::gl
