// Makes programs from shader files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/objects.h"
#include "tilth/gl/shader_source.h"

namespace tilth::gl {

/// What a program has beside vertex and fragment; an empty stage means none. With tessellation the version is 4.00,
/// else 3.30.
struct ProgramOptions {
    std::string geometry, tess_control, tess_evaluation;
    /// Outputs of the last stage before the rasteriser that transform feedback captures, interleaved in this order.
    std::vector<std::string> feedback;
};

/// Compiles and links. Fragment outputs are placed by `layout(location = n)` in the shader.
/// Thread: the one that owns the context. Touches no state but the current program when a program is reloaded.
class ShaderLibrary {
public:
    explicit ShaderLibrary(Device& device, ShaderSource source = ShaderSource::embedded());

    /// Paths are relative to `shaders/`. Fails with NotFound, FileFormat (includes), or ShaderCompile with the
    /// driver's log in our file names and lines. Costs 1 to 100 ms, and the first draw costs as much again.
    Result<Program> program(std::string_view label, std::string_view vertex_path, std::string_view fragment_path,
                            const Features& features = {}, const ProgramOptions& options = {});

    /// Makes `program` again from its files. On failure the last good one stays in use and the error comes back.
    /// Uniform values are lost, as after a link; sampler units and block bindings are set again.
    Result<void> reload(Program& program);

    /// GL programs linked so far, for `StageStats::programs`.
    [[nodiscard]] std::uint64_t programs_linked() const { return programs_linked_; }
    [[nodiscard]] Device& device() const { return device_; }
    [[nodiscard]] const ShaderSource& source() const { return source_; }

private:
    Result<unsigned> link(const ProgramRecipe& recipe);

    Device& device_;
    ShaderSource source_;
    std::uint64_t programs_linked_ = 0;
};

}  // namespace tilth::gl
