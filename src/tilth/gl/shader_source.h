// Where shader text comes from, and how its includes are put together. No GL.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tilth/core/result.h"

namespace tilth::gl {

/// The text of shader files by their path below `shaders/`, e.g. "deform/stamp.frag".
class ShaderSource {
public:
    /// The files that were in `shaders/` when the library was built.
    static ShaderSource embedded();
    /// Files on disk below `folder`, read anew every time: for tests, and for the demo's reload.
    static ShaderSource folder(std::string folder);

    [[nodiscard]] Result<std::string> read(std::string_view path) const;
    [[nodiscard]] bool is_folder() const { return !folder_.empty(); }

private:
    std::string folder_;
};

/// A feature list: `#define NAME VALUE` lines at the top of every stage.
using Features = std::vector<std::pair<std::string, std::string>>;

/// Text ready for the compiler, and the files it came from: string index i in a log is `files[i]`.
struct ResolvedSource {
    std::string text;
    std::vector<std::string> files;
};

/// Reads one file by its path.
using ReadSource = std::function<Result<std::string>(std::string_view path)>;

/// Puts `path` and what it includes together: the version line, `#define TILTH_GLSL 1`, the features, the file.
///
/// `#include "shared/x.glsl"` is looked for below the shaders root (a leading "shaders/" is dropped, as the C++ side
/// writes it), then beside the including file. Each file is included once; `#pragma once` is dropped. One that was only
/// included between `#if` and `#endif` is included again where it is asked for next, so it needs a guard (`#ifndef` in
/// front of everything).
/// `#include <...>` is left alone: it is for the C++ side, behind `#ifdef __cplusplus`.
/// Fails with NotFound (naming the including file and line) or FileFormat (a cycle, named as a chain; a malformed
/// include).
Result<ResolvedSource> resolve_includes(std::string_view path, const ReadSource& read, const Features& features = {},
                                        std::string_view version = "330 core");

/// A driver's log with `files` in the place of string indices: "deform/stamp.frag:12: ...". Understands the forms of
/// Mesa "0:12(3): ", NVIDIA "0(12) : " and AMD/Intel/Apple "ERROR: 0:12: "; other lines are kept as they are.
std::string map_log(std::string_view log, const std::vector<std::string>& files);

}  // namespace tilth::gl
