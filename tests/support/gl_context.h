// What GL tests share: one context per process and route, a fixture that fails on GL errors, a render target.
//
// The route is that of the environment variable TILTH_TEST_CONTEXT (egl or osmesa; egl if unset). A missing context
// fails the test, unless TILTH_ALLOW_NO_GL is set: then it is skipped, with the reason.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tilth/context/offscreen_context.h"
#include "tilth/gl/api.h"
#include "tilth/gl/device.h"
#include "tilth/gl/objects.h"
#include "tilth/gl/shader_library.h"

namespace tilth::test {

inline context::Route default_route() {
    const char* name = std::getenv("TILTH_TEST_CONTEXT");
    const Result<context::Route> route = context::route_of(name != nullptr ? name : "egl");
    if (!route) {
        std::fprintf(stderr, "TILTH_TEST_CONTEXT: %s\n", route.error().message.c_str());
        std::abort();
    }
    return *route;
}

/// The value of `result`; a failed one ends the test program with its message.
template <class T>
T value(Result<T> result) {
    if (!result) {
        std::fprintf(stderr, "unexpected error: %s\n", result.error().message.c_str());
        std::abort();
    }
    return *std::move(result);
}

/// A context and its device. Made on first use and never destroyed: tests may keep GL objects in statics.
struct TestContext {
    std::unique_ptr<context::OffscreenContext> context;
    std::unique_ptr<gl::Device> device;
    std::string error;  ///< why there is none
};

inline TestContext& test_context(context::Route route) {
    static std::array<TestContext*, 2> made{};
    TestContext*& slot = made[route == context::Route::Egl ? 0 : 1];
    if (slot == nullptr) {
        slot = new TestContext;
        auto context = context::OffscreenContext::create(route, {.debug = true});
        if (!context) {
            slot->error = context.error().message;
            return *slot;
        }
        slot->context = std::make_unique<context::OffscreenContext>(*std::move(context));
        auto device = gl::Device::create(slot->context->get_proc(), {.collect_debug_messages = true});
        if (device)
            slot->device = *std::move(device);
        else
            slot->error = device.error().message;
    } else if (slot->context) {
        static_cast<void>(slot->context->make_current().ok());
    }
    return *slot;
}

/// The device of `route`, its context current. Ends the program if there is none: derive from `GlTest` to fail or
/// skip instead.
inline gl::Device& device(context::Route route = default_route()) {
    TestContext& test_context_of_route = test_context(route);
    if (!test_context_of_route.device) {
        std::fprintf(stderr, "no GL context: %s\n", test_context_of_route.error.c_str());
        std::abort();
    }
    return *test_context_of_route.device;
}

/// Shaders from the source tree.
inline gl::ShaderLibrary shaders(gl::Device& device = test::device()) {
    return gl::ShaderLibrary(device, gl::ShaderSource::folder(TILTH_SOURCE_DIR "/shaders"));
}

/// A test on `route` starts with a current context and ends without a GL error or a message of the driver. The first of
/// these is the last statement of a SetUp: it may skip.
inline void start_with_context(context::Route route) {
    const TestContext& context = test_context(route);
    if (context.device) return;
    if (std::getenv("TILTH_ALLOW_NO_GL") != nullptr) GTEST_SKIP() << "no GL context: " << context.error;
    FAIL() << "no GL context (set TILTH_ALLOW_NO_GL to skip such tests): " << context.error;
}
inline void end_without_errors(context::Route route) {
    TestContext& context = test_context(route);
    if (!context.device) return;
    for (const std::string& error : context.device->take_errors()) ADD_FAILURE() << "GL error: " << error;
    for (const gl::DebugMessage& message : context.device->take_debug_messages())
        ADD_FAILURE() << "GL message (" << message.kind << ", id " << message.id << "): " << message.text;
}

/// Tests on the route of the run.
class GlTest : public ::testing::Test {
protected:
    void SetUp() override { start_with_context(default_route()); }
    void TearDown() override { end_without_errors(default_route()); }
    /// Only valid in a test's body or in SetUp after `GlTest::SetUp` passed.
    static gl::Device& device() { return test::device(); }
    static gl::ShaderLibrary shaders() { return test::shaders(); }
};

/// Tests on each route; `Case` has a member `route`.
template <class Case>
class GlRouteTest : public ::testing::TestWithParam<Case> {
protected:
    void SetUp() override { start_with_context(this->GetParam().route); }
    void TearDown() override { end_without_errors(this->GetParam().route); }
    static gl::Device& device() { return test::device(::testing::TestWithParam<Case>::GetParam().route); }
};

/// A framebuffer with RGBA8 colour and 32-bit float depth. (0, 0) is the lower left pixel, as in GL.
class Target {
public:
    Target(int width, int height, gl::Device& device = test::device())
        : device_(&device),
          width_(width),
          height_(height),
          colour_(value(gl::Texture2D::create(device, "test colour", {gl::Format::Rgba8, width, height}))),
          depth_(value(gl::Texture2D::create(device, "test depth", {gl::Format::Depth32F, width, height}))),
          framebuffer_(value(gl::Framebuffer::create(device, "test target"))) {
        const gl::Texture2D* colours[] = {&colour_};
        framebuffer_.attach(colours, 0, &depth_);
    }
    void bind() const {
        framebuffer_.bind();
        device_->gl().Viewport(0, 0, width_, height_);
    }
    /// Binds and clears, with masks and scissor as they must be for that.
    void clear(float red, float green, float blue, float depth = 1) const {
        const gl::Api& gl = device_->gl();
        bind();
        gl.Disable(GL_SCISSOR_TEST);
        gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        gl.DepthMask(GL_TRUE);
        gl.ClearColor(red, green, blue, 1);
        gl.ClearDepth(depth);
        gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    }
    /// width * height * 4 bytes, RGBA, the lowest row first. Waits.
    [[nodiscard]] std::vector<std::uint8_t> pixels() const {
        std::vector<std::uint8_t> rgba(static_cast<std::size_t>(width_ * height_) * 4);
        framebuffer_.read(colour_.bounds(), gl::Format::Rgba8, rgba.data());
        return rgba;
    }
    [[nodiscard]] std::array<std::uint8_t, 3> pixel(int x, int y) const {
        std::array<std::uint8_t, 4> rgba{};
        framebuffer_.read({x, y, x + 1, y + 1}, gl::Format::Rgba8, rgba.data());
        return {rgba[0], rgba[1], rgba[2]};
    }
    [[nodiscard]] std::vector<float> depths() const {
        std::vector<float> values(static_cast<std::size_t>(width_ * height_));
        framebuffer_.read(depth_.bounds(), gl::Format::Depth32F, values.data());
        return values;
    }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] gl::Texture2D& colour() { return colour_; }
    [[nodiscard]] const gl::Framebuffer& framebuffer() const { return framebuffer_; }

private:
    gl::Device* device_;
    int width_, height_;
    gl::Texture2D colour_, depth_;
    gl::Framebuffer framebuffer_;
};

}  // namespace tilth::test
