#include "tilth/gl/shader_source.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "tilth/gl/embedded_shaders.h"

namespace tilth::gl {
namespace {

std::string_view trimmed(std::string_view line) {
    const auto begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    return line.substr(begin, line.find_last_not_of(" \t\r") - begin + 1);
}

/// The rest of `line` behind "#<directive>", if it is that directive: "#include", "# include".
std::optional<std::string_view> directive(std::string_view line, std::string_view name) {
    line = trimmed(line);
    if (!line.starts_with('#')) return std::nullopt;
    line = trimmed(line.substr(1));
    if (!line.starts_with(name)) return std::nullopt;
    line.remove_prefix(name.size());
    if (!line.empty() && line.front() != ' ' && line.front() != '\t' && line.front() != '"' && line.front() != '<')
        return std::nullopt;
    return trimmed(line);
}

std::string folder_of(std::string_view path) {
    const auto slash = path.rfind('/');
    return slash == std::string_view::npos ? "" : std::string(path.substr(0, slash + 1));
}

/// "a/../b.glsl" is "b.glsl": one file has one name, or it would be included twice.
std::string normalized(std::string_view path) {
    std::vector<std::string_view> parts;
    while (!path.empty()) {
        const auto slash = path.find('/');
        const std::string_view part = path.substr(0, slash);
        path = slash == std::string_view::npos ? std::string_view{} : path.substr(slash + 1);
        if (part == ".." && !parts.empty() && parts.back() != "..")
            parts.pop_back();
        else if (!part.empty() && part != ".")
            parts.push_back(part);
    }
    std::string joined;
    for (std::string_view part : parts) {
        if (!joined.empty()) joined += '/';
        joined += part;
    }
    return joined;
}

class Resolver {
public:
    explicit Resolver(const ReadSource& read) : read_(read) {}

    Result<void> add(const std::string& path, const std::string& content) {
        const std::size_t index = index_of(path);
        if (conditions_ == 0) for_sure_.push_back(path);
        open_.push_back(path);
        const int conditions_before = conditions_;
        bool first_directive = true;
        line_directive(1, index);
        int number = 0;
        std::string_view rest = content;
        while (!rest.empty()) {
            const auto end = rest.find('\n');
            const std::string_view line = rest.substr(0, end);
            rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
            ++number;
            count_conditions(line, first_directive);
            if (const auto target = directive(line, "include"); target && !target->starts_with('<')) {
                if (Result<void> included = include(path, number, *target); !included) return included;
                line_directive(number + 1, index);
            } else if (const auto pragma = directive(line, "pragma"); pragma && pragma->starts_with("once")) {
                result.text += '\n';
            } else {
                result.text.append(line.ends_with('\r') ? line.substr(0, line.size() - 1) : line);
                result.text += '\n';
            }
        }
        conditions_ = conditions_before;
        open_.pop_back();
        return {};
    }

    ResolvedSource result;

private:
    /// Of `path` in the list of files, to whose end it is added if need be.
    std::size_t index_of(const std::string& path) {
        const auto known = std::find(result.files.begin(), result.files.end(), path);
        if (known != result.files.end()) return static_cast<std::size_t>(known - result.files.begin());
        result.files.push_back(path);
        return result.files.size() - 1;
    }

    /// Keeps count of the #ifs about the next line. The #ifndef that guards a whole file is none: where it is false,
    /// the file's text is there already.
    void count_conditions(std::string_view line, bool& first_directive) {
        if (!trimmed(line).starts_with('#')) return;
        const bool guard = first_directive && directive(line, "ifndef").has_value();
        first_directive = first_directive && directive(line, "pragma").has_value();
        if (guard) return;
        if (directive(line, "if") || directive(line, "ifdef") || directive(line, "ifndef")) ++conditions_;
        if (directive(line, "endif") && conditions_ > 0) --conditions_;
    }

    void line_directive(int line, std::size_t index) { result.text += text("#line ", line, " ", index, "\n"); }

    Result<void> include(const std::string& from, int line, std::string_view target) {
        if (target.size() < 3 || target.front() != '"' || target.find('"', 1) == std::string_view::npos)
            return Error{ErrorCode::FileFormat,
                         text(from, ":", line, ": malformed #include; write #include \"folder/file.glsl\"")};
        const std::string name(target.substr(1, target.find('"', 1) - 1));
        std::vector<std::string> candidates{normalized(name)};
        if (name.starts_with("shaders/")) candidates.push_back(normalized(name.substr(8)));
        candidates.push_back(normalized(folder_of(from) + name));
        for (const std::string& path : candidates) {
            if (std::find(open_.begin(), open_.end(), path) != open_.end()) {
                std::string chain;
                for (auto it = std::find(open_.begin(), open_.end(), path); it != open_.end(); ++it)
                    chain += *it + " -> ";
                return Error{ErrorCode::FileFormat, text(from, ":", line, ": #include cycle: ", chain, path)};
            }
            if (std::find(for_sure_.begin(), for_sure_.end(), path) != for_sure_.end()) return {};
            if (Result<std::string> content = read_(path)) return add(path, *content);
        }
        return Error{ErrorCode::NotFound, text(from, ":", line, ": #include \"", name,
                                               "\": no such file below shaders/, nor beside the including file")};
    }

    const ReadSource& read_;
    std::vector<std::string> open_;      // the chain of files being read
    std::vector<std::string> for_sure_;  // in the text outside of any condition
    int conditions_ = 0;
};

/// Reads a decimal number at the front of `rest` and removes it.
std::optional<std::size_t> take_number(std::string_view& rest) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error != std::errc{}) return std::nullopt;
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    return value;
}

/// One log line, if it has one of the known forms: `S:L(C): text`, `S(L) : text`, `S:L: text`.
std::optional<std::string> mapped_line(std::string_view line, const std::vector<std::string>& files) {
    std::string_view rest = line;
    std::string_view prefix;
    for (std::string_view word : {"ERROR: ", "WARNING: "}) {
        if (!rest.starts_with(word)) continue;
        prefix = word;
        rest.remove_prefix(word.size());
    }
    const auto file = take_number(rest);
    if (!file || *file >= files.size() || rest.empty() || (rest.front() != ':' && rest.front() != '('))
        return std::nullopt;
    const bool in_brackets = rest.front() == '(';
    rest.remove_prefix(1);
    const auto number = take_number(rest);
    if (!number || rest.empty()) return std::nullopt;
    if (in_brackets) {
        if (rest.front() != ')') return std::nullopt;
        rest.remove_prefix(1);
    } else if (rest.front() == '(') {  // Mesa's column
        const auto close = rest.find(')');
        if (close == std::string_view::npos) return std::nullopt;
        rest.remove_prefix(close + 1);
    }
    const auto colon = rest.find_first_not_of(" \t");
    if (colon == std::string_view::npos || rest[colon] != ':') return std::nullopt;
    return text(files[*file], ":", *number, ": ", prefix, trimmed(rest.substr(colon + 1)));
}

}  // namespace

ShaderSource ShaderSource::embedded() { return {}; }

ShaderSource ShaderSource::folder(std::string folder) {
    ShaderSource source;
    source.folder_ = std::move(folder);
    return source;
}

Result<std::string> ShaderSource::read(std::string_view path) const {
    if (!is_folder()) {
        for (const EmbeddedShader& shader : embedded_shaders())
            if (shader.path == path) return std::string(shader.text);
        return Error{ErrorCode::NotFound, text(path,
                                               ": no such shader in this library; it was built from shaders/ "
                                               "without it")};
    }
    const std::string full = text(folder_, "/", path);
    std::error_code ignored;
    std::ifstream file(full, std::ios::binary);
    if (!std::filesystem::is_regular_file(full, ignored) || !file)
        return Error{ErrorCode::NotFound, text(full, ": cannot be read; is this the shaders folder?")};
    std::ostringstream content;
    content << file.rdbuf();
    return std::move(content).str();
}

Result<ResolvedSource> resolve_includes(std::string_view path, const ReadSource& read, const Features& features,
                                        std::string_view version) {
    const std::string root = normalized(path);
    Result<std::string> content = read(root);
    if (!content) return content.error();
    Resolver resolver(read);
    resolver.result.text = text("#version ", version, "\n#define TILTH_GLSL 1\n");
    for (const auto& [name, value] : features) resolver.result.text += text("#define ", name, " ", value, "\n");
    if (Result<void> added = resolver.add(root, *content); !added) return added.error();
    return std::move(resolver.result);
}

std::string map_log(std::string_view log, const std::vector<std::string>& files) {
    std::string mapped;
    while (!log.empty()) {
        const auto end = log.find('\n');
        std::string_view line = log.substr(0, end);
        log = end == std::string_view::npos ? std::string_view{} : log.substr(end + 1);
        while (!line.empty() && line.back() == '\0') line.remove_suffix(1);
        const auto with_files = mapped_line(line, files);
        mapped += with_files ? *with_files : std::string(line);
        mapped += '\n';
    }
    return mapped;
}

}  // namespace tilth::gl
