// The include resolver: what the compiler is given, and where its complaints point.
#include "tilth/gl/shader_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "tilth/gl/embedded_shaders.h"

namespace tilth::gl {
namespace {

using Files = std::map<std::string, std::string, std::less<>>;

Result<ResolvedSource> resolve(const Files& files, std::string_view path, const Features& features = {}) {
    const ReadSource read = [&](std::string_view wanted) -> Result<std::string> {
        const auto found = files.find(wanted);
        if (found == files.end()) return Error{ErrorCode::NotFound, text(wanted, ": not found")};
        return found->second;
    };
    return resolve_includes(path, read, features);
}

std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// Follows the #line directives as a GLSL 3.30 compiler does: file and line of the first source line that is `wanted`.
std::pair<std::string, int> place_of(const ResolvedSource& source, const std::string& wanted) {
    int number = 0;
    std::size_t file = 0;
    for (const std::string& line : lines_of(source.text)) {
        if (line.starts_with("#line ")) {
            std::istringstream(line.substr(6)) >> number >> file;
            continue;
        }
        if (line == wanted) return {source.files.at(file), number};
        ++number;
    }
    return {"nowhere", 0};
}

TEST(ResolveIncludes, starts_with_version_defines_and_features) {
    const auto source = resolve({{"a.frag", "void main() {}\n"}}, "a.frag", {{"BITS16", "1"}, {"TAPS", "4"}});
    ASSERT_TRUE(source.ok());
    const auto lines = lines_of((*source).text);
    ASSERT_EQ(lines.size(), 6u);
    EXPECT_EQ(lines[0], "#version 330 core");
    EXPECT_EQ(lines[1], "#define TILTH_GLSL 1");
    EXPECT_EQ(lines[2], "#define BITS16 1");
    EXPECT_EQ(lines[3], "#define TAPS 4");
    EXPECT_EQ(lines[5], "void main() {}");
}

TEST(ResolveIncludes, every_line_keeps_its_file_and_number) {
    const Files files{
        {"deform/a.frag", "// 1\n#include \"shared/x.glsl\"\na3\n  #  include \"shared/y.glsl\" // why\na5"},
        {"shared/x.glsl", "x1\n#include \"shared/y.glsl\"\nx3\n"},
        {"shared/y.glsl", "#pragma once\ny2\r\n"}};
    const auto source = resolve(files, "deform/a.frag");
    ASSERT_TRUE(source.ok());
    const ResolvedSource& resolved = *source;
    EXPECT_EQ(place_of(resolved, "x1"), std::pair(std::string("shared/x.glsl"), 1));
    EXPECT_EQ(place_of(resolved, "y2"), std::pair(std::string("shared/y.glsl"), 2));
    EXPECT_EQ(place_of(resolved, "x3"), std::pair(std::string("shared/x.glsl"), 3));
    EXPECT_EQ(place_of(resolved, "a3"), std::pair(std::string("deform/a.frag"), 3));
    EXPECT_EQ(place_of(resolved, "a5"), std::pair(std::string("deform/a.frag"), 5));
    EXPECT_EQ(resolved.files.size(), 3u) << "y.glsl is included once";
    EXPECT_EQ(resolved.text.find("pragma"), std::string::npos);
}

TEST(ResolveIncludes, finds_files_from_the_root_with_prefix_and_beside) {
    const Files files{
        {"shared/a.glsl", "#include \"shaders/shared/b.glsl\"\n#include \"c.glsl\"\n#include \"../d.glsl\"\n"},
        {"shared/b.glsl", "b\n"},
        {"shared/c.glsl", "c\n"},
        {"d.glsl", "d\n"}};
    const auto source = resolve(files, "shared/a.glsl");
    ASSERT_TRUE(source.ok()) << source.error().message;
    EXPECT_EQ(source->files, (std::vector<std::string>{"shared/a.glsl", "shared/b.glsl", "shared/c.glsl", "d.glsl"}));
}

TEST(ResolveIncludes, what_was_included_under_a_condition_is_included_again) {
    const Files files{
        {"a.frag",
         "#ifdef FANCY\n#include \"fancy.glsl\"\n#endif\n#include \"base.glsl\"\n#include \"base.glsl\"\na6\n"},
        {"fancy.glsl", "#ifndef FANCY_GLSL\n#define FANCY_GLSL\n#include \"base.glsl\"\nfancy\n#endif\n"},
        {"base.glsl", "#ifndef BASE_GLSL\n#define BASE_GLSL\n#include \"deep.glsl\"\nbase\n#endif\n"},
        {"deep.glsl", "#ifndef DEEP_GLSL\n#define DEEP_GLSL\ndeep\n#endif\n"}};
    const auto source = resolve(files, "a.frag");
    ASSERT_TRUE(source.ok()) << source.error().message;
    const auto lines = lines_of(source->text);
    // Once under the condition, once for all: a guard is no condition, or what base.glsl brings in would come a third
    // time.
    EXPECT_EQ(std::count(lines.begin(), lines.end(), "base"), 2);
    EXPECT_EQ(std::count(lines.begin(), lines.end(), "deep"), 2);
    EXPECT_EQ(std::count(lines.begin(), lines.end(), "fancy"), 1);
    EXPECT_EQ(source->files, (std::vector<std::string>{"a.frag", "fancy.glsl", "base.glsl", "deep.glsl"}));
    EXPECT_EQ(place_of(*source, "a6"), std::pair(std::string("a.frag"), 6));
    const auto last = std::find(lines.rbegin(), lines.rend(), "base");
    EXPECT_EQ(*std::find_if(last, lines.rend(), [](const std::string& l) { return l.starts_with("#line"); }),
              "#line 4 2");
}

TEST(ResolveIncludes, leaves_angle_brackets_to_the_other_language) {
    const auto source = resolve({{"a.glsl", "#ifdef __cplusplus\n#include <cstdint>\n#endif\n"}}, "a.glsl");
    ASSERT_TRUE(source.ok());
    EXPECT_NE((*source).text.find("#include <cstdint>"), std::string::npos);
}

TEST(ResolveIncludes, a_missing_file_is_named_with_the_line_that_wants_it) {
    const auto source = resolve({{"a.frag", "\n\n#include \"gone.glsl\"\n"}}, "a.frag");
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::NotFound);
    EXPECT_TRUE(source.error().message.starts_with("a.frag:3: #include \"gone.glsl\"")) << source.error().message;
    EXPECT_EQ(resolve({}, "a.frag").error().code, ErrorCode::NotFound);
}

TEST(ResolveIncludes, a_cycle_is_named_as_a_chain) {
    const Files files{{"a.glsl", "#include \"b.glsl\"\n"},
                      {"b.glsl", "x\n#include \"c.glsl\"\n"},
                      {"c.glsl", "#include \"b.glsl\"\n"}};
    const auto source = resolve(files, "a.glsl");
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::FileFormat);
    EXPECT_EQ(source.error().message, "c.glsl:1: #include cycle: b.glsl -> c.glsl -> b.glsl");
    EXPECT_FALSE(resolve({{"a.glsl", "#include \"a.glsl\"\n"}}, "a.glsl").ok());
}

TEST(ResolveIncludes, a_malformed_include_is_refused) {
    for (const char* line : {"#include gone.glsl\n", "#include \"gone.glsl\n", "#include\n", "#include \"\"\n"}) {
        const auto source = resolve({{"a.glsl", line}}, "a.glsl");
        ASSERT_FALSE(source.ok()) << line;
        EXPECT_EQ(source.error().code, ErrorCode::FileFormat) << line;
    }
}

TEST(MapLog, understands_the_drivers) {
    const std::vector<std::string> files{"deform/stamp.frag", "shared/x.glsl"};
    EXPECT_EQ(map_log("0:12(3): error: `foo' undeclared\n", files), "deform/stamp.frag:12: error: `foo' undeclared\n");
    EXPECT_EQ(map_log("1(7) : error C1503: undefined variable\n", files),
              "shared/x.glsl:7: error C1503: undefined variable\n");
    EXPECT_EQ(map_log("ERROR: 1:7: 'foo' : undeclared identifier", files),
              "shared/x.glsl:7: ERROR: 'foo' : undeclared identifier\n");
    EXPECT_EQ(map_log("WARNING: 0:1: extension", files), "deform/stamp.frag:1: WARNING: extension\n");
}

TEST(MapLog, keeps_what_it_does_not_understand) {
    const std::vector<std::string> files{"a.frag"};
    for (const char* line : {"error: linking failed", "7:1(1): no such file index", "3 errors", "0:", "0:x: y", "",
                             "0:12(3", "0(12", "99999999999999999999:1: x"})
        EXPECT_EQ(map_log(text(line, "\n"), files), text(line, "\n"));
}

TEST(EmbeddedShaders, are_the_files_of_the_source_tree) {
    const std::filesystem::path root = TILTH_SOURCE_DIR "/shaders";
    const ShaderSource embedded = ShaderSource::embedded();
    const ShaderSource folder = ShaderSource::folder(root.string());
    ASSERT_FALSE(embedded_shaders().empty());
    for (const EmbeddedShader& shader : embedded_shaders()) {
        const auto file = folder.read(shader.path);
        ASSERT_TRUE(file.ok()) << shader.path;
        EXPECT_EQ(*file, shader.text) << shader.path;
    }
    EXPECT_TRUE(embedded.read("gl/texel_rects.vert").ok());
    const auto missing = embedded.read("gl/none.vert");
    ASSERT_FALSE(missing.ok());
    EXPECT_EQ(missing.error().code, ErrorCode::NotFound);
    EXPECT_EQ(folder.read("gl/none.vert").error().code, ErrorCode::NotFound);
    EXPECT_EQ(folder.read("gl").error().code, ErrorCode::NotFound) << "a folder is not a file";
}

}  // namespace
}  // namespace tilth::gl
