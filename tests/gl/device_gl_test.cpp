// Facts of the context, messages, groups, timers.
#include "tilth/gl/device.h"

#include <gtest/gtest.h>

#include "support/gl_context.h"
#include "support/gl_state.h"
#include "tilth/core/log.h"
#include "tilth/gl/debug_group.h"
#include "tilth/gl/timer.h"

namespace tilth::gl {
namespace {

class DeviceTest : public test::GlTest {};

TEST_F(DeviceTest, knows_the_context) {
    const Capabilities& caps = device().capabilities();
    EXPECT_GE(caps.version, (Version{3, 3}));
    EXPECT_FALSE(caps.renderer.empty());
    // The least that GL 3.3 guarantees.
    EXPECT_GE(caps.max_texture_size, 1024);
    EXPECT_GE(caps.max_buffer_texels, 65536);
    EXPECT_GE(caps.max_uniform_block_bytes, 16384);
    EXPECT_GE(caps.max_vertex_textures, 16);
    EXPECT_GE(caps.max_colour_attachments, 8);
    EXPECT_GE(caps.max_geometry_vertices, 256);
    EXPECT_TRUE(caps.has_extension(caps.extensions.front()));
    EXPECT_FALSE(caps.has_extension("GL_TILTH_no_such_extension"));
    EXPECT_EQ(caps.tessellation, caps.max_patch_vertices > 0);
    EXPECT_EQ(device().quirks(), quirks_of(caps.vendor, caps.renderer));
}

TEST_F(DeviceTest, refuses_what_is_no_context) {
    EXPECT_EQ(Device::create(nullptr).error().code, ErrorCode::InvalidArgument);
    const auto none = Device::create([](const char*) -> void* { return nullptr; });
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, ErrorCode::GlContext);
}

GetProc real_get_proc = nullptr;

TEST_F(DeviceTest, refuses_a_context_below_3_3_and_says_what_it_found) {
    real_get_proc = test::test_context(test::default_route()).context->get_proc();
    using GetString = const GLubyte* (*)(GLenum);
    const auto old_context = [](const char* name) -> void* {
        const GetString old = [](GLenum what) -> const GLubyte* {
            return reinterpret_cast<const GLubyte*>(what == GL_VERSION ? "3.2.0 Ancient" : "Old renderer");
        };
        if (std::string_view(name) == "glGetString") return reinterpret_cast<void*>(old);
        return real_get_proc(name);
    };
    const auto refused = Device::create(old_context);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::GlContext);
    EXPECT_NE(refused.error().message.find("3.2.0 Ancient"), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find("3.3"), std::string::npos);
}

TEST_F(DeviceTest, creation_and_destruction_leave_the_host_as_it_was) {
    const test::GlState before = test::capture_state(device());
    void* callback = nullptr;
    device().gl().GetPointerv(GL_DEBUG_CALLBACK_FUNCTION, &callback);
    {
        const auto get_proc = test::test_context(test::default_route()).context->get_proc();
        auto plain = test::value(Device::create(get_proc));
        EXPECT_EQ(test::difference(before, test::capture_state(device())), "");
        auto collecting = test::value(Device::create(get_proc, {.collect_debug_messages = true}));
        device().gl().Enable(0x1234);
        EXPECT_EQ(collecting->debug_messages().size(), 1u);
        EXPECT_EQ(collecting->take_errors().size(), 1u);
    }
    void* callback_after = nullptr;
    device().gl().GetPointerv(GL_DEBUG_CALLBACK_FUNCTION, &callback_after);
    EXPECT_EQ(callback, callback_after);
    EXPECT_EQ(test::difference(before, test::capture_state(device())), "");
}

TEST_F(DeviceTest, collects_messages_up_to_a_bound) {
    for (std::size_t i = 0; i < Device::kMaxDebugMessages + 5; ++i) device().gl().Enable(0x1234);
    EXPECT_EQ(device().debug_messages().size(), Device::kMaxDebugMessages);
    const auto taken = device().take_debug_messages();
    ASSERT_EQ(taken.size(), Device::kMaxDebugMessages + 1);
    EXPECT_EQ(taken.back().text, "5 more messages were dropped");
    EXPECT_TRUE(device().take_debug_messages().empty());
    EXPECT_EQ(device().take_errors().size(), 1u) << "GL keeps one flag per kind";
}

TEST_F(DeviceTest, groups_nest_and_are_no_messages) {
    const auto depth = [&] {
        GLint value = 0;
        device().gl().GetIntegerv(GL_DEBUG_GROUP_STACK_DEPTH, &value);
        return value;
    };
    const GLint before = depth();
    {
        DebugGroup frame(device(), "frame");
        DebugGroup stage(device(), "stage");
        EXPECT_EQ(depth(), before + 2);
    }
    EXPECT_EQ(depth(), before);
}

TEST_F(DeviceTest, a_leak_is_reported_with_its_label) {
    std::string logged;
    set_log_callback(
        [](LogLevel, std::string_view message, void* user) { *static_cast<std::string*>(user) += message; }, &logged);
    auto leaky = test::value(Device::create(test::test_context(test::default_route()).context->get_proc()));
    leaky->add_live(ObjectKind::Texture, 4711, 64, "forgotten tile");
    leaky.reset();
    set_log_callback(nullptr, nullptr);
    EXPECT_NE(logged.find("forgotten tile"), std::string::npos) << logged;
    EXPECT_NE(logged.find("4711"), std::string::npos);
}

TEST_F(DeviceTest, timers_see_work_or_say_that_they_cannot) {
    GpuTimer frame = test::value(GpuTimer::create(device(), "frame", TimerPolicy::NeverWait));
    GpuTimer bench = test::value(GpuTimer::create(device(), "bench", TimerPolicy::MayFinish));
    EXPECT_EQ(frame.measures(), !device().quirks().timer_queries_lie);
    ASSERT_TRUE(bench.measures());
    test::Target small(16, 16), large(1024, 1024);
    const auto time = [&](const test::Target& target, int clears) {
        bench.begin();
        for (int i = 0; i < clears; ++i) target.clear(static_cast<float>(i & 1), 0, 0);
        bench.end();
        const auto samples = bench.finish_samples_ms();
        return samples.size() == 1 ? samples[0] : -1.0;
    };
    time(large, 1);
    const double little = time(small, 1), much = time(large, 40);
    EXPECT_GE(little, 0.0);
    EXPECT_GT(much, little) << "40 clears of a megapixel against one of 256 pixels";
    frame.begin();
    small.clear(0, 0, 0);
    frame.end();
    if (!frame.measures()) {
        EXPECT_TRUE(frame.finish_samples_ms().empty());
    } else {
        EXPECT_EQ(frame.finish_samples_ms().size(), 1u);
    }
}

}  // namespace
}  // namespace tilth::gl
