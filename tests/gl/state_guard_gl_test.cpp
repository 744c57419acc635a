// Does the guard put everything back? Each piece of state is set to an odd value, scrambled, and compared with an
// independent query of the whole state; and each entry of the table is shown to be needed, by leaving it out.
#include <gtest/gtest.h>

#include <chrono>

#include "support/gl_context.h"
#include "support/gl_state.h"
#include "tilth/gl/state_guard.h"

namespace tilth::gl {
namespace {

/// Two sets of host objects, so that every binding has two different values.
class HostState {
public:
    explicit HostState(Device& device) : device_(device), gl_(device.gl()) {
        ShaderLibrary shaders = test::shaders(device);
        for (Objects& o : objects_) {
            gl_.GenTextures(static_cast<GLsizei>(o.textures.size()), o.textures.data());
            gl_.GenSamplers(1, &o.sampler);
            gl_.GenVertexArrays(1, &o.vertex_array);
            gl_.GenFramebuffers(2, o.framebuffers.data());
            gl_.GenBuffers(static_cast<GLsizei>(o.buffers.size()), o.buffers.data());
            for (GLuint buffer : o.buffers) {
                gl_.BindBuffer(GL_ARRAY_BUFFER, buffer);
                gl_.BufferData(GL_ARRAY_BUFFER, 4096, nullptr, GL_STATIC_DRAW);
            }
            o.program = gl_.CreateProgram();
            const char* text = "#version 330 core\nvoid main() { gl_Position = vec4(0.0); }";
            const GLuint shader = gl_.CreateShader(GL_VERTEX_SHADER);
            gl_.ShaderSource(shader, 1, &text, nullptr);
            gl_.CompileShader(shader);
            gl_.AttachShader(o.program, shader);
            gl_.LinkProgram(o.program);
            gl_.DeleteShader(shader);
        }
    }
    ~HostState() {
        for (Objects& o : objects_) {
            gl_.DeleteTextures(static_cast<GLsizei>(o.textures.size()), o.textures.data());
            gl_.DeleteSamplers(1, &o.sampler);
            gl_.DeleteVertexArrays(1, &o.vertex_array);
            gl_.DeleteFramebuffers(2, o.framebuffers.data());
            gl_.DeleteBuffers(static_cast<GLsizei>(o.buffers.size()), o.buffers.data());
            gl_.DeleteProgram(o.program);
        }
    }

    void forget_program(std::size_t variant) { objects_[variant].program = 0; }

    /// Sets every piece of state that the library may touch; variants 0 and 1 differ in each, and from the defaults
    /// wherever there is a third value.
    void set(int variant) {
        const Objects& o = objects_[static_cast<std::size_t>(variant)];
        const bool odd = variant == 1;
        const auto v = static_cast<GLint>(variant);
        const auto f = static_cast<GLfloat>(variant);
        const auto toggle = [&](GLenum what, bool on) { on ? gl_.Enable(what) : gl_.Disable(what); };

        for (int i = 0; i < kTouchedTextureUnits; ++i) {
            gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
            gl_.BindTexture(GL_TEXTURE_2D, o.textures[0]);
            gl_.BindTexture(GL_TEXTURE_2D_ARRAY, o.textures[1]);
            gl_.BindTexture(GL_TEXTURE_BUFFER, o.textures[2]);
            gl_.BindSampler(static_cast<GLuint>(i), i % 3 == variant ? 0 : o.sampler);
        }
        gl_.ActiveTexture(GL_TEXTURE0 + 5 + static_cast<GLenum>(variant));
        gl_.UseProgram(o.program);
        gl_.BindVertexArray(o.vertex_array);
        gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, o.framebuffers[0]);
        gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, o.framebuffers[1]);
        for (GLuint i = 0; i < kTouchedUniformBindings; ++i) {
            if (i == 3)
                gl_.BindBufferBase(GL_UNIFORM_BUFFER, i, o.buffers[6]);
            else if (i == 4 && odd)
                gl_.BindBufferBase(GL_UNIFORM_BUFFER, i, 0);
            else
                gl_.BindBufferRange(GL_UNIFORM_BUFFER, i, o.buffers[6], 256 * (v + 1), 512);
        }
        constexpr std::array targets{GL_ARRAY_BUFFER,     GL_PIXEL_PACK_BUFFER, GL_PIXEL_UNPACK_BUFFER,
                                     GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, GL_UNIFORM_BUFFER};
        for (std::size_t i = 0; i < targets.size(); ++i) gl_.BindBuffer(targets[i], o.buffers[i]);

        for (GLenum what : {GL_PACK_SWAP_BYTES, GL_UNPACK_SWAP_BYTES, GL_PACK_LSB_FIRST, GL_UNPACK_LSB_FIRST})
            gl_.PixelStorei(what, v);
        for (GLenum what : {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_PACK_IMAGE_HEIGHT,
                            GL_PACK_SKIP_IMAGES, GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS,
                            GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES})
            gl_.PixelStorei(what, 7 + 4 * v);
        for (GLenum what : {GL_PACK_ALIGNMENT, GL_UNPACK_ALIGNMENT}) gl_.PixelStorei(what, odd ? 2 : 8);
        gl_.ClampColor(GL_CLAMP_READ_COLOR, odd ? GL_TRUE : GL_FALSE);

        gl_.Viewport(1 + v, 2, 33, 44);
        gl_.Scissor(3, 4 + v, 55, 66);
        gl_.DepthRange(0.125 + 0.125 * variant, 0.875);
        toggle(GL_SCISSOR_TEST, odd);
        if (device_.capabilities().viewport_array) {
            gl_.ViewportIndexedf(3, 1.5f + f, 2, 3, 4);
            gl_.ScissorIndexed(5, 9 + v, 8, 7, 6);
            gl_.DepthRangeIndexed(7, 0.25, 0.5 + 0.125 * variant);
            gl_.Enablei(GL_SCISSOR_TEST, 2);
            gl_.Disablei(GL_SCISSOR_TEST, 4);
        }
        toggle(GL_BLEND, odd);
        odd ? gl_.Disablei(GL_BLEND, 2) : gl_.Enablei(GL_BLEND, 2);
        gl_.BlendFuncSeparate(odd ? GL_DST_COLOR : GL_SRC_ALPHA, GL_ONE_MINUS_DST_ALPHA, GL_ZERO, GL_SRC_COLOR);
        gl_.BlendEquationSeparate(odd ? GL_MIN : GL_FUNC_SUBTRACT, GL_MAX);
        if (device_.capabilities().draw_buffers_blend) {
            gl_.BlendFuncSeparateiARB(6, GL_ONE, odd ? GL_ONE : GL_ZERO, GL_ZERO, GL_ONE);
            gl_.BlendEquationSeparateiARB(6, GL_FUNC_REVERSE_SUBTRACT, odd ? GL_MIN : GL_MAX);
        }
        gl_.BlendColor(0.25f, 0.5f * f, 0.75f, 0.125f);
        gl_.ColorMask(odd, !odd, odd, GL_TRUE);
        gl_.ColorMaski(5, !odd, odd, GL_FALSE, GL_FALSE);

        toggle(GL_DEPTH_TEST, odd);
        gl_.DepthFunc(odd ? GL_GREATER : GL_NOTEQUAL);
        gl_.DepthMask(odd);
        toggle(GL_DEPTH_CLAMP, odd);
        toggle(GL_POLYGON_SMOOTH, odd);
        toggle(GL_CULL_FACE, odd);
        gl_.CullFace(odd ? GL_FRONT : GL_FRONT_AND_BACK);
        gl_.FrontFace(odd ? GL_CW : GL_CCW);
        gl_.PolygonMode(GL_FRONT_AND_BACK, odd ? GL_LINE : GL_POINT);
        gl_.PolygonOffset(1.5f + f, -2.25f);
        gl_.LineWidth(odd ? 2 : 1);
        gl_.ProvokingVertex(odd ? GL_FIRST_VERTEX_CONVENTION : GL_LAST_VERTEX_CONVENTION);
        for (GLenum what :
             {GL_POLYGON_OFFSET_FILL, GL_POLYGON_OFFSET_LINE, GL_DITHER, GL_FRAMEBUFFER_SRGB, GL_COLOR_LOGIC_OP,
              GL_STENCIL_TEST, GL_RASTERIZER_DISCARD, GL_MULTISAMPLE, GL_SAMPLE_ALPHA_TO_COVERAGE,
              GL_SAMPLE_ALPHA_TO_ONE, GL_SAMPLE_COVERAGE, GL_SAMPLE_MASK, GL_PRIMITIVE_RESTART})
            toggle(what, odd);
        for (GLenum i = 0; i < 8; ++i) toggle(GL_CLIP_DISTANCE0 + i, odd);
        gl_.LogicOp(odd ? GL_XOR : GL_NAND);
        gl_.PrimitiveRestartIndex(0xabcdu + static_cast<GLuint>(variant));
        constexpr GLenum fixed_index = 0x8D69;
        if (device_.capabilities().fixed_index_restart) toggle(fixed_index, odd);
        gl_.ClearColor(0.5f, 0.25f, 0.125f, 0.5f * f);
        gl_.ClearDepth(0.25 + 0.5 * variant);
        if (device_.capabilities().clip_control)
            gl_.ClipControl(odd ? GL_UPPER_LEFT : GL_LOWER_LEFT, odd ? GL_NEGATIVE_ONE_TO_ONE : GL_ZERO_TO_ONE);
        if (device_.capabilities().tessellation) gl_.PatchParameteri(GL_PATCH_VERTICES, odd ? 10 : 4);
    }

private:
    struct Objects {
        std::array<GLuint, 3> textures{};
        GLuint sampler = 0, vertex_array = 0, program = 0;
        std::array<GLuint, 2> framebuffers{};
        std::array<GLuint, 7> buffers{};  ///< the last one for the indexed bindings
    };
    Device& device_;
    const Api& gl_;
    std::array<Objects, 2> objects_;
};

class StateGuardTest : public test::GlTest {};

TEST_F(StateGuardTest, everything_is_as_it_was) {
    HostState host(device());
    StateGuard outer(device());  // for the tests that follow in this process
    for (int variant : {0, 1}) {
        host.set(variant);
        const test::GlState before = test::capture_state(device());
        {
            StateGuard guard(device());
            EXPECT_EQ(test::difference(before, test::capture_state(device())), "") << "construction changed state";
            host.set(1 - variant);
            EXPECT_NE(test::difference(before, test::capture_state(device())), "");
        }
        EXPECT_EQ(test::difference(before, test::capture_state(device())), "") << "variant " << variant;
    }
}

TEST_F(StateGuardTest, each_entry_of_the_table_is_needed) {
    HostState host(device());
    StateGuard outer(device());
    const Capabilities& caps = device().capabilities();
    for (std::size_t left_out = 0; left_out < touched_state().size(); ++left_out) {
        const std::string_view name = touched_state()[left_out].name;
        if ((name == "clip control" && !caps.clip_control) || (name == "patch vertices" && !caps.tessellation) ||
            (name == "fixed index restart" && !caps.fixed_index_restart))
            continue;
        std::vector<TouchedState> entries(touched_state().begin(), touched_state().end());
        entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(left_out));
        host.set(0);
        const test::GlState before = test::capture_state(device());
        {
            StateGuard guard(device(), entries);
            host.set(1);
        }
        EXPECT_NE(test::difference(before, test::capture_state(device())), "")
            << "without \"" << name << "\" nothing is missing: the test does not change it, or the entry is dead";
    }
}

TEST_F(StateGuardTest, a_program_that_the_host_deleted_while_in_use_is_no_error) {
    const Api& gl = device().gl();
    HostState host(device());
    StateGuard outer(device());
    host.set(0);
    GLint program = 0;
    gl.GetIntegerv(GL_CURRENT_PROGRAM, &program);
    gl.DeleteProgram(static_cast<GLuint>(program));
    {
        StateGuard guard(device());
        gl.UseProgram(0);
    }
    EXPECT_TRUE(device().take_errors().empty());
    gl.GetIntegerv(GL_CURRENT_PROGRAM, &program);
    EXPECT_EQ(program, 0);
    host.forget_program(0);
}

TEST_F(StateGuardTest, capture_leaves_the_state_alone) {
    const test::GlState before = test::capture_state(device());
    EXPECT_EQ(test::difference(before, test::capture_state(device())), "");
    EXPECT_GT(before.size(), 300u);
}

TEST_F(StateGuardTest, costs_less_than_a_millisecond) {
    constexpr int kRounds = 50;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < kRounds; ++i) StateGuard guard(device());
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
    RecordProperty("microseconds_per_guard", std::to_string(took.count() / kRounds));
    std::printf("one guard: %.1f microseconds\n", took.count() / kRounds);
    EXPECT_LT(took.count() / kRounds, 1000.0);
}

}  // namespace
}  // namespace tilth::gl
