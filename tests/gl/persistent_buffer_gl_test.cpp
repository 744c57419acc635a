// A buffer that stays mapped: later commands see what is written, and what the context cannot do is refused.
#include <gtest/gtest.h>

#include <cstring>
#include <string_view>

#include "support/gl_context.h"

namespace tilth::gl {
namespace {

class PersistentBufferTest : public test::GlTest {};

GetProc real_get_proc = nullptr;

TEST_F(PersistentBufferTest, uploads_see_what_is_written_while_it_is_mapped) {
    if (!device().capabilities().buffer_storage) GTEST_SKIP() << "no GL_ARB_buffer_storage";
    const std::uint64_t before = device().resident_bytes();
    {
        Buffer buffer = test::value(Buffer::create_persistent(device(), "stays mapped", 64));
        ASSERT_NE(buffer.mapped(), nullptr);
        EXPECT_EQ(device().resident_bytes() - before, 64u);
        Buffer moved = std::move(buffer);
        Texture2D texture = test::value(Texture2D::create(device(), "target", {Format::R8, 4, 4}));
        for (std::uint8_t round = 1; round <= 3; ++round) {
            std::memset(moved.mapped(), round, 64);
            texture.upload(0, texture.bounds(), moved, 48);
            std::array<std::uint8_t, 16> result{};
            texture.read(0, result.data());  // waits: the next round may write
            std::array<std::uint8_t, 16> expected;
            expected.fill(round);
            EXPECT_EQ(result, expected);
        }
    }
    EXPECT_EQ(device().resident_bytes(), before) << "deleting it unmaps it";
}

TEST_F(PersistentBufferTest, another_buffer_has_no_mapped_memory) {
    EXPECT_EQ(test::value(Buffer::create(device(), "plain", 64)).mapped(), nullptr);
}

TEST_F(PersistentBufferTest, is_refused_where_the_context_cannot) {
    real_get_proc = test::test_context(test::default_route()).context->get_proc();
    using GetStringi = const GLubyte* (*)(GLenum, GLuint);
    const auto without = [](const char* name) -> void* {
        const GetStringi hide = [](GLenum what, GLuint index) {
            const GLubyte* answer = reinterpret_cast<GetStringi>(real_get_proc("glGetStringi"))(what, index);
            const bool hidden = std::string_view(reinterpret_cast<const char*>(answer)) == "GL_ARB_buffer_storage";
            return hidden ? reinterpret_cast<const GLubyte*>("GL_TILTH_hidden") : answer;
        };
        return std::string_view(name) == "glGetStringi" ? reinterpret_cast<void*>(hide) : real_get_proc(name);
    };
    const auto poor = test::value(Device::create(without));
    EXPECT_FALSE(poor->capabilities().buffer_storage);
    const auto refused = Buffer::create_persistent(*poor, "wish", 64);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::Unsupported);
    EXPECT_NE(refused.error().message.find("wish"), std::string::npos) << refused.error().message;
}

TEST_F(PersistentBufferTest, out_of_memory_is_an_error_and_not_a_pending_one) {
    if (!device().capabilities().buffer_storage) GTEST_SKIP() << "no GL_ARB_buffer_storage";
    const std::uint64_t before = device().resident_bytes();
    const auto made = Buffer::create_persistent(device(), "huge", std::size_t{1} << 62);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::OutOfMemory);
    EXPECT_EQ(device().resident_bytes(), before);
    EXPECT_TRUE(device().take_errors().empty());
    device().take_debug_messages();  // the driver says so, too
}

}  // namespace
}  // namespace tilth::gl
