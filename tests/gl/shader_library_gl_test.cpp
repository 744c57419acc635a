// Programs from files: errors name our files and lines, a failed reload keeps the last good program.
#include "tilth/gl/shader_library.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "support/gl_context.h"

namespace tilth::gl {
namespace {

class ShaderLibraryTest : public test::GlTest {
protected:
    void SetUp() override {
        test::GlTest::SetUp();
        folder_ =
            std::filesystem::temp_directory_path() /
            (std::string("tilth_shaders_").append(::testing::UnitTest::GetInstance()->current_test_info()->name()));
        std::filesystem::create_directories(folder_ / "shared");
        write("a.vert",
              "void main() { gl_Position = vec4(float(gl_VertexID & 1) * 4.0 - 1.0, "
              "float(gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0); }\n");
    }
    void TearDown() override {
        std::filesystem::remove_all(folder_);
        test::GlTest::TearDown();
    }
    void write(const char* path, const std::string& text) { std::ofstream(folder_ / path) << text; }
    ShaderLibrary library() { return ShaderLibrary(device(), ShaderSource::folder(folder_.string())); }
    std::array<std::uint8_t, 3> drawn(const Program& program) {
        test::Target target(4, 4);
        target.clear(0, 0, 0);
        device().gl().Disable(GL_DEPTH_TEST);
        VertexArray none = test::value(VertexArray::create(device(), "no attributes"));
        program.bind();
        none.bind();
        device().gl().DrawArrays(GL_TRIANGLES, 0, 3);
        return target.pixel(2, 2);
    }
    std::filesystem::path folder_;
};

using Rgb = std::array<std::uint8_t, 3>;

TEST_F(ShaderLibraryTest, errors_name_file_and_line_also_after_an_include) {
    write("shared/ok.glsl", "float one() {\n    return 1.0;\n}\n");
    write("shared/bad.glsl", "\n\nfloat two() { return undeclared_in_shared; }\n");
    write("a.frag",
          "#include \"shared/ok.glsl\"\nout vec4 colour;\nvoid main() {\n    colour = vec4(undeclared_here);\n}\n");
    write("b.frag", "#include \"shared/ok.glsl\"\n#include \"shared/bad.glsl\"\nvoid main() {}\n");
    ShaderLibrary shaders = library();
    const auto a = shaders.program("a", "a.vert", "a.frag");
    ASSERT_FALSE(a.ok());
    EXPECT_EQ(a.error().code, ErrorCode::ShaderCompile);
    EXPECT_NE(a.error().message.find("\na.frag:4: "), std::string::npos) << a.error().message;
    EXPECT_NE(a.error().message.find("undeclared_here"), std::string::npos);
    const auto b = shaders.program("b", "a.vert", "b.frag");
    ASSERT_FALSE(b.ok());
    EXPECT_NE(b.error().message.find("\nshared/bad.glsl:3: "), std::string::npos) << b.error().message;
    EXPECT_EQ(shaders.programs_linked(), 0u);
    EXPECT_EQ(device().live_objects().size(), 0u) << "a failed program leaks";
    device().take_debug_messages();  // the driver may report what we did on purpose
}

TEST_F(ShaderLibraryTest, a_missing_file_and_a_link_error_are_told_apart) {
    ShaderLibrary shaders = library();
    EXPECT_EQ(shaders.program("none", "a.vert", "none.frag").error().code, ErrorCode::NotFound);
    write("two.vert", "out vec2 v_mismatch;\nvoid main() { v_mismatch = vec2(1.0); gl_Position = vec4(0.0); }\n");
    write("three.frag", "in vec3 v_mismatch;\nout vec4 colour;\nvoid main() { colour = vec4(v_mismatch, 1.0); }\n");
    const auto unlinked = shaders.program("mismatched", "two.vert", "three.frag");
    ASSERT_FALSE(unlinked.ok());
    EXPECT_EQ(unlinked.error().code, ErrorCode::ShaderCompile);
    EXPECT_NE(unlinked.error().message.find("v_mismatch"), std::string::npos) << unlinked.error().message;
    device().take_debug_messages();
}

TEST_F(ShaderLibraryTest, features_choose_and_outputs_follow_their_location) {
    write("a.frag",
          "layout(location = 0) out vec4 colour;\nvoid main() {\n#ifdef GREEN\n    colour = vec4(0.0, GREEN, "
          "0.0, 1.0);\n#else\n    colour = vec4(1.0, 0.0, 0.0, 1.0);\n#endif\n}\n");
    ShaderLibrary shaders = library();
    EXPECT_EQ(drawn(test::value(shaders.program("red", "a.vert", "a.frag"))), (Rgb{255, 0, 0}));
    EXPECT_EQ(drawn(test::value(shaders.program("green", "a.vert", "a.frag", {{"GREEN", "1.0"}}))), (Rgb{0, 255, 0}));
    EXPECT_EQ(shaders.programs_linked(), 2u);
}

TEST_F(ShaderLibraryTest, reload_takes_the_good_and_keeps_the_last_good) {
    const auto source = [](const char* colour) {
        return text(
            "uniform float u_unused_before;\nuniform float u_level;\nuniform sampler2D u_map;\nout vec4 result;\n"
            "void main() { result = ",
            colour, " + texelFetch(u_map, ivec2(0), 0); }\n");
    };
    write("a.frag", source("vec4(u_level, 0.0, 0.0, 1.0)"));
    ShaderLibrary shaders = library();
    Program program = test::value(shaders.program("reloaded", "a.vert", "a.frag"));
    const Uniform level = program.uniform("u_level");
    program.sampler("u_map", 7);
    Texture2D map = test::value(Texture2D::create(device(), "map", {Format::Rgba8, 1, 1}));
    const std::array<std::uint8_t, 4> zero{};
    map.upload(0, map.bounds(), zero.data());
    map.bind(7);
    program.bind();
    program.set(level, 1.0f);
    EXPECT_EQ(drawn(program), (Rgb{255, 0, 0}));

    write("a.frag", "this is not a shader\n");
    const Result<void> refused = shaders.reload(program);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("a.frag:1: "), std::string::npos) << refused.error().message;
    EXPECT_EQ(program.generation(), 0);
    EXPECT_EQ(drawn(program), (Rgb{255, 0, 0})) << "the last good program keeps its uniforms";
    device().take_debug_messages();

    write("a.frag", source("vec4(u_unused_before, u_level, 0.0, 1.0)"));
    ASSERT_TRUE(shaders.reload(program).ok());
    EXPECT_EQ(program.generation(), 1);
    program.bind();
    program.set(level, 1.0f);  // the same handle, wherever the new program keeps it
    EXPECT_EQ(drawn(program), (Rgb{0, 255, 0}));
    GLint unit = 0;
    device().gl().GetUniformiv(program.id(), device().gl().GetUniformLocation(program.id(), "u_map"), &unit);
    EXPECT_EQ(unit, 7) << "sampler units survive a reload";
}

TEST_F(ShaderLibraryTest, every_embedded_program_part_is_the_one_on_disk) {
    ShaderLibrary embedded(device());
    EXPECT_TRUE(embedded.program("from the library", "gl/texel_rects.vert", "gl/blit.frag").ok());
}

}  // namespace
}  // namespace tilth::gl
