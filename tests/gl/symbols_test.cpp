// A host links its own GL and its own glad: the library must bring neither.
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace {

/// Symbols that the archive defines, as nm prints them: "address type name".
std::vector<std::string> defined_symbols(const std::string& archive) {
    std::vector<std::string> names;
    FILE* pipe = popen(("nm --defined-only --extern-only --format=posix \"" + archive + "\" 2>/dev/null").c_str(), "r");
    if (pipe == nullptr) return names;
    std::array<char, 4096> line{};
    while (std::fgets(line.data(), line.size(), pipe) != nullptr) {
        std::string name;
        std::istringstream(line.data()) >> name;
        names.push_back(name);
    }
    pclose(pipe);
    return names;
}

bool belongs_to_gl(const std::string& name) {
    return name.starts_with("glad") || (name.size() > 2 && name.starts_with("gl") && std::isupper(name[2]) != 0) ||
           name.starts_with("egl") || name.starts_with("OSMesa");
}

TEST(Symbols, no_gl_symbol_is_global) {
    const std::vector<std::string> names = defined_symbols(TILTH_BINARY_DIR "/libtilth_tilth.a");
    ASSERT_GT(names.size(), 50u) << "nm found no library";
    for (const std::string& name : names) EXPECT_FALSE(belongs_to_gl(name)) << name;
    EXPECT_NE(std::find(names.begin(), names.end(), "tilth_gl_load_context"), names.end())
        << "the renamed loader is not where this test looks";
}

TEST(Headers, only_the_private_one_names_gl) {
    int headers = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(TILTH_SOURCE_DIR "/src/tilth")) {
        if (entry.path().extension() != ".h") continue;
        ++headers;
        const bool is_private = entry.path().filename() == "api.h" && entry.path().parent_path().filename() == "gl";
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);) {
            if (line.find("#include") == std::string::npos) continue;
            const bool names_gl = line.find("glad") != std::string::npos || line.find("<GL/") != std::string::npos ||
                                  line.find("<EGL/") != std::string::npos || line.find("gl/api.h") != std::string::npos;
            EXPECT_TRUE(!names_gl || is_private) << entry.path() << ": " << line;
        }
    }
    EXPECT_GT(headers, 10);
}

}  // namespace
