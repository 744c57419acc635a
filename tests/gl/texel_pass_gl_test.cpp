// One fragment for every texel of the rectangles, none outside, whatever the host left switched on.
#include "tilth/gl/texel_pass.h"

#include <gtest/gtest.h>

#include <random>

#include "support/gl_context.h"
#include "tilth/gl/state_guard.h"

namespace tilth::gl {
namespace {

constexpr std::int32_t kSentinel = -77;

class TexelPassTest : public test::GlTest {
protected:
    Texture2D integers(const char* label, int width, int height, int levels = 1) {
        Texture2D texture = test::value(Texture2D::create(device(), label, {Format::Rgba32I, width, height, levels}));
        for (int level = 0; level < levels; ++level) {
            const std::vector<std::int32_t> fill(static_cast<std::size_t>(texture.bounds(level).count()) * 4,
                                                 kSentinel);
            texture.upload(level, texture.bounds(level), fill.data());
        }
        return texture;
    }
    static std::vector<std::int32_t> read(const Texture2D& texture, int level = 0) {
        std::vector<std::int32_t> texels(static_cast<std::size_t>(texture.bounds(level).count()) * 4);
        texture.read(level, texels.data());
        return texels;
    }
    /// Draws `rects` and compares both targets, texel by texel, with a painter's loop.
    void draw_and_compare(int width, int height, const std::vector<PassRect>& rects, int level = 0, int levels = 1,
                          bool spoil = false) {
        Texture2D payload = integers("payload", width, height, levels),
                  place = integers("place", width, height, levels);
        ShaderLibrary library = shaders();
        TexelPass pass = test::value(TexelPass::create(device(), library, "write payload", "gl/write_payload.frag"));
        StageStats stats;
        const Texture2D* targets[] = {&payload, &place};
        if (spoil) spoil_everything();
        pass.begin(targets, level, stats);
        pass.draw(rects, stats);

        const int w = payload.width(level), h = payload.height(level);
        std::vector<std::int32_t> expected_payload(static_cast<std::size_t>(w * h) * 4, kSentinel);
        std::vector<std::int32_t> expected_place = expected_payload;
        std::uint64_t texels = 0;
        for (const PassRect& r : rects)
            for (int z = std::max(0, r.min_z); z < std::min(h, r.max_z); ++z)
                for (int x = std::max(0, r.min_x); x < std::min(w, r.max_x); ++x) {
                    const auto at = static_cast<std::size_t>(z * w + x) * 4;
                    std::copy(r.payload.begin(), r.payload.end(), expected_payload.begin() + static_cast<long>(at));
                    const std::array<std::int32_t, 4> where{x, z, r.min_x, r.min_z};
                    std::copy(where.begin(), where.end(), expected_place.begin() + static_cast<long>(at));
                    ++texels;
                }
        EXPECT_EQ(read(payload, level), expected_payload);
        EXPECT_EQ(read(place, level), expected_place);
        for (int other = 0; other < levels; ++other) {
            if (other == level) continue;
            for (std::int32_t v : read(payload, other)) ASSERT_EQ(v, kSentinel) << "level " << other << " was touched";
        }
        EXPECT_EQ(stats.passes, 1u);
        EXPECT_EQ(stats.draws, 1u);
        EXPECT_EQ(stats.primitives, 2 * rects.size());
        EXPECT_EQ(stats.texels, texels);
        EXPECT_EQ(stats.bytes, texels * 32);
    }
    void spoil_everything() {
        const Api& gl = device().gl();
        for (GLenum what :
             {GL_BLEND, GL_DITHER, GL_FRAMEBUFFER_SRGB, GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_CULL_FACE,
              GL_RASTERIZER_DISCARD, GL_SAMPLE_COVERAGE, GL_SAMPLE_MASK, GL_COLOR_LOGIC_OP, GL_SAMPLE_ALPHA_TO_COVERAGE,
              GL_SAMPLE_ALPHA_TO_ONE, GL_POLYGON_OFFSET_FILL, GL_CLIP_DISTANCE0 + 1})
            gl.Enable(what);
        gl.LogicOp(GL_INVERT);
        gl.BlendFunc(GL_ZERO, GL_DST_COLOR);
        gl.Scissor(0, 0, 1, 1);
        gl.CullFace(GL_FRONT_AND_BACK);
        gl.PolygonMode(GL_FRONT_AND_BACK, GL_POINT);
        gl.ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
        gl.ColorMaski(1, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        gl.Viewport(3, 4, 5, 6);
        gl.DepthFunc(GL_NEVER);
        gl.StencilFunc(GL_NEVER, 0, 0);
        gl.ProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
        if (device().capabilities().clip_control) gl.ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
        if (device().capabilities().viewport_array) gl.ViewportIndexedf(0, 1, 1, 2, 2);
    }
};

TEST_F(TexelPassTest, random_rectangles_cover_exactly_their_texels) {
    std::mt19937 random(1);
    for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {64, 64}, {131, 257}}) {
        std::vector<PassRect> rects;
        for (int i = 0; i < 40; ++i) {
            const auto pick = [&](int most) {
                return static_cast<int>(random() % static_cast<unsigned>(most + 8)) - 4;
            };
            const int x0 = pick(width), x1 = pick(width), z0 = pick(height), z1 = pick(height);
            rects.push_back({std::min(x0, x1),
                             std::min(z0, z1),
                             std::max(x0, x1),
                             std::max(z0, z1),
                             {i, -i, static_cast<std::int32_t>(random()), 0x7fffffff}});
        }
        draw_and_compare(width, height, rects);
    }
}

TEST_F(TexelPassTest, corners_are_exact_in_the_largest_texture) {
    const int most = device().capabilities().max_texture_size;
    // Long and thin, so that it takes little memory: every edge near the far end, where float positions are coarsest.
    std::vector<PassRect> rects;
    for (int i = 0; i < 24; ++i) rects.push_back({most - 3 * i - 2, 0, most - 3 * i, 1, {i, 0, 0, 0}});
    rects.push_back({1, 1, most - 1, 2, {99, 0, 0, 0}});
    draw_and_compare(most, 2, rects);
}

TEST_F(TexelPassTest, writes_one_level_and_leaves_the_others) {
    draw_and_compare(32, 16, {{1, 2, 5, 6, {1, 2, 3, 4}}, {0, 0, 16, 1, {5, 6, 7, 8}}}, 1, 3);
}

TEST_F(TexelPassTest, does_not_depend_on_what_the_host_left) {
    StateGuard guard(device());
    draw_and_compare(16, 16, {{1, 2, 15, 9, {1, 2, 3, 4}}, {4, 4, 6, 16, {5, 6, 7, 8}}}, 0, 1, true);
    device().gl().StencilFunc(GL_ALWAYS, 0, ~0u);  // not the library's, hence not the guard's
}

TEST_F(TexelPassTest, an_open_pass_has_every_switch_off) {
    // What this driver would not show in the texels: it does not dither, and our framebuffers have neither stencil nor
    // samples. Others do.
    StateGuard guard(device());
    Texture2D target = integers("target", 4, 4);
    ShaderLibrary library = shaders();
    TexelPass pass = test::value(TexelPass::create(device(), library, "switches", "gl/write_payload.frag"));
    StageStats stats;
    const Texture2D* targets[] = {&target};
    spoil_everything();
    pass.begin(targets, 0, stats);
    const Api& gl = device().gl();
    for (GLenum what : {GL_BLEND, GL_DITHER, GL_FRAMEBUFFER_SRGB, GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_STENCIL_TEST,
                        GL_CULL_FACE, GL_RASTERIZER_DISCARD, GL_SAMPLE_COVERAGE, GL_SAMPLE_MASK, GL_COLOR_LOGIC_OP,
                        GL_SAMPLE_ALPHA_TO_COVERAGE, GL_SAMPLE_ALPHA_TO_ONE, GL_POLYGON_OFFSET_FILL})
        EXPECT_EQ(gl.IsEnabled(what), GL_FALSE) << what;
    for (GLenum i = 0; i < 8; ++i) EXPECT_EQ(gl.IsEnabled(GL_CLIP_DISTANCE0 + i), GL_FALSE) << i;
    for (GLuint i = 0; i < 8; ++i) EXPECT_EQ(gl.IsEnabledi(GL_BLEND, i), GL_FALSE) << i;
    gl.StencilFunc(GL_ALWAYS, 0, ~0u);
}

TEST_F(TexelPassTest, nothing_to_draw_is_nothing_done) {
    Texture2D target = integers("target", 4, 4);
    ShaderLibrary library = shaders();
    TexelPass pass = test::value(TexelPass::create(device(), library, "empty", "gl/write_payload.frag"));
    StageStats stats;
    const Texture2D* targets[] = {&target};
    bool called = false;
    pass.run(targets, 0, {}, stats, [&](Program&) { called = true; });
    EXPECT_FALSE(called);
    EXPECT_EQ(stats, StageStats{});
}

TEST_F(TexelPassTest, all_16_bit_codes_survive_a_copy) {
    Texture2D source = test::value(Texture2D::create(device(), "codes", {Format::R16, 256, 256}));
    Texture2D target = test::value(Texture2D::create(device(), "copy", {Format::R16, 256, 256}));
    std::vector<std::uint16_t> codes(65536), copied(65536);
    for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint16_t>(i);
    source.upload(0, source.bounds(), codes.data());
    ShaderLibrary library = shaders();
    TexelPass pass = test::value(TexelPass::create(device(), library, "copy", "gl/blit.frag"));
    pass.program().sampler("u_source", 3);
    StageStats stats;
    const Texture2D* targets[] = {&target};
    const PassRect all[] = {{0, 0, 256, 256, {}}};
    // Twice, with hostile state between: a pass must set up all of its state each time.
    for (int round = 0; round < 2; ++round) {
        std::fill(copied.begin(), copied.end(), std::uint16_t{0});
        target.upload(0, target.bounds(), copied.data());
        StateGuard guard(device());
        if (round == 1) spoil_everything();
        pass.run(targets, 0, all, stats, [&](Program&) { source.bind(3); });
        target.read(0, copied.data());
        EXPECT_EQ(copied, codes) << "round " << round;
    }
    EXPECT_EQ(stats.passes, 2u);
    device().gl().StencilFunc(GL_ALWAYS, 0, ~0u);
}

}  // namespace
}  // namespace tilth::gl
