// The whole state of a GL context, read independently of the library's own list, to find what a call left changed.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/api.h"
#include "tilth/gl/device.h"

namespace tilth::test {

/// Name of a piece of state to its values.
using GlState = std::map<std::string, std::vector<double>>;

/// Everything that GL 3.3 core keeps in the context (and what later versions add in the same places): bindings of all
/// units and targets, switches, functions, boxes, pixel store, the bound vertex array's and framebuffer's own state.
/// Slow (some thousand queries). Leaves the state as it was, and no GL error.
inline GlState capture_state(const gl::Device& device) {
    const gl::Api& gl = device.gl();
    const gl::Capabilities& caps = device.capabilities();
    GlState state;
    const auto get = [&](const std::string& name, GLenum what, int count = 1) {
        std::vector<double> values(static_cast<std::size_t>(std::max(count, 4)), -12345.0);
        gl.GetDoublev(what, values.data());
        values.resize(static_cast<std::size_t>(count));
        state[name] = values;
    };
    const auto enabled = [&](const std::string& name, GLenum what) { state[name] = {double(gl.IsEnabled(what))}; };

    const GLenum active = [&] {
        GLint unit = 0;
        gl.GetIntegerv(GL_ACTIVE_TEXTURE, &unit);
        return static_cast<GLenum>(unit);
    }();
    get("GL_ACTIVE_TEXTURE", GL_ACTIVE_TEXTURE);
    const int units = std::min(caps.max_texture_units, 32);
    for (int i = 0; i < units; ++i) {
        gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
        const std::string unit = text(" of unit ", i);
        get(text("GL_TEXTURE_BINDING_1D", unit), GL_TEXTURE_BINDING_1D);
        get(text("GL_TEXTURE_BINDING_2D", unit), GL_TEXTURE_BINDING_2D);
        get(text("GL_TEXTURE_BINDING_3D", unit), GL_TEXTURE_BINDING_3D);
        get(text("GL_TEXTURE_BINDING_1D_ARRAY", unit), GL_TEXTURE_BINDING_1D_ARRAY);
        get(text("GL_TEXTURE_BINDING_2D_ARRAY", unit), GL_TEXTURE_BINDING_2D_ARRAY);
        get(text("GL_TEXTURE_BINDING_CUBE_MAP", unit), GL_TEXTURE_BINDING_CUBE_MAP);
        get(text("GL_TEXTURE_BINDING_RECTANGLE", unit), GL_TEXTURE_BINDING_RECTANGLE);
        get(text("GL_TEXTURE_BINDING_BUFFER", unit), GL_TEXTURE_BINDING_BUFFER);
        get(text("GL_TEXTURE_BINDING_2D_MULTISAMPLE", unit), GL_TEXTURE_BINDING_2D_MULTISAMPLE);
        get(text("GL_SAMPLER_BINDING", unit), GL_SAMPLER_BINDING);
    }
    gl.ActiveTexture(active);

    get("GL_CURRENT_PROGRAM", GL_CURRENT_PROGRAM);
    get("GL_VERTEX_ARRAY_BINDING", GL_VERTEX_ARRAY_BINDING);
    get("GL_DRAW_FRAMEBUFFER_BINDING", GL_DRAW_FRAMEBUFFER_BINDING);
    get("GL_READ_FRAMEBUFFER_BINDING", GL_READ_FRAMEBUFFER_BINDING);
    get("GL_RENDERBUFFER_BINDING", GL_RENDERBUFFER_BINDING);
    get("GL_ARRAY_BUFFER_BINDING", GL_ARRAY_BUFFER_BINDING);
    get("GL_PIXEL_PACK_BUFFER_BINDING", GL_PIXEL_PACK_BUFFER_BINDING);
    get("GL_PIXEL_UNPACK_BUFFER_BINDING", GL_PIXEL_UNPACK_BUFFER_BINDING);
    get("GL_COPY_READ_BUFFER", GL_COPY_READ_BUFFER);
    get("GL_COPY_WRITE_BUFFER", GL_COPY_WRITE_BUFFER);
    get("GL_UNIFORM_BUFFER_BINDING", GL_UNIFORM_BUFFER_BINDING);
    get("GL_TRANSFORM_FEEDBACK_BUFFER_BINDING", GL_TRANSFORM_FEEDBACK_BUFFER_BINDING);
    const auto indexed_buffers = [&](const std::string& name, int count, GLenum binding, GLenum start, GLenum size) {
        for (int i = 0; i < count; ++i) {
            const auto index = static_cast<GLuint>(i);
            GLint buffer = 0;
            GLint64 first = 0, length = 0;
            gl.GetIntegeri_v(binding, index, &buffer);
            gl.GetInteger64i_v(start, index, &first);
            gl.GetInteger64i_v(size, index, &length);
            state[text(name, " ", i)] = {double(buffer), double(first), double(length)};
        }
    };
    indexed_buffers("indexed uniform buffer", 24, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START,
                    GL_UNIFORM_BUFFER_SIZE);
    indexed_buffers("indexed transform feedback buffer", 4, GL_TRANSFORM_FEEDBACK_BUFFER_BINDING,
                    GL_TRANSFORM_FEEDBACK_BUFFER_START, GL_TRANSFORM_FEEDBACK_BUFFER_SIZE);

    // The bound vertex array's own state.
    GLint vertex_array = 0;
    gl.GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
    if (vertex_array != 0) {
        get("GL_ELEMENT_ARRAY_BUFFER_BINDING", GL_ELEMENT_ARRAY_BUFFER_BINDING);
        for (GLuint i = 0; i < 16; ++i) {
            std::vector<double> values;
            for (GLenum what :
                 {GL_VERTEX_ATTRIB_ARRAY_ENABLED, GL_VERTEX_ATTRIB_ARRAY_SIZE, GL_VERTEX_ATTRIB_ARRAY_STRIDE,
                  GL_VERTEX_ATTRIB_ARRAY_TYPE, GL_VERTEX_ATTRIB_ARRAY_BUFFER_BINDING, GL_VERTEX_ATTRIB_ARRAY_DIVISOR}) {
                GLint attribute = 0;
                gl.GetVertexAttribiv(i, what, &attribute);
                values.push_back(attribute);
            }
            state[text("vertex attribute ", i)] = values;
        }
    }
    // The bound framebuffer's own state. Without a default framebuffer there is nothing to ask.
    GLint draw_framebuffer = 0, read_framebuffer = 0;
    gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer);
    gl.GetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_framebuffer);
    if (read_framebuffer != 0) get("GL_READ_BUFFER", GL_READ_BUFFER);
    if (draw_framebuffer != 0) {
        for (GLenum i = 0; i < 8; ++i) {
            get(text("GL_DRAW_BUFFER", i), GL_DRAW_BUFFER0 + i);
            GLint kind = 0, name = 0, level = 0;
            gl.GetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + i,
                                                   GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &kind);
            if (kind != GL_NONE)
                gl.GetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + i,
                                                       GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME, &name);
            if (kind == GL_TEXTURE)
                gl.GetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + i,
                                                       GL_FRAMEBUFFER_ATTACHMENT_TEXTURE_LEVEL, &level);
            state[text("colour attachment ", i)] = {double(kind), double(name), double(level)};
        }
    }

    for (const char* side : {"PACK", "UNPACK"}) {
        const bool pack = side[0] == 'P';
        const std::string name = text("GL_", side);
        get(text(name, "_SWAP_BYTES"), pack ? GL_PACK_SWAP_BYTES : GL_UNPACK_SWAP_BYTES);
        get(text(name, "_LSB_FIRST"), pack ? GL_PACK_LSB_FIRST : GL_UNPACK_LSB_FIRST);
        get(text(name, "_ROW_LENGTH"), pack ? GL_PACK_ROW_LENGTH : GL_UNPACK_ROW_LENGTH);
        get(text(name, "_SKIP_ROWS"), pack ? GL_PACK_SKIP_ROWS : GL_UNPACK_SKIP_ROWS);
        get(text(name, "_SKIP_PIXELS"), pack ? GL_PACK_SKIP_PIXELS : GL_UNPACK_SKIP_PIXELS);
        get(text(name, "_ALIGNMENT"), pack ? GL_PACK_ALIGNMENT : GL_UNPACK_ALIGNMENT);
        get(text(name, "_IMAGE_HEIGHT"), pack ? GL_PACK_IMAGE_HEIGHT : GL_UNPACK_IMAGE_HEIGHT);
        get(text(name, "_SKIP_IMAGES"), pack ? GL_PACK_SKIP_IMAGES : GL_UNPACK_SKIP_IMAGES);
    }
    get("GL_CLAMP_READ_COLOR", GL_CLAMP_READ_COLOR);

    const int viewports = caps.viewport_array ? 16 : 1;
    get("GL_VIEWPORT", GL_VIEWPORT, 4);
    get("GL_SCISSOR_BOX", GL_SCISSOR_BOX, 4);
    get("GL_DEPTH_RANGE", GL_DEPTH_RANGE, 2);
    enabled("GL_SCISSOR_TEST", GL_SCISSOR_TEST);
    for (int i = 0; viewports > 1 && i < viewports; ++i) {
        const auto index = static_cast<GLuint>(i);
        const std::string of = text(" ", i);
        GLfloat box[4] = {};
        GLint scissor[4] = {};
        GLdouble range[2] = {};
        gl.GetFloati_v(GL_VIEWPORT, index, box);
        gl.GetIntegeri_v(GL_SCISSOR_BOX, index, scissor);
        gl.GetDoublei_v(GL_DEPTH_RANGE, index, range);
        state[text("viewport", of)] = {box[0], box[1], box[2], box[3]};
        state[text("scissor box", of)] = {double(scissor[0]), double(scissor[1]), double(scissor[2]),
                                          double(scissor[3])};
        state[text("depth range", of)] = {range[0], range[1]};
        state[text("scissor test", of)] = {double(gl.IsEnabledi(GL_SCISSOR_TEST, index))};
    }

    for (GLuint i = 0; i < 8; ++i) {
        const std::string of = text(" ", i);
        GLboolean mask[4] = {};
        gl.GetBooleani_v(GL_COLOR_WRITEMASK, i, mask);
        state[text("colour mask", of)] = {double(mask[0]), double(mask[1]), double(mask[2]), double(mask[3])};
        state[text("blend", of)] = {double(gl.IsEnabledi(GL_BLEND, i))};
        if (!caps.draw_buffers_blend) continue;
        std::vector<double> functions;
        for (GLenum what : {GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA,
                            GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA}) {
            GLint function = 0;
            gl.GetIntegeri_v(what, i, &function);
            functions.push_back(function);
        }
        state[text("blend functions", of)] = functions;
    }
    get("GL_BLEND_SRC_RGB", GL_BLEND_SRC_RGB);
    get("GL_BLEND_DST_RGB", GL_BLEND_DST_RGB);
    get("GL_BLEND_SRC_ALPHA", GL_BLEND_SRC_ALPHA);
    get("GL_BLEND_DST_ALPHA", GL_BLEND_DST_ALPHA);
    get("GL_BLEND_EQUATION_RGB", GL_BLEND_EQUATION_RGB);
    get("GL_BLEND_EQUATION_ALPHA", GL_BLEND_EQUATION_ALPHA);
    get("GL_BLEND_COLOR", GL_BLEND_COLOR, 4);

    enabled("GL_DEPTH_TEST", GL_DEPTH_TEST);
    get("GL_DEPTH_FUNC", GL_DEPTH_FUNC);
    get("GL_DEPTH_WRITEMASK", GL_DEPTH_WRITEMASK);
    enabled("GL_DEPTH_CLAMP", GL_DEPTH_CLAMP);
    enabled("GL_STENCIL_TEST", GL_STENCIL_TEST);
    get("GL_STENCIL_FUNC", GL_STENCIL_FUNC);
    get("GL_STENCIL_REF", GL_STENCIL_REF);
    get("GL_STENCIL_VALUE_MASK", GL_STENCIL_VALUE_MASK);
    get("GL_STENCIL_WRITEMASK", GL_STENCIL_WRITEMASK);
    get("GL_STENCIL_FAIL", GL_STENCIL_FAIL);
    get("GL_STENCIL_PASS_DEPTH_FAIL", GL_STENCIL_PASS_DEPTH_FAIL);
    get("GL_STENCIL_PASS_DEPTH_PASS", GL_STENCIL_PASS_DEPTH_PASS);
    get("GL_STENCIL_BACK_FUNC", GL_STENCIL_BACK_FUNC);
    get("GL_STENCIL_BACK_REF", GL_STENCIL_BACK_REF);
    get("GL_STENCIL_BACK_WRITEMASK", GL_STENCIL_BACK_WRITEMASK);
    enabled("GL_CULL_FACE", GL_CULL_FACE);
    get("GL_CULL_FACE_MODE", GL_CULL_FACE_MODE);
    get("GL_FRONT_FACE", GL_FRONT_FACE);
    get("GL_POLYGON_MODE", GL_POLYGON_MODE);
    enabled("GL_POLYGON_OFFSET_FILL", GL_POLYGON_OFFSET_FILL);
    enabled("GL_POLYGON_OFFSET_LINE", GL_POLYGON_OFFSET_LINE);
    enabled("GL_POLYGON_OFFSET_POINT", GL_POLYGON_OFFSET_POINT);
    get("GL_POLYGON_OFFSET_FACTOR", GL_POLYGON_OFFSET_FACTOR);
    get("GL_POLYGON_OFFSET_UNITS", GL_POLYGON_OFFSET_UNITS);
    enabled("GL_POLYGON_SMOOTH", GL_POLYGON_SMOOTH);
    enabled("GL_LINE_SMOOTH", GL_LINE_SMOOTH);
    get("GL_LINE_WIDTH", GL_LINE_WIDTH);
    get("GL_POINT_SIZE", GL_POINT_SIZE);
    get("GL_POINT_FADE_THRESHOLD_SIZE", GL_POINT_FADE_THRESHOLD_SIZE);
    get("GL_POINT_SPRITE_COORD_ORIGIN", GL_POINT_SPRITE_COORD_ORIGIN);
    enabled("GL_PROGRAM_POINT_SIZE", GL_PROGRAM_POINT_SIZE);
    get("GL_PROVOKING_VERTEX", GL_PROVOKING_VERTEX);
    enabled("GL_DITHER", GL_DITHER);
    enabled("GL_FRAMEBUFFER_SRGB", GL_FRAMEBUFFER_SRGB);
    enabled("GL_COLOR_LOGIC_OP", GL_COLOR_LOGIC_OP);
    get("GL_LOGIC_OP_MODE", GL_LOGIC_OP_MODE);
    enabled("GL_RASTERIZER_DISCARD", GL_RASTERIZER_DISCARD);
    enabled("GL_TEXTURE_CUBE_MAP_SEAMLESS", GL_TEXTURE_CUBE_MAP_SEAMLESS);
    enabled("GL_MULTISAMPLE", GL_MULTISAMPLE);
    enabled("GL_SAMPLE_ALPHA_TO_COVERAGE", GL_SAMPLE_ALPHA_TO_COVERAGE);
    enabled("GL_SAMPLE_ALPHA_TO_ONE", GL_SAMPLE_ALPHA_TO_ONE);
    enabled("GL_SAMPLE_COVERAGE", GL_SAMPLE_COVERAGE);
    get("GL_SAMPLE_COVERAGE_VALUE", GL_SAMPLE_COVERAGE_VALUE);
    get("GL_SAMPLE_COVERAGE_INVERT", GL_SAMPLE_COVERAGE_INVERT);
    enabled("GL_SAMPLE_MASK", GL_SAMPLE_MASK);
    for (GLenum i = 0; i < 8; ++i) enabled(text("GL_CLIP_DISTANCE", i), GL_CLIP_DISTANCE0 + i);
    enabled("GL_PRIMITIVE_RESTART", GL_PRIMITIVE_RESTART);
    get("GL_PRIMITIVE_RESTART_INDEX", GL_PRIMITIVE_RESTART_INDEX);
    constexpr GLenum fixed_index = 0x8D69;  // GL 4.3
    if (caps.fixed_index_restart) enabled("GL_PRIMITIVE_RESTART_FIXED_INDEX", fixed_index);
    get("GL_COLOR_CLEAR_VALUE", GL_COLOR_CLEAR_VALUE, 4);
    get("GL_DEPTH_CLEAR_VALUE", GL_DEPTH_CLEAR_VALUE);
    get("GL_STENCIL_CLEAR_VALUE", GL_STENCIL_CLEAR_VALUE);
    get("GL_LINE_SMOOTH_HINT", GL_LINE_SMOOTH_HINT);
    get("GL_POLYGON_SMOOTH_HINT", GL_POLYGON_SMOOTH_HINT);
    get("GL_TEXTURE_COMPRESSION_HINT", GL_TEXTURE_COMPRESSION_HINT);
    get("GL_FRAGMENT_SHADER_DERIVATIVE_HINT", GL_FRAGMENT_SHADER_DERIVATIVE_HINT);
    if (caps.clip_control) {
        get("GL_CLIP_ORIGIN", GL_CLIP_ORIGIN);
        get("GL_CLIP_DEPTH_MODE", GL_CLIP_DEPTH_MODE);
    }
    if (caps.tessellation) get("GL_PATCH_VERTICES", GL_PATCH_VERTICES);
    if (caps.debug) {
        enabled("GL_DEBUG_OUTPUT", GL_DEBUG_OUTPUT);
        enabled("GL_DEBUG_OUTPUT_SYNCHRONOUS", GL_DEBUG_OUTPUT_SYNCHRONOUS);
        get("GL_DEBUG_GROUP_STACK_DEPTH", GL_DEBUG_GROUP_STACK_DEPTH);
    }
    for (GLenum target : {GL_SAMPLES_PASSED, GL_PRIMITIVES_GENERATED, GL_TIME_ELAPSED}) {
        GLint query = 0;
        gl.GetQueryiv(target, GL_CURRENT_QUERY, &query);
        state[text("current query ", target)] = {double(query)};
    }
    return state;
}

/// What differs, one line each: "GL_BLEND_COLOR: 0.25 0 0 1 -> 0 0 0 0". Empty if nothing does.
inline std::string difference(const GlState& before, const GlState& after) {
    std::ostringstream out;
    for (const auto& [name, values] : before) {
        const auto now = after.find(name);
        if (now != after.end() && now->second == values) continue;
        out << name << ':';
        for (double value : values) out << ' ' << value;
        out << " ->";
        if (now == after.end())
            out << " (gone)";
        else
            for (double value : now->second) out << ' ' << value;
        out << '\n';
    }
    for (const auto& [name, values] : after)
        if (!before.contains(name)) out << name << ": appeared\n";
    return out.str();
}

}  // namespace tilth::test
