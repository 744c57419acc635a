// A draw that computes exact texels: one fragment for every texel of some rectangles, and none outside them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "tilth/core/result.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/objects.h"
#include "tilth/gl/shader_library.h"

namespace tilth::gl {

/// Texels of the target, half-open, and four integers that the fragment shader reads as `v_payload`.
struct PassRect {
    std::int32_t min_x = 0, min_z = 0, max_x = 0, max_z = 0;
    std::array<std::int32_t, 4> payload{};
};
static_assert(sizeof(PassRect) == 32, "read by the vertex array as two ivec4");

/// A fragment shader that runs once for each texel of rectangles in up to eight targets of one size.
///
/// The vertex shader is `gl/texel_rects.vert`; the fragment shader may declare `flat in ivec4 v_rect, v_payload;` and
/// finds its texel in `ivec2(gl_FragCoord.xy)`. Everything that could change the value of a texel on its way is
/// switched off: dither, blend, sRGB, logic op, scissor, depth, stencil, cull, discard, alpha to coverage. Rectangles
/// are clipped to the target; where they overlap, later ones win, as GL draws instances in order.
/// GL state: touches framebuffer, program, vertex array, viewport and the switches above; hold a `StateGuard`.
///
///     pass.begin(targets, 0, stats);              // binds framebuffer and program, sets state
///     pass.program().set(u_amplitude, 12);        // uniforms and textures of this pass
///     pass.draw(rects, stats);                    // as often as needed
class TexelPass {
public:
    static Result<TexelPass> create(Device& device, ShaderLibrary& shaders, std::string_view label,
                                    std::string_view fragment_path, const Features& features = {});

    [[nodiscard]] Program& program() { return program_; }

    /// Opens a pass that writes `level` of `targets`. Counts one pass. Changing targets is the expensive part of a
    /// pass (tens of microseconds on llvmpipe), so put many rectangles into one.
    void begin(std::span<const Texture2D* const> targets, int level, StageStats& stats);
    /// Draws all `rects` with one call; none, and nothing is drawn. Counts one draw, its texels and bytes.
    void draw(std::span<const PassRect> rects, StageStats& stats);

    /// begin, `setup(program)`, draw; with no rectangles it does nothing at all.
    template <class Setup>
    void run(std::span<const Texture2D* const> targets, int level, std::span<const PassRect> rects, StageStats& stats,
             const Setup& setup) {
        if (rects.empty()) return;
        begin(targets, level, stats);
        setup(program_);
        draw(rects, stats);
    }

private:
    TexelPass(Device& device, Program program, Framebuffer framebuffer, VertexArray vertices, Buffer instances);

    Device* device_;
    Program program_;
    Framebuffer framebuffer_;
    VertexArray vertices_;
    Buffer instances_;
    Uniform u_target_size_texels_;
    int width_ = 0, height_ = 0;  ///< of the open pass
    std::uint64_t bytes_per_texel_ = 0;
};

}  // namespace tilth::gl
