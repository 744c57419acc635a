#include "demo/gl/gl_route.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <cstdlib>

namespace tilth::demo {

namespace {

void* look_up(const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); }

Error glfw_error(const char* what) {
    const char* why = nullptr;
    glfwGetError(&why);
    return {ErrorCode::GlContext, text("--context glfw: ", what, ": ", why == nullptr ? "unknown reason" : why,
                                       "; use --headless with --context egl or osmesa where there is no display")};
}

}  // namespace

void GlRoute::CloseWindow::operator()(GLFWwindow* window) const {
    glfwDestroyWindow(window);
    glfwTerminate();
}

Result<GlRoute> GlRoute::open_glfw(const std::string& title, int width, int height, bool visible) {
    if (glfwInit() != GLFW_TRUE) return glfw_error("GLFW cannot start");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_VISIBLE, visible ? GLFW_TRUE : GLFW_FALSE);
    GLFWwindow* const made = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (made == nullptr) {
        Error error = glfw_error("no window with OpenGL 3.3 core");
        glfwTerminate();
        return error;
    }
    GlRoute route;
    route.name_ = "glfw";
    route.window_.reset(made);
    glfwMakeContextCurrent(made);
    return route;
}

Result<GlRoute> GlRoute::offscreen(const std::string& name) {
    if (name == "glfw") return open_glfw("tilth", 64, 64, false);
    const auto kind = context::route_of(name);
    if (!kind) return kind.error();
    auto made = context::OffscreenContext::create(*kind);
    if (!made) return made.error();
    GlRoute route;
    route.name_ = name;
    route.offscreen_ = std::move(*made);
    return route;
}

Result<GlRoute> GlRoute::window(const std::string& title, int width, int height) {
    return open_glfw(title, width, height, true);
}

gl::GetProc GlRoute::get_proc() const { return offscreen_ ? offscreen_->get_proc() : look_up; }

bool has_display() {
    const auto named = [](const char* variable) {
        const char* value = std::getenv(variable);
        return value != nullptr && *value != '\0';
    };
    return named("DISPLAY") || named("WAYLAND_DISPLAY");
}

}  // namespace tilth::demo
