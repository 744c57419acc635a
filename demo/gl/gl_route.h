// Where the sandbox's GL context comes from: EGL or OSMesa without a window, or a GLFW window, hidden or shown.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tilth/context/offscreen_context.h"
#include "tilth/core/result.h"

struct GLFWwindow;

namespace tilth::demo {

/// A current GL context of at least 3.3 core for as long as it lives. One GLFW route at a time in a process.
class GlRoute {
public:
    /// `name`: "egl", "osmesa" or "glfw" (a hidden window; needs a display). Fails with `GlContext`.
    static Result<GlRoute> offscreen(const std::string& name);
    /// A visible window of GLFW. Fails with `GlContext` where there is no display.
    static Result<GlRoute> window(const std::string& title, int width, int height);

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] gl::GetProc get_proc() const;
    /// Nullptr for EGL and OSMesa.
    [[nodiscard]] GLFWwindow* window() const { return window_.get(); }

private:
    struct CloseWindow {
        void operator()(GLFWwindow* window) const;
    };
    static Result<GlRoute> open_glfw(const std::string& title, int width, int height, bool visible);

    std::string name_;
    std::optional<context::OffscreenContext> offscreen_;
    std::unique_ptr<GLFWwindow, CloseWindow> window_;
};

/// Whether a window can be opened at all (X11 or Wayland is named in the environment).
bool has_display();

}  // namespace tilth::demo
