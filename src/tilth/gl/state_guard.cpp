#include "tilth/gl/state_guard.h"

#include "tilth/gl/api.h"

namespace tilth::gl {
namespace {

// GL 4.3; the 3.3 loader does not name it.
constexpr GLenum kFixedIndexRestart = 0x8D69;

// ---- How one value is read and written. An entry of the table below is built from these.

std::int64_t integer_of(const Device& device, GLenum name) {
    GLint value = 0;
    device.gl().GetIntegerv(name, &value);
    return value;
}
GLuint name_in(const StateSlot& slot) { return static_cast<GLuint>(slot.integer); }
GLenum enum_in(const StateSlot& slot) { return static_cast<GLenum>(slot.integer); }
GLboolean boolean_in(const StateSlot& slot) { return slot.integer != 0 ? GL_TRUE : GL_FALSE; }
GLfloat float_in(const StateSlot& slot) { return static_cast<GLfloat>(slot.real); }

void set_enabled(const Device& device, GLenum capability, bool on) {
    on ? device.gl().Enable(capability) : device.gl().Disable(capability);
}

template <GLenum kCapability>
constexpr TouchedState switch_entry(std::string_view name) {
    return {name, 1, [](const Device& d, StateSlot* s) { s[0].integer = d.gl().IsEnabled(kCapability) != 0; },
            [](const Device& d, const StateSlot* s) { set_enabled(d, kCapability, s[0].integer != 0); }};
}

template <GLenum kTarget, GLenum kBinding>
constexpr TouchedState buffer_entry(std::string_view name) {
    return {name, 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, kBinding); },
            [](const Device& d, const StateSlot* s) { d.gl().BindBuffer(kTarget, name_in(s[0])); }};
}

template <GLenum kName>
constexpr TouchedState pixel_store_entry(std::string_view name) {
    return {name, 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, kName); },
            [](const Device& d, const StateSlot* s) { d.gl().PixelStorei(kName, static_cast<GLint>(s[0].integer)); }};
}

/// Texture bindings of one target on all touched units. Leaves the active unit changed; its entry comes later.
template <GLenum kTarget, GLenum kBinding>
constexpr TouchedState texture_entry(std::string_view name) {
    return {name, kTouchedTextureUnits,
            [](const Device& d, StateSlot* s) {
                for (int i = 0; i < kTouchedTextureUnits; ++i) {
                    d.gl().ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
                    s[i].integer = integer_of(d, kBinding);
                }
            },
            [](const Device& d, const StateSlot* s) {
                for (int i = 0; i < kTouchedTextureUnits; ++i) {
                    d.gl().ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
                    d.gl().BindTexture(kTarget, name_in(s[i]));
                }
            }};
}

int saved_viewports(const Device& device) { return device.capabilities().viewport_array ? 16 : 1; }

// ---- The table. `active texture` stands first so that it is saved before the texture entries move it; restoring runs
// from the end to the beginning, so it is put back last.

constexpr TouchedState kTouchedState[] = {
    {"active texture", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_ACTIVE_TEXTURE); },
     [](const Device& d, const StateSlot* s) { d.gl().ActiveTexture(enum_in(s[0])); }},
    texture_entry<GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D>("texture 2D"),
    texture_entry<GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BINDING_2D_ARRAY>("texture 2D array"),
    texture_entry<GL_TEXTURE_BUFFER, GL_TEXTURE_BINDING_BUFFER>("texture buffer"),
    {"samplers", kTouchedTextureUnits,
     [](const Device& d, StateSlot* s) {
         for (int i = 0; i < kTouchedTextureUnits; ++i) {
             d.gl().ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
             s[i].integer = integer_of(d, GL_SAMPLER_BINDING);
         }
     },
     [](const Device& d, const StateSlot* s) {
         for (int i = 0; i < kTouchedTextureUnits; ++i) d.gl().BindSampler(static_cast<GLuint>(i), name_in(s[i]));
     }},

    {"program", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_CURRENT_PROGRAM); },
     [](const Device& d, const StateSlot* s) {
         // A program that the host deleted while it was in use went when ours took its place.
         const bool exists = s[0].integer == 0 || d.gl().IsProgram(name_in(s[0])) == GL_TRUE;
         d.gl().UseProgram(exists ? name_in(s[0]) : 0);
     }},
    {"vertex array", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_VERTEX_ARRAY_BINDING); },
     [](const Device& d, const StateSlot* s) { d.gl().BindVertexArray(name_in(s[0])); }},
    {"draw framebuffer", 1,
     [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_DRAW_FRAMEBUFFER_BINDING); },
     [](const Device& d, const StateSlot* s) { d.gl().BindFramebuffer(GL_DRAW_FRAMEBUFFER, name_in(s[0])); }},
    {"read framebuffer", 1,
     [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_READ_FRAMEBUFFER_BINDING); },
     [](const Device& d, const StateSlot* s) { d.gl().BindFramebuffer(GL_READ_FRAMEBUFFER, name_in(s[0])); }},

    buffer_entry<GL_ARRAY_BUFFER, GL_ARRAY_BUFFER_BINDING>("array buffer"),
    buffer_entry<GL_PIXEL_PACK_BUFFER, GL_PIXEL_PACK_BUFFER_BINDING>("pixel pack buffer"),
    buffer_entry<GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_UNPACK_BUFFER_BINDING>("pixel unpack buffer"),
    buffer_entry<GL_COPY_READ_BUFFER, GL_COPY_READ_BUFFER>("copy read buffer"),
    buffer_entry<GL_COPY_WRITE_BUFFER, GL_COPY_WRITE_BUFFER>("copy write buffer"),
    // Before the indexed bindings in this list, hence restored after them: binding an index also binds this.
    buffer_entry<GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING>("uniform buffer"),
    {"indexed uniform buffers", 3 * kTouchedUniformBindings,
     [](const Device& d, StateSlot* s) {
         for (GLuint i = 0; i < kTouchedUniformBindings; ++i, s += 3) {
             GLint buffer = 0;
             GLint64 start = 0, size = 0;
             d.gl().GetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, i, &buffer);
             d.gl().GetInteger64i_v(GL_UNIFORM_BUFFER_START, i, &start);
             d.gl().GetInteger64i_v(GL_UNIFORM_BUFFER_SIZE, i, &size);
             s[0].integer = buffer, s[1].integer = start, s[2].integer = size;
         }
     },
     [](const Device& d, const StateSlot* s) {
         for (GLuint i = 0; i < kTouchedUniformBindings; ++i, s += 3) {
             if (s[2].integer == 0)  // bound whole, or not at all
                 d.gl().BindBufferBase(GL_UNIFORM_BUFFER, i, name_in(s[0]));
             else
                 d.gl().BindBufferRange(GL_UNIFORM_BUFFER, i, name_in(s[0]), static_cast<GLintptr>(s[1].integer),
                                        static_cast<GLsizeiptr>(s[2].integer));
         }
     }},

    pixel_store_entry<GL_PACK_SWAP_BYTES>("pack swap bytes"),
    pixel_store_entry<GL_PACK_LSB_FIRST>("pack lsb first"),
    pixel_store_entry<GL_PACK_ROW_LENGTH>("pack row length"),
    pixel_store_entry<GL_PACK_SKIP_ROWS>("pack skip rows"),
    pixel_store_entry<GL_PACK_SKIP_PIXELS>("pack skip pixels"),
    pixel_store_entry<GL_PACK_ALIGNMENT>("pack alignment"),
    pixel_store_entry<GL_PACK_IMAGE_HEIGHT>("pack image height"),
    pixel_store_entry<GL_PACK_SKIP_IMAGES>("pack skip images"),
    pixel_store_entry<GL_UNPACK_SWAP_BYTES>("unpack swap bytes"),
    pixel_store_entry<GL_UNPACK_LSB_FIRST>("unpack lsb first"),
    pixel_store_entry<GL_UNPACK_ROW_LENGTH>("unpack row length"),
    pixel_store_entry<GL_UNPACK_SKIP_ROWS>("unpack skip rows"),
    pixel_store_entry<GL_UNPACK_SKIP_PIXELS>("unpack skip pixels"),
    pixel_store_entry<GL_UNPACK_ALIGNMENT>("unpack alignment"),
    pixel_store_entry<GL_UNPACK_IMAGE_HEIGHT>("unpack image height"),
    pixel_store_entry<GL_UNPACK_SKIP_IMAGES>("unpack skip images"),
    {"clamp read colour", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_CLAMP_READ_COLOR); },
     [](const Device& d, const StateSlot* s) { d.gl().ClampColor(GL_CLAMP_READ_COLOR, enum_in(s[0])); }},

    // glViewport, glScissor, glDepthRange and glEnable(GL_SCISSOR_TEST) set all viewports of a viewport array.
    {"viewports", 4 * 16,
     [](const Device& d, StateSlot* s) {
         const int count = saved_viewports(d);
         for (int i = 0; i < count; ++i, s += 4) {
             GLfloat box[4] = {};
             count == 1 ? d.gl().GetFloatv(GL_VIEWPORT, box)
                        : d.gl().GetFloati_v(GL_VIEWPORT, static_cast<GLuint>(i), box);
             for (int k = 0; k < 4; ++k) s[k].real = box[k];
         }
     },
     [](const Device& d, const StateSlot* s) {
         const int count = saved_viewports(d);
         if (count == 1)
             return d.gl().Viewport(static_cast<GLint>(s[0].real), static_cast<GLint>(s[1].real),
                                    static_cast<GLsizei>(s[2].real), static_cast<GLsizei>(s[3].real));
         GLfloat boxes[4 * 16];
         for (int i = 0; i < 4 * count; ++i) boxes[i] = float_in(s[i]);
         d.gl().ViewportArrayv(0, count, boxes);
     }},
    {"scissor boxes", 4 * 16,
     [](const Device& d, StateSlot* s) {
         const int count = saved_viewports(d);
         for (int i = 0; i < count; ++i, s += 4) {
             GLint box[4] = {};
             count == 1 ? d.gl().GetIntegerv(GL_SCISSOR_BOX, box)
                        : d.gl().GetIntegeri_v(GL_SCISSOR_BOX, static_cast<GLuint>(i), box);
             for (int k = 0; k < 4; ++k) s[k].integer = box[k];
         }
     },
     [](const Device& d, const StateSlot* s) {
         const int count = saved_viewports(d);
         GLint boxes[4 * 16];
         for (int i = 0; i < 4 * count; ++i) boxes[i] = static_cast<GLint>(s[i].integer);
         count == 1 ? d.gl().Scissor(boxes[0], boxes[1], boxes[2], boxes[3]) : d.gl().ScissorArrayv(0, count, boxes);
     }},
    {"scissor tests", 16,
     [](const Device& d, StateSlot* s) {
         const int count = saved_viewports(d);
         if (count == 1) s[0].integer = d.gl().IsEnabled(GL_SCISSOR_TEST) != 0;
         for (int i = 0; count > 1 && i < count; ++i)
             s[i].integer = d.gl().IsEnabledi(GL_SCISSOR_TEST, static_cast<GLuint>(i)) != 0;
     },
     [](const Device& d, const StateSlot* s) {
         const int count = saved_viewports(d);
         set_enabled(d, GL_SCISSOR_TEST, s[0].integer != 0);
         for (int i = 1; i < count; ++i) {
             if (s[i].integer == s[0].integer) continue;
             const auto index = static_cast<GLuint>(i);
             s[i].integer != 0 ? d.gl().Enablei(GL_SCISSOR_TEST, index) : d.gl().Disablei(GL_SCISSOR_TEST, index);
         }
     }},
    {"depth ranges", 2 * 16,
     [](const Device& d, StateSlot* s) {
         const int count = saved_viewports(d);
         for (int i = 0; i < count; ++i, s += 2) {
             GLdouble range[2] = {};
             count == 1 ? d.gl().GetDoublev(GL_DEPTH_RANGE, range)
                        : d.gl().GetDoublei_v(GL_DEPTH_RANGE, static_cast<GLuint>(i), range);
             s[0].real = range[0], s[1].real = range[1];
         }
     },
     [](const Device& d, const StateSlot* s) {
         const int count = saved_viewports(d);
         if (count == 1) return d.gl().DepthRange(s[0].real, s[1].real);
         GLdouble ranges[2 * 16];
         for (int i = 0; i < 2 * count; ++i) ranges[i] = s[i].real;
         d.gl().DepthRangeArrayv(0, count, ranges);
     }},

    // glEnable(GL_BLEND), glBlendFunc and glColorMask set all draw buffers.
    {"blend", kTouchedDrawBuffers,
     [](const Device& d, StateSlot* s) {
         for (int i = 0; i < kTouchedDrawBuffers; ++i)
             s[i].integer = d.gl().IsEnabledi(GL_BLEND, static_cast<GLuint>(i)) != 0;
     },
     [](const Device& d, const StateSlot* s) {
         set_enabled(d, GL_BLEND, s[0].integer != 0);
         for (int i = 1; i < kTouchedDrawBuffers; ++i) {
             if (s[i].integer == s[0].integer) continue;
             const auto index = static_cast<GLuint>(i);
             s[i].integer != 0 ? d.gl().Enablei(GL_BLEND, index) : d.gl().Disablei(GL_BLEND, index);
         }
     }},
    {"blend functions", 6 * kTouchedDrawBuffers,
     [](const Device& d, StateSlot* s) {
         constexpr GLenum names[6] = {GL_BLEND_SRC_RGB,   GL_BLEND_DST_RGB,      GL_BLEND_SRC_ALPHA,
                                      GL_BLEND_DST_ALPHA, GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA};
         const int count = d.capabilities().draw_buffers_blend ? kTouchedDrawBuffers : 1;
         for (int i = 0; i < count; ++i) {
             for (GLenum name : names) {
                 GLint value = 0;
                 count == 1 ? d.gl().GetIntegerv(name, &value)
                            : d.gl().GetIntegeri_v(name, static_cast<GLuint>(i), &value);
                 (s++)->integer = value;
             }
         }
     },
     [](const Device& d, const StateSlot* s) {
         d.gl().BlendFuncSeparate(enum_in(s[0]), enum_in(s[1]), enum_in(s[2]), enum_in(s[3]));
         d.gl().BlendEquationSeparate(enum_in(s[4]), enum_in(s[5]));
         if (!d.capabilities().draw_buffers_blend) return;
         for (int i = 1; i < kTouchedDrawBuffers; ++i) {
             const StateSlot* own = s + 6 * i;
             bool same = true;
             for (int k = 0; k < 6; ++k) same = same && own[k].integer == s[k].integer;
             if (same) continue;
             const auto index = static_cast<GLuint>(i);
             d.gl().BlendFuncSeparateiARB(index, enum_in(own[0]), enum_in(own[1]), enum_in(own[2]), enum_in(own[3]));
             d.gl().BlendEquationSeparateiARB(index, enum_in(own[4]), enum_in(own[5]));
         }
     }},
    {"blend colour", 4,
     [](const Device& d, StateSlot* s) {
         GLfloat colour[4] = {};
         d.gl().GetFloatv(GL_BLEND_COLOR, colour);
         for (int i = 0; i < 4; ++i) s[i].real = colour[i];
     },
     [](const Device& d, const StateSlot* s) {
         d.gl().BlendColor(float_in(s[0]), float_in(s[1]), float_in(s[2]), float_in(s[3]));
     }},
    {"colour masks", 4 * kTouchedDrawBuffers,
     [](const Device& d, StateSlot* s) {
         for (int i = 0; i < kTouchedDrawBuffers; ++i, s += 4) {
             GLboolean mask[4] = {};
             d.gl().GetBooleani_v(GL_COLOR_WRITEMASK, static_cast<GLuint>(i), mask);
             for (int k = 0; k < 4; ++k) s[k].integer = mask[k];
         }
     },
     [](const Device& d, const StateSlot* s) {
         for (int i = 0; i < kTouchedDrawBuffers; ++i, s += 4)
             d.gl().ColorMaski(static_cast<GLuint>(i), boolean_in(s[0]), boolean_in(s[1]), boolean_in(s[2]),
                               boolean_in(s[3]));
     }},

    switch_entry<GL_DEPTH_TEST>("depth test"),
    {"depth function", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_DEPTH_FUNC); },
     [](const Device& d, const StateSlot* s) { d.gl().DepthFunc(enum_in(s[0])); }},
    {"depth mask", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_DEPTH_WRITEMASK); },
     [](const Device& d, const StateSlot* s) { d.gl().DepthMask(boolean_in(s[0])); }},
    switch_entry<GL_DEPTH_CLAMP>("depth clamp"),
    switch_entry<GL_POLYGON_SMOOTH>("polygon smooth"),
    switch_entry<GL_CULL_FACE>("cull face"),
    {"cull face mode", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_CULL_FACE_MODE); },
     [](const Device& d, const StateSlot* s) { d.gl().CullFace(enum_in(s[0])); }},
    {"front face", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_FRONT_FACE); },
     [](const Device& d, const StateSlot* s) { d.gl().FrontFace(enum_in(s[0])); }},
    {"polygon mode", 1,
     [](const Device& d, StateSlot* s) {
         GLint modes[2] = {};  // compatibility contexts answer with two
         d.gl().GetIntegerv(GL_POLYGON_MODE, modes);
         s[0].integer = modes[0];
     },
     [](const Device& d, const StateSlot* s) { d.gl().PolygonMode(GL_FRONT_AND_BACK, enum_in(s[0])); }},
    switch_entry<GL_POLYGON_OFFSET_FILL>("polygon offset fill"),
    switch_entry<GL_POLYGON_OFFSET_LINE>("polygon offset line"),
    {"polygon offset", 2,
     [](const Device& d, StateSlot* s) {
         GLfloat factor = 0, units = 0;
         d.gl().GetFloatv(GL_POLYGON_OFFSET_FACTOR, &factor);
         d.gl().GetFloatv(GL_POLYGON_OFFSET_UNITS, &units);
         s[0].real = factor, s[1].real = units;
     },
     [](const Device& d, const StateSlot* s) { d.gl().PolygonOffset(float_in(s[0]), float_in(s[1])); }},
    {"line width", 1,
     [](const Device& d, StateSlot* s) {
         GLfloat width = 1;
         d.gl().GetFloatv(GL_LINE_WIDTH, &width);
         s[0].real = width;
     },
     [](const Device& d, const StateSlot* s) { d.gl().LineWidth(float_in(s[0])); }},
    {"provoking vertex", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_PROVOKING_VERTEX); },
     [](const Device& d, const StateSlot* s) { d.gl().ProvokingVertex(enum_in(s[0])); }},

    switch_entry<GL_DITHER>("dither"),
    switch_entry<GL_FRAMEBUFFER_SRGB>("framebuffer sRGB"),
    switch_entry<GL_COLOR_LOGIC_OP>("logic op"),
    {"logic op mode", 1, [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_LOGIC_OP_MODE); },
     [](const Device& d, const StateSlot* s) { d.gl().LogicOp(enum_in(s[0])); }},
    switch_entry<GL_STENCIL_TEST>("stencil test"),
    switch_entry<GL_RASTERIZER_DISCARD>("rasterizer discard"),
    switch_entry<GL_MULTISAMPLE>("multisample"),
    switch_entry<GL_SAMPLE_ALPHA_TO_COVERAGE>("sample alpha to coverage"),
    switch_entry<GL_SAMPLE_ALPHA_TO_ONE>("sample alpha to one"),
    switch_entry<GL_SAMPLE_COVERAGE>("sample coverage"),
    switch_entry<GL_SAMPLE_MASK>("sample mask"),
    switch_entry<GL_CLIP_DISTANCE0>("clip distance 0"),
    switch_entry<GL_CLIP_DISTANCE0 + 1>("clip distance 1"),
    switch_entry<GL_CLIP_DISTANCE0 + 2>("clip distance 2"),
    switch_entry<GL_CLIP_DISTANCE0 + 3>("clip distance 3"),
    switch_entry<GL_CLIP_DISTANCE0 + 4>("clip distance 4"),
    switch_entry<GL_CLIP_DISTANCE0 + 5>("clip distance 5"),
    switch_entry<GL_CLIP_DISTANCE0 + 6>("clip distance 6"),
    switch_entry<GL_CLIP_DISTANCE0 + 7>("clip distance 7"),
    switch_entry<GL_PRIMITIVE_RESTART>("primitive restart"),
    {"primitive restart index", 1,
     [](const Device& d, StateSlot* s) { s[0].integer = integer_of(d, GL_PRIMITIVE_RESTART_INDEX); },
     [](const Device& d, const StateSlot* s) { d.gl().PrimitiveRestartIndex(name_in(s[0])); }},
    {"fixed index restart", 1,
     [](const Device& d, StateSlot* s) {
         s[0].integer = d.capabilities().fixed_index_restart && d.gl().IsEnabled(kFixedIndexRestart) != 0;
     },
     [](const Device& d, const StateSlot* s) {
         if (d.capabilities().fixed_index_restart) set_enabled(d, kFixedIndexRestart, s[0].integer != 0);
     }},

    {"clear colour", 4,
     [](const Device& d, StateSlot* s) {
         GLfloat colour[4] = {};
         d.gl().GetFloatv(GL_COLOR_CLEAR_VALUE, colour);
         for (int i = 0; i < 4; ++i) s[i].real = colour[i];
     },
     [](const Device& d, const StateSlot* s) {
         d.gl().ClearColor(float_in(s[0]), float_in(s[1]), float_in(s[2]), float_in(s[3]));
     }},
    {"clear depth", 1,
     [](const Device& d, StateSlot* s) {
         GLdouble depth = 1;
         d.gl().GetDoublev(GL_DEPTH_CLEAR_VALUE, &depth);
         s[0].real = depth;
     },
     [](const Device& d, const StateSlot* s) { d.gl().ClearDepth(s[0].real); }},
    {"clip control", 2,
     [](const Device& d, StateSlot* s) {
         if (!d.capabilities().clip_control) return;
         s[0].integer = integer_of(d, GL_CLIP_ORIGIN);
         s[1].integer = integer_of(d, GL_CLIP_DEPTH_MODE);
     },
     [](const Device& d, const StateSlot* s) {
         if (d.capabilities().clip_control) d.gl().ClipControl(enum_in(s[0]), enum_in(s[1]));
     }},
    {"patch vertices", 1,
     [](const Device& d, StateSlot* s) {
         if (d.capabilities().tessellation) s[0].integer = integer_of(d, GL_PATCH_VERTICES);
     },
     [](const Device& d, const StateSlot* s) {
         if (d.capabilities().tessellation) d.gl().PatchParameteri(GL_PATCH_VERTICES, static_cast<GLint>(s[0].integer));
     }},
};

constexpr std::size_t slots_of_table() {
    std::size_t sum = 0;
    for (const TouchedState& entry : kTouchedState) sum += static_cast<std::size_t>(entry.slots);
    return sum;
}
static_assert(slots_of_table() <= kMaxStateSlots);

}  // namespace

std::span<const TouchedState> touched_state() { return kTouchedState; }

StateGuard::StateGuard(const Device& device, std::span<const TouchedState> entries)
    : device_(device), entries_(entries) {
    StateSlot* next = slots_.data();
    for (const TouchedState& entry : entries_) {
        entry.save(device_, next);
        next += entry.slots;
    }
    // Reading the texture units moved the active one; the guarded scope starts from the host's state.
    if (!entries_.empty() && entries_.front().name == kTouchedState[0].name)
        entries_.front().restore(device_, slots_.data());
}

StateGuard::~StateGuard() {
    StateSlot* next = slots_.data();
    for (const TouchedState& entry : entries_) next += entry.slots;
    for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
        next -= entry->slots;
        entry->restore(device_, next);
    }
}

}  // namespace tilth::gl
