#include "tilth/gl/shader_library.h"

#include <algorithm>
#include <array>
#include <vector>

#include "tilth/gl/api.h"

namespace tilth::gl {
namespace {

struct Stage {
    GLenum type;
    const std::string& path;
};

std::string shader_log(const Api& gl, GLuint shader) {
    GLint length = 0;
    gl.GetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    gl.GetShaderInfoLog(shader, length, &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    return log;
}

std::string program_log(const Api& gl, GLuint program) {
    GLint length = 0;
    gl.GetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    gl.GetProgramInfoLog(program, length, &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    return log;
}

Result<void> compile(const Api& gl, GLuint shader, const std::string& label, const ResolvedSource& source) {
    const char* code = source.text.c_str();
    gl.ShaderSource(shader, 1, &code, nullptr);
    gl.CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return {};
    return Error{ErrorCode::ShaderCompile, text("program \"", label, "\": ", source.files.front(),
                                                " does not compile:\n", map_log(shader_log(gl, shader), source.files))};
}

}  // namespace

ShaderLibrary::ShaderLibrary(Device& device, ShaderSource source) : device_(device), source_(std::move(source)) {}

Result<unsigned> ShaderLibrary::link(const ProgramRecipe& recipe) {
    const Api& gl = device_.gl();
    const bool tessellated = !recipe.tess_evaluation.empty();
    if (tessellated && !device_.capabilities().tessellation)
        return Error{ErrorCode::Unsupported,
                     text("program \"", recipe.label, "\" needs hardware tessellation (GL 4.0), ",
                          device_.capabilities().renderer, " has none")};
    const std::array<Stage, 5> stages{
        Stage{GL_VERTEX_SHADER, recipe.vertex}, Stage{GL_TESS_CONTROL_SHADER, recipe.tess_control},
        Stage{GL_TESS_EVALUATION_SHADER, recipe.tess_evaluation}, Stage{GL_GEOMETRY_SHADER, recipe.geometry},
        Stage{GL_FRAGMENT_SHADER, recipe.fragment}};
    const ReadSource read = [this](std::string_view path) { return source_.read(path); };
    const GLuint program = gl.CreateProgram();
    Result<void> outcome;
    for (const Stage& stage : stages) {
        if (stage.path.empty()) continue;
        Result<ResolvedSource> source =
            resolve_includes(stage.path, read, recipe.features, tessellated ? "400 core" : "330 core");
        if (!source) {
            outcome = Error{source.error().code, text("program \"", recipe.label, "\": ", source.error().message)};
            break;
        }
        const GLuint shader = gl.CreateShader(stage.type);
        device_.label(GL_SHADER, shader, stage.path);
        outcome = compile(gl, shader, recipe.label, *source);
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader);  // lives on until the program lets go of it
        if (!outcome) break;
    }
    if (outcome) {
        if (!recipe.feedback.empty()) {
            std::vector<const char*> names;
            for (const std::string& name : recipe.feedback) names.push_back(name.c_str());
            gl.TransformFeedbackVaryings(program, static_cast<GLsizei>(names.size()), names.data(),
                                         GL_INTERLEAVED_ATTRIBS);
        }
        gl.LinkProgram(program);
        GLint linked = GL_FALSE;
        gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
        if (linked != GL_TRUE)
            outcome =
                Error{ErrorCode::ShaderCompile, text("program \"", recipe.label, "\" (", recipe.vertex, ", ",
                                                     recipe.fragment, ") does not link:\n", program_log(gl, program))};
    }
    if (!outcome) {
        gl.DeleteProgram(program);
        return outcome.error();
    }
    GLint count = 0;
    std::array<GLuint, 5> shaders{};
    gl.GetAttachedShaders(program, 5, &count, shaders.data());
    for (GLint i = 0; i < count; ++i) gl.DetachShader(program, shaders[static_cast<std::size_t>(i)]);
    device_.label(GL_PROGRAM, program, recipe.label);
    ++programs_linked_;
    return program;
}

Result<Program> ShaderLibrary::program(std::string_view label, std::string_view vertex_path,
                                       std::string_view fragment_path, const Features& features,
                                       const ProgramOptions& options) {
    ProgramRecipe recipe;
    recipe.label = label;
    recipe.vertex = vertex_path;
    recipe.fragment = fragment_path;
    recipe.geometry = options.geometry;
    recipe.tess_control = options.tess_control;
    recipe.tess_evaluation = options.tess_evaluation;
    recipe.features = features;
    recipe.feedback = options.feedback;
    Result<unsigned> id = link(recipe);
    if (!id) return id.error();
    return Program(device_, std::move(recipe), *id);
}

Result<void> ShaderLibrary::reload(Program& program) {
    Result<unsigned> id = link(program.recipe());
    if (!id) return id.error();
    program.adopt(*id);
    return {};
}

}  // namespace tilth::gl
