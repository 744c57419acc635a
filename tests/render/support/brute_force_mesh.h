// The contract surface as a mesh of all posts: the reference that shares no code with the renderer's shaders and
// layout.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <span>
#include <vector>

#include "render/support/scene.h"

namespace tilth::test {

/// Every post of a map, two triangles a cell, positions computed in double relative to the eye. Slow on purpose.
class BruteForceMesh {
public:
    explicit BruteForceMesh(const Scene& scene)
        : scene_(&scene),
          shaders_(test::device(), gl::ShaderSource::folder(TILTH_SOURCE_DIR "/tests/render/shaders")),
          program_(value(shaders_.program("reference", "reference.vert", "reference.frag"))),
          u_clip_from_relative_(program_.uniform("u_clip_from_relative")),
          array_(value(gl::VertexArray::create(test::device(), "reference"))),
          positions_(value(
              gl::Buffer::create(test::device(), "reference positions", positions_bytes(), gl::BufferUsage::Stream))),
          indices_(value(make_indices(scene.field()))) {
        array_.float_attribute(0, positions_, 3, gl::AttributeType::Float, 12, 0);
        array_.index_buffer(indices_);
    }

    /// Clears `target` to magenta and draws.
    std::vector<std::uint8_t> picture(const Target& target, const View& view) {
        const HeightField& field = scene_->field();
        const MapInfo& map = scene_->map();
        std::vector<float> positions;
        positions.reserve(positions_bytes() / sizeof(float));
        for (std::int32_t z = 0; z < field.depth(); ++z) {
            for (std::int32_t x = 0; x < field.width(); ++x) {
                const WorldPos at = map.grid.world({x, z});
                positions.push_back(static_cast<float>(at.x - view.eye.x));
                positions.push_back(static_cast<float>(map.codec.height_m(field.code({x, z})) - view.eye.y));
                positions.push_back(static_cast<float>(at.z - view.eye.z));
            }
        }
        positions_.replace(std::as_bytes(std::span(positions)));
        const glm::dvec3 forward(view.forward.x, view.forward.y, view.forward.z), up(view.up.x, view.up.y, view.up.z);
        const glm::mat4 clip(
            glm::perspective(view.fov_y_rad, double(target.width()) / target.height(), view.near_m, view.far_m) *
            glm::lookAt(glm::dvec3(0), forward, up));
        target.clear(1, 0, 1);
        const gl::Api& gl = test::device().gl();
        for (const GLenum off : {GL_CULL_FACE, GL_BLEND, GL_DITHER, GL_SCISSOR_TEST}) gl.Disable(off);
        if (test::device().capabilities().clip_control) gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
        gl.Enable(GL_DEPTH_TEST);
        gl.DepthFunc(GL_LESS);
        program_.bind();
        program_.set_mat4(u_clip_from_relative_, glm::value_ptr(clip));
        array_.bind();
        gl.DrawElements(GL_TRIANGLES, (field.width() - 1) * (field.depth() - 1) * 6, GL_UNSIGNED_INT, nullptr);
        return target.pixels();
    }

private:
    [[nodiscard]] std::size_t positions_bytes() const {
        return static_cast<std::size_t>(scene_->field().rect().count()) * 12;
    }
    static Result<gl::Buffer> make_indices(const HeightField& field) {
        std::vector<std::uint32_t> indices;
        const auto add = [&](std::int32_t x, std::int32_t z) {
            indices.push_back(static_cast<std::uint32_t>(z * field.width() + x));
        };
        for (std::int32_t z = 0; z + 1 < field.depth(); ++z)
            for (std::int32_t x = 0; x + 1 < field.width(); ++x) {
                add(x, z), add(x, z + 1), add(x + 1, z + 1);
                add(x, z), add(x + 1, z + 1), add(x + 1, z);
            }
        return gl::Buffer::create(test::device(), "reference mesh", indices.size() * 4, gl::BufferUsage::Static,
                                  indices.data());
    }

    const Scene* scene_;
    gl::ShaderLibrary shaders_;
    gl::Program program_;
    gl::Uniform u_clip_from_relative_;
    gl::VertexArray array_;
    gl::Buffer positions_, indices_;
};

}  // namespace tilth::test
