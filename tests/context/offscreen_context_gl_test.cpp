// Contexts without a window: both routes, in one process, in turn.
#include "tilth/context/offscreen_context.h"

#include <gtest/gtest.h>

#include "support/gl_context.h"
#include "tilth/gl/state_guard.h"

namespace tilth::context {
namespace {

/// Skipping is allowed for OSMesa alone: Mesa 25.1 removed it.
bool missing_is_allowed(Route route, const std::string& why) {
    return std::getenv("TILTH_ALLOW_NO_GL") != nullptr ||
           (route == Route::Osmesa && why.find("cannot be loaded") != std::string::npos);
}

class RouteTest : public ::testing::TestWithParam<Route> {};

TEST_P(RouteTest, gives_a_core_context_that_draws) {
    auto made = OffscreenContext::create(GetParam(), {.width = 32, .height = 16, .debug = true});
    if (!made && missing_is_allowed(GetParam(), made.error().message)) GTEST_SKIP() << made.error().message;
    ASSERT_TRUE(made.ok()) << made.error().message;
    OffscreenContext context = *std::move(made);
    EXPECT_FALSE(context.renderer().empty());
    EXPECT_EQ(context.route(), GetParam());
    std::printf("%s by %s: %s\n", std::string(context.route_name()).c_str(), context.platform().c_str(),
                context.renderer().c_str());
    auto device = test::value(gl::Device::create(context.get_proc(), {.collect_debug_messages = true}));
    EXPECT_GE(device->capabilities().version, (gl::Version{3, 3}));
    GLint profile = 0;
    device->gl().GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    EXPECT_EQ(profile, GL_CONTEXT_CORE_PROFILE_BIT);
    {
        test::Target target(8, 8, *device);
        target.clear(0, 1, 0.5f);
        EXPECT_EQ(target.pixel(3, 3), (std::array<std::uint8_t, 3>{0, 255, 128}));
    }
    // The default framebuffer is what the header says.
    device->gl().BindFramebuffer(GL_FRAMEBUFFER, 0);
    const GLenum status = device->gl().CheckFramebufferStatus(GL_FRAMEBUFFER);
    EXPECT_EQ(status,
              static_cast<GLenum>(GetParam() == Route::Egl ? GL_FRAMEBUFFER_UNDEFINED : GL_FRAMEBUFFER_COMPLETE));
    EXPECT_TRUE(device->take_errors().empty());
}

TEST_P(RouteTest, can_be_left_and_entered_again) {
    auto made = OffscreenContext::create(GetParam());
    if (!made && missing_is_allowed(GetParam(), made.error().message)) GTEST_SKIP() << made.error().message;
    ASSERT_TRUE(made.ok()) << made.error().message;
    OffscreenContext first = *std::move(made);
    auto device = test::value(gl::Device::create(first.get_proc()));
    GLuint texture = 0;
    device->gl().GenTextures(1, &texture);
    device->gl().BindTexture(GL_TEXTURE_2D, texture);
    {
        OffscreenContext second = test::value(OffscreenContext::create(GetParam()));
        GLint bound = -1;
        device->gl().GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
        EXPECT_EQ(bound, 0) << "another context has its own state";
    }
    ASSERT_TRUE(first.make_current().ok());
    GLint bound = 0;
    device->gl().GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
    EXPECT_EQ(static_cast<GLuint>(bound), texture);
    device->gl().DeleteTextures(1, &texture);
    device.reset();
    OffscreenContext moved = std::move(first);
    EXPECT_TRUE(moved.make_current().ok());
    moved.release_current();
}

INSTANTIATE_TEST_SUITE_P(Contexts, RouteTest, ::testing::Values(Route::Egl, Route::Osmesa),
                         [](const auto& route) { return std::string(name_of(route.param)); });

TEST(OffscreenContext, both_routes_live_in_one_process) {
    auto egl = OffscreenContext::create(Route::Egl);
    ASSERT_TRUE(egl.ok() || missing_is_allowed(Route::Egl, egl.error().message)) << egl.error().message;
    auto osmesa = OffscreenContext::create(Route::Osmesa);
    if (!egl || !osmesa) GTEST_SKIP() << "needs both routes";
    osmesa->release_current();
    for (int round = 0; round < 3; ++round) {
        for (OffscreenContext* context : {&*egl, &*osmesa}) {
            ASSERT_TRUE(context->make_current().ok());
            auto device = test::value(gl::Device::create(context->get_proc(), {.collect_debug_messages = true}));
            {
                const gl::StateGuard guard(*device);
                test::Target target(4, 4, *device);
                target.clear(static_cast<float>(round) / 2, 0, 1);
                EXPECT_EQ(target.pixel(1, 2)[2], 255);
                EXPECT_NEAR(target.pixel(1, 2)[0], 127.5 * round, 0.6);
            }
            EXPECT_TRUE(device->take_errors().empty());
            EXPECT_TRUE(device->take_debug_messages().empty());
            device.reset();
            context->release_current();
        }
    }
}

}  // namespace
}  // namespace tilth::context
