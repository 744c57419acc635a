#include "tilth/gl/texel_pass.h"

#include <algorithm>

#include "tilth/gl/api.h"

namespace tilth::gl {

Result<TexelPass> TexelPass::create(Device& device, ShaderLibrary& shaders, std::string_view label,
                                    std::string_view fragment_path, const Features& features) {
    Result<Program> program = shaders.program(label, "gl/texel_rects.vert", fragment_path, features);
    if (!program) return program.error();
    Result<Framebuffer> framebuffer = Framebuffer::create(device, label);
    if (!framebuffer) return framebuffer.error();
    Result<VertexArray> vertices = VertexArray::create(device, label);
    if (!vertices) return vertices.error();
    Result<Buffer> instances = Buffer::create(device, label, 16 * sizeof(PassRect), BufferUsage::Stream);
    if (!instances) return instances.error();
    return TexelPass(device, *std::move(program), *std::move(framebuffer), *std::move(vertices), *std::move(instances));
}

TexelPass::TexelPass(Device& device, Program program, Framebuffer framebuffer, VertexArray vertices, Buffer instances)
    : device_(&device),
      program_(std::move(program)),
      framebuffer_(std::move(framebuffer)),
      vertices_(std::move(vertices)),
      instances_(std::move(instances)) {
    u_target_size_texels_ = program_.uniform("u_target_size_texels");
    constexpr int stride = sizeof(PassRect);
    vertices_.int_attribute(0, instances_, 4, AttributeType::Int, stride, 0, 1);
    vertices_.int_attribute(1, instances_, 4, AttributeType::Int, stride, stride / 2, 1);
}

void TexelPass::begin(std::span<const Texture2D* const> targets, int level, StageStats& stats) {
    TILTH_ASSERT(!targets.empty(), "a texel pass needs a target");
    const Api& gl = device_->gl();
    framebuffer_.attach(targets, level);
    TILTH_EXPECTS(framebuffer_.check().ok(), framebuffer_.check().error().message);
    width_ = targets.front()->width(level);
    height_ = targets.front()->height(level);
    bytes_per_texel_ = 0;
    for (const Texture2D* target : targets) {
        TILTH_ASSERT(target->width(level) == width_ && target->height(level) == height_,
                     "the targets of a texel pass differ in size");
        bytes_per_texel_ += static_cast<std::uint64_t>(info_of(target->format()).stored_bytes);
    }

    // Whatever could change a value between the shader and the texel, or keep a fragment from running.
    gl.Viewport(0, 0, width_, height_);
    for (const GLenum capability :
         {GL_DITHER, GL_BLEND, GL_FRAMEBUFFER_SRGB, GL_COLOR_LOGIC_OP, GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_STENCIL_TEST,
          GL_CULL_FACE, GL_RASTERIZER_DISCARD, GL_SAMPLE_ALPHA_TO_COVERAGE, GL_SAMPLE_ALPHA_TO_ONE, GL_SAMPLE_COVERAGE,
          GL_SAMPLE_MASK, GL_POLYGON_OFFSET_FILL, GL_POLYGON_SMOOTH})
        gl.Disable(capability);
    for (GLenum i = 0; i < 8; ++i) gl.Disable(GL_CLIP_DISTANCE0 + i);
    gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    // An upper-left origin would mirror the target.
    if (device_->capabilities().clip_control) gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    program_.bind();
    program_.set(u_target_size_texels_, width_, height_);
    ++stats.passes;
}

void TexelPass::draw(std::span<const PassRect> rects, StageStats& stats) {
    if (rects.empty()) return;
    instances_.replace(std::as_bytes(rects));
    vertices_.bind();
    device_->gl().DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(rects.size()));
    ++stats.draws;
    stats.primitives += 2 * rects.size();
    for (const PassRect& rect : rects) {
        const std::int64_t width = std::max(0, std::min(rect.max_x, width_) - std::max(rect.min_x, 0));
        const std::int64_t depth = std::max(0, std::min(rect.max_z, height_) - std::max(rect.min_z, 0));
        stats.texels += static_cast<std::uint64_t>(width * depth);
        stats.bytes += static_cast<std::uint64_t>(width * depth) * bytes_per_texel_;
    }
}

}  // namespace tilth::gl
