#include "tilth/gl/objects.h"

#include <algorithm>
#include <utility>

#include "tilth/gl/api.h"

namespace tilth::gl {

Program::Program(Device& device, ProgramRecipe recipe, unsigned id) : recipe_(std::move(recipe)) {
    device.add_live(ObjectKind::Program, id, 0, recipe_.label);
    handle_ = detail::Handle(device, ObjectKind::Program, id);
}

void Program::adopt(unsigned id) {
    Device& device = handle_.device();
    device.add_live(ObjectKind::Program, id, 0, recipe_.label);
    handle_ = detail::Handle(device, ObjectKind::Program, id);
    ++generation_;
    for (std::size_t i = 0; i < names_.size(); ++i)
        locations_[i] = device.gl().GetUniformLocation(id, names_[i].c_str());
    for (const auto& [name, unit] : std::exchange(samplers_, {})) sampler(name, unit);
    for (const auto& [name, binding] : std::exchange(blocks_, {})) uniform_block(name, binding);
}

void Program::bind() const { handle_.gl().UseProgram(id()); }

Uniform Program::uniform(std::string_view name) {
    const auto known = std::find(names_.begin(), names_.end(), name);
    if (known == names_.end()) {
        names_.emplace_back(name);
        locations_.push_back(handle_.gl().GetUniformLocation(id(), names_.back().c_str()));
        return {static_cast<int>(names_.size()) - 1};
    }
    return {static_cast<int>(known - names_.begin())};
}

void Program::sampler(std::string_view name, int unit) {
    bind();
    set(uniform(name), unit);
    std::erase_if(samplers_, [&](const auto& entry) { return entry.first == name; });
    samplers_.emplace_back(name, unit);
}

void Program::uniform_block(std::string_view name, int binding) {
    const Api& gl = handle_.gl();
    const std::string terminated(name);
    const GLuint index = gl.GetUniformBlockIndex(id(), terminated.c_str());
    if (index != GL_INVALID_INDEX) gl.UniformBlockBinding(id(), index, static_cast<GLuint>(binding));
    std::erase_if(blocks_, [&](const auto& entry) { return entry.first == name; });
    blocks_.emplace_back(terminated, binding);
}

void Program::set(Uniform u, int x) const { handle_.gl().Uniform1i(location(u), x); }
void Program::set(Uniform u, unsigned x) const { handle_.gl().Uniform1ui(location(u), x); }
void Program::set(Uniform u, float x) const { handle_.gl().Uniform1f(location(u), x); }
void Program::set(Uniform u, int x, int y) const { handle_.gl().Uniform2i(location(u), x, y); }
void Program::set(Uniform u, int x, int y, int z, int w) const { handle_.gl().Uniform4i(location(u), x, y, z, w); }
void Program::set(Uniform u, float x, float y) const { handle_.gl().Uniform2f(location(u), x, y); }
void Program::set(Uniform u, float x, float y, float z) const { handle_.gl().Uniform3f(location(u), x, y, z); }
void Program::set(Uniform u, float x, float y, float z, float w) const {
    handle_.gl().Uniform4f(location(u), x, y, z, w);
}
void Program::set_ivec4s(Uniform u, std::span<const std::int32_t> values) const {
    handle_.gl().Uniform4iv(location(u), static_cast<GLsizei>(values.size() / 4), values.data());
}
void Program::set_mat4(Uniform u, const float* column_major) const {
    handle_.gl().UniformMatrix4fv(location(u), 1, GL_FALSE, column_major);
}

}  // namespace tilth::gl
