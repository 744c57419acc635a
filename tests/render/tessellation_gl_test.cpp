// The tessellation stages, of relief and of curved triangles: no cracks, nothing where nothing is to be split, and
// convergence to the surface that they stand for.
#include <cstddef>
#include <cstdio>
#include <optional>

#include "render/support/patch_mesh.h"
#include "tilth/pool/height_planes.h"
#include "tilth/render/clipmap_layout.h"
#include "tilth/world/height_codec.h"

namespace tilth::test {
namespace {

constexpr int kWindow = 1024;  // texels of the relief window a side

class TessellationGlTest : public GlTest {
protected:
    void SetUp() override {
        GlTest::SetUp();
        if (HasFatalFailure() || IsSkipped()) return;
        if (!device().capabilities().tessellation) GTEST_SKIP() << "no hardware tessellation";
        guard_.emplace(device());
        target_.emplace(16, 16);
        target_->bind();  // drawing wants a complete framebuffer even where nothing is rasterised
    }
    void TearDown() override {
        target_.reset();
        guard_.reset();
        GlTest::TearDown();
    }
    std::optional<gl::StateGuard> guard_;
    std::optional<Target> target_;
};

struct ReliefKnobs {
    int per_post = 3, most = 16;
    float edge_px = 0, px_per_radian = 700;
    float spacing_m = 1;
};

gl::Texture2D window_of(const std::vector<float>& detail_m) {
    auto texture = value(gl::Texture2D::create(
        test::device(), "heights",
        {.format = gl::Format::R32F, .width = kWindow, .height = kWindow, .wrap = gl::Wrap::Repeat}));
    texture.upload(0, texture.bounds(), detail_m.data());
    return texture;
}

std::vector<PatchTriangle> relief(const PatchGrid& grid, const gl::Texture2D& window, const ReliefKnobs& knobs,
                                  std::size_t most_triangles = 400000) {
    gl::ShaderLibrary library = shaders();
    gl::Program p = value(library.program("relief patches", "../tests/render/shaders/patch_corners.vert", "", {},
                                          {.tess_control = "render/tessellation/relief.tesc",
                                           .tess_evaluation = "render/tessellation/relief.tese",
                                           .feedback = {"v_position_m", "gl_Position"}}));
    p.sampler("u_relief_heights", 0);
    p.bind();
    window.bind(0);
    p.set(p.uniform("u_relief_size"), kWindow);
    p.set(p.uniform("u_relief_base_texel"), 1000, 20);  // the grid goes across the window's seam
    p.set(p.uniform("u_relief_per_post"), knobs.per_post);
    p.set(p.uniform("u_relief_texels_per_m"), static_cast<float>(knobs.per_post) / knobs.spacing_m);
    p.set(p.uniform("u_relief_fade_m"), 1e4f, 2e4f, 1e4f, 2e4f);
    p.set(p.uniform("u_refine_factor_most"), knobs.most);
    p.set(p.uniform("u_refine_edge_px"), knobs.edge_px);
    p.set(p.uniform("u_refine_px_per_radian"), knobs.px_per_radian);
    p.set_mat4(p.uniform("u_clip_from_relative"), kAskewClip.data());
    return capture_patches(grid, most_triangles);
}

struct PhongKnobs {
    int most = 4;
    float edge_px = 0, px_per_radian = 700, shape = 0.75f;
};

std::vector<PatchTriangle> phong(const PatchGrid& grid, const PhongKnobs& knobs) {
    gl::ShaderLibrary library = shaders();
    gl::Program p =
        value(library.program("curved patches", "../tests/render/shaders/patch_corners.vert", "", {{"PHONG", "1"}},
                              {.tess_control = "render/phong/phong.tesc",
                               .tess_evaluation = "render/phong/phong.tese",
                               .feedback = {"v_position_m", "gl_Position"}}));
    p.bind();
    p.set(p.uniform("u_phong_factor_most"), knobs.most);
    p.set(p.uniform("u_phong_edge_px"), knobs.edge_px);
    p.set(p.uniform("u_phong_px_per_radian"), knobs.px_per_radian);
    p.set(p.uniform("u_phong_shape"), knobs.shape);
    p.set_mat4(p.uniform("u_clip_from_relative"), kAskewClip.data());
    return capture_patches(grid, 400000);
}

float uniform_in(std::mt19937_64& random, double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
}

/// Corners are what no stage could compute: they must be passed on.
void scatter(PatchGrid& grid, std::mt19937_64& random, float spacing_m) {
    const float fraction_x = uniform_in(random, 0, spacing_m), fraction_z = uniform_in(random, 0, spacing_m);
    grid.each([&](PatchCorner& c, int x, int z) {
        const int i = x - grid.quads / 2, j = z - grid.quads / 2;
        c.base_m = uniform_in(random, -3, -1);
        c.position_m = {static_cast<float>(i) * spacing_m - fraction_x, c.base_m + uniform_in(random, -0.5, 0.5),
                        static_cast<float>(j) * spacing_m - fraction_z};
        for (float& v : c.clip) v = uniform_in(random, -1, 1);
        c.integers = {i, j, 0, 0};
        c.slope = {uniform_in(random, -1, 1), uniform_in(random, -1, 1)};
    });
}

std::vector<float> random_detail(std::mt19937_64& random) {
    std::vector<float> detail(static_cast<std::size_t>(kWindow) * kWindow);
    for (float& v : detail) v = uniform_in(random, -0.1, 0.1);
    return detail;
}

/// The triangles that went in, to the bit, in their order.
void expect_unchanged(const PatchGrid& grid, const std::vector<PatchTriangle>& out) {
    ASSERT_EQ(out.size(), grid.triangles.size());
    for (std::size_t t = 0; t < out.size(); ++t) {
        // GL may begin with another corner, but keeps the winding.
        const auto corner = [&](std::size_t i) {
            const PatchCorner& c = grid.corners[grid.triangles[t][i % 3]];
            return PatchVertex{c.position_m, c.clip};
        };
        bool same = false;
        for (std::size_t first = 0; first < 3; ++first)
            same = same ||
                   (out[t][0] == corner(first) && out[t][1] == corner(first + 1) && out[t][2] == corner(first + 2));
        EXPECT_TRUE(same) << "triangle " << t;
    }
}

TEST_F(TessellationGlTest, TrianglesOfReliefShareEveryEdgeToTheBit) {
    std::mt19937_64 random(71);
    const gl::Texture2D window = window_of(random_detail(random));
    std::array<int, 16> marks_seen{};
    for (const int per_post : {2, 3, 5, 8, 16})
        for (const float edge_px : {0.0f, 8.0f, 40.0f}) {
            const ReliefKnobs knobs{.per_post = per_post, .edge_px = edge_px, .spacing_m = 0.3f};
            PatchGrid grid(10);
            scatter(grid, random, knobs.spacing_m);
            grid.each([&](PatchCorner& c, int x, int z) {
                c.integers[2] = !grid.on_border(x, z) && random() % 4 != 0 ? 1 : 0;
            });
            for (int z = 0; z < grid.quads; ++z)
                for (int x = 0; x < grid.quads; ++x) {
                    const auto bit = [&](int i, int j) { return grid.corners[grid.at(x + i, z + j)].integers[2]; };
                    ++marks_seen[static_cast<std::size_t>(bit(0, 0) + 2 * bit(1, 0) + 4 * bit(0, 1) + 8 * bit(1, 1))];
                }
            grid.shuffle(random);
            const auto out = relief(grid, window, knobs);
            const Seams seams = seams_of(out);
            // Corners of the border are not marked: its edges are whole, and nothing else has one side only.
            EXPECT_EQ(seams.single, 4 * grid.quads) << per_post << " texels a post, edges of " << edge_px << " px";
            EXPECT_EQ(seams.more, 0);
            EXPECT_GT(out.size(), grid.triangles.size()) << "nothing was split";
        }
    for (std::size_t i = 0; i < 16; ++i) EXPECT_GT(marks_seen[i], 0) << "marks " << i << " of a cell were not tried";
}

TEST_F(TessellationGlTest, TrianglesWithoutDetailComeOutAsTheyWentIn) {
    std::mt19937_64 random(72);
    const gl::Texture2D window = window_of(random_detail(random));
    PatchGrid grid(16);
    scatter(grid, random, 0.3f);
    // One mark alone splits nothing either.
    grid.each([](PatchCorner& c, int x, int z) { c.integers[2] = x % 3 == 0 && (x + z) % 3 == 0 && z % 3 == 0; });
    grid.shuffle(random);
    const auto out = relief(grid, window, {.per_post = 8});
    expect_unchanged(grid, out);
}

/// rms and largest difference from the surface, millimetres.
struct Error {
    double rms_mm = 0, most_mm = 0;
};

TEST_F(TessellationGlTest, FinerPartsConvergeToTheReliefAtTheRateOfItsSmoothness) {
    // Stamps of SCIENCE 1.2: 0.48 m between posts, 30 mm between texels.
    constexpr int kPerPost = 16, kQuads = 20;
    enum Shape { kSmooth, kKinked, kStepped };
    const char* const names[] = {"smooth", "kinked", "stepped"};
    for (const Shape shape : {kSmooth, kKinked, kStepped}) {
        std::mt19937_64 random(5);
        std::vector<float> detail(static_cast<std::size_t>(kWindow) * kWindow);
        const auto at = [&](int x, int z) -> float& {
            return detail[static_cast<std::size_t>((z & (kWindow - 1)) * kWindow + (x & (kWindow - 1)))];
        };
        for (int stamp = 0; stamp < 60; ++stamp) {
            const double cx = uniform_in(random, -140, 140), cz = uniform_in(random, -140, 140);
            const double r = uniform_in(random, 8, 24), depth = uniform_in(random, 0.02, 0.12);
            for (int z = -165; z <= 165; ++z)
                for (int x = -165; x <= 165; ++x) {
                    const double d2 = ((x - cx) * (x - cx) + (z - cz) * (z - cz)) / (r * r);
                    at(x + 1000, z + 20) -= static_cast<float>(depth * (shape == kSmooth   ? std::exp(-2 * d2)
                                                                        : shape == kKinked ? std::max(1 - d2, 0.0)
                                                                                           : (d2 < 1 ? 1.0 : 0.0)));
                }
        }
        const gl::Texture2D window = window_of(detail);
        PatchGrid grid(kQuads);
        grid.each([&](PatchCorner& c, int x, int z) {
            const int i = x - kQuads / 2, j = z - kQuads / 2;
            c.integers = {i, j, 1, 0};
            c.position_m = {static_cast<float>(i), at(i * kPerPost + 1000, j * kPerPost + 20), static_cast<float>(j)};
        });
        std::array<Error, 5> errors;
        std::printf("  %-8s rms / max mm:", names[shape]);
        for (int level = 0; level < 5; ++level) {
            Error& error = errors[static_cast<std::size_t>(level)];
            double sum = 0, count = 0;
            sample(relief(grid, window, {.per_post = kPerPost, .most = 1 << level}), 1.0 / kPerPost,
                   [&](double x, double z, double y) {
                       const int i = static_cast<int>(std::lround(x * kPerPost)),
                                 j = static_cast<int>(std::lround(z * kPerPost));
                       const double off_mm = 1000 * std::abs(y - double{at(i + 1000, j + 20)});
                       sum += off_mm * off_mm, ++count;
                       error.most_mm = std::max(error.most_mm, off_mm);
                   });
            ASSERT_GE(count, (kQuads * kPerPost + 1) * (kQuads * kPerPost + 1)) << "texels were missed";
            error.rms_mm = std::sqrt(sum / count);
            std::printf("  t=%d %.2f / %.1f", 1 << level, error.rms_mm, error.most_mm);
        }
        std::printf("\n");
        const auto ratio = [&](std::size_t level) { return errors[level].rms_mm / errors[level + 1].rms_mm; };
        // The ratio of one doubling approaches 2^2, 2^1.5 and 2^0.5.
        const double law = shape == kSmooth ? 4 : shape == kKinked ? std::sqrt(8.0) : std::sqrt(2.0);
        EXPECT_NEAR(std::sqrt(ratio(1) * ratio(2)), law, 0.15 * law) << names[shape];
        EXPECT_GT(ratio(0), 1.1) << names[shape];
        // Where every texel of an edge is a vertex too: points inside triangles lie beside the lattice of texels, so
        // that the surface is not reached, but comes as near as one more doubling brings it anywhere else.
        EXPECT_GT(ratio(3), 0.9 * law) << names[shape];
    }
}

TEST_F(TessellationGlTest, CurvedTrianglesShareEveryEdgeToTheBit) {
    std::mt19937_64 random(73);
    for (const float edge_px : {0.0f, 8.0f, 60.0f})
        for (int turn = 0; turn < 3; ++turn) {
            PatchGrid grid(12);
            scatter(grid, random, 0.7f);
            grid.each([&](PatchCorner& c, int x, int z) {
                c.weight = grid.on_border(x, z) || random() % 5 == 0 ? 0 : uniform_in(random, 0.1, 1);
            });
            grid.shuffle(random);
            const auto out = phong(grid, {.most = 7, .edge_px = edge_px});
            const Seams seams = seams_of(out);
            EXPECT_EQ(seams.single, 4 * grid.quads) << "edges of " << edge_px << " px";
            EXPECT_EQ(seams.more, 0);
            EXPECT_GT(out.size(), grid.triangles.size()) << "nothing was split";
        }
}

TEST_F(TessellationGlTest, TrianglesWithoutCurvatureComeOutAsTheyWentIn) {
    std::mt19937_64 random(74);
    PatchGrid grid(16);
    scatter(grid, random, 0.7f);
    grid.each([](PatchCorner& c, int x, int z) { c.weight = x % 3 == 0 && z % 3 == 0 ? 1 : 0; });
    grid.shuffle(random);
    expect_unchanged(grid, phong(grid, {.most = 7}));
}

TEST_F(TessellationGlTest, CurvedTrianglesOfAPlainStayOnIt) {
    PatchGrid grid(12);
    grid.each([&](PatchCorner& c, int x, int z) {
        c.position_m = {static_cast<float>(x - 6) * 0.7f, -1.7f, static_cast<float>(z - 6) * 0.7f};
        c.slope = {0, 0};
        c.weight = 1;
    });
    for (const int most : {5, 6, 11}) {
        const auto out = phong(grid, {.most = most});
        EXPECT_GT(out.size(), 20 * grid.triangles.size());
        for (const PatchTriangle& t : out)
            for (const PatchVertex& v : t) ASSERT_EQ(v.position_m[1], -1.7f) << most << " parts";
    }
    EXPECT_EQ(phong(grid, {.most = 5, .edge_px = 4}).size(), grid.triangles.size()) << "plains are not to be split";
}

TEST_F(TessellationGlTest, CurvingBringsASmoothHillCloser) {
    constexpr int kQuads = 24;
    const auto height = [](double x, double z) { return 3 * std::exp(-(x * x + z * z) / 32) - 5; };
    PatchGrid grid(kQuads);
    grid.each([&](PatchCorner& c, int x, int z) {
        const double px = x - kQuads / 2, pz = z - kQuads / 2, rise = height(px, pz) + 5;
        c.position_m = {static_cast<float>(px), static_cast<float>(height(px, pz)), static_cast<float>(pz)};
        c.slope = {static_cast<float>(-px / 16 * rise), static_cast<float>(-pz / 16 * rise)};
        c.weight = 1;
    });
    const auto error = [&](const PhongKnobs& knobs) {
        Error e;
        double sum = 0, count = 0;
        sample(phong(grid, knobs), 1.0 / 16, [&](double x, double z, double y) {
            const double off_mm = 1000 * std::abs(y - height(x, z));
            sum += off_mm * off_mm, ++count;
            e.most_mm = std::max(e.most_mm, off_mm);
        });
        e.rms_mm = std::sqrt(sum / count);
        return e;
    };
    const Error flat = error({.most = 1}), soft = error({.most = 8, .shape = 0.5f}), full = error({.most = 8});
    std::printf("  hill, rms / max mm: flat %.2f / %.1f, shape 0.5 %.2f / %.1f, shape 0.75 %.2f / %.1f\n", flat.rms_mm,
                flat.most_mm, soft.rms_mm, soft.most_mm, full.rms_mm, full.most_mm);
    EXPECT_LT(soft.rms_mm, 0.15 * flat.rms_mm);  // exact on parabolas
    EXPECT_LT(full.rms_mm, 0.7 * flat.rms_mm);   // half as much too high as chords are too low
}

TEST_F(TessellationGlTest, CurvatureHasNoWeightWhereLevelsMeet) {
    constexpr int kPosts = 257;
    const auto codec = HeightCodec::for_range(-20, 20);
    HeightField field(kPosts, kPosts);
    for (int z = 0; z < kPosts; ++z)
        for (int x = 0; x < kPosts; ++x)
            field.set_code({x, z}, codec.code(std::sin(x * 0.3) + std::cos(z * 0.2), HeightPrecision::bits32));
    HeightPlanes planes = value(HeightPlanes::create(device(), kPosts, kPosts, HeightPrecision::bits32));
    gl::TransferStats transfer;
    planes.upload(field, field.rect(), transfer);
    auto slopes = value(gl::Texture2D::create(device(), "slopes", {gl::Format::Rg8, kPosts, kPosts}));
    slopes.upload(0, slopes.bounds(), std::vector<std::uint8_t>(std::size_t{kPosts} * kPosts * 2, 150).data());
    gl::ShaderLibrary library = shaders();
    gl::Program p = value(
        library.program("weights", "render/terrain.vert", "", {{"PHONG", "1"}}, {.feedback = {"p_weight", "p_slope"}}));
    p.sampler("u_high_plane", 0), p.sampler("u_low_plane", 1), p.sampler("u_slopes", 2), p.sampler("u_node_weights", 3);
    p.bind();
    planes.high().bind(0), planes.low().bind(1), slopes.bind(2);
    const auto nodes = value(gl::TextureBuffer::create(device(), "nodes", gl::Format::R32F, 16));
    nodes.bind(3);
    const ClipmapSettings settings{.n = 31, .levels = 3};
    p.set(p.uniform("u_last_post"), kPosts - 1, kPosts - 1);
    p.set(p.uniform("u_stored_posts"), kPosts, kPosts);
    p.set(p.uniform("u_spacing_m"), 1.0f);
    p.set(p.uniform("u_code_quantum_m"), static_cast<float>(codec.code_quantum_m()));
    p.set(p.uniform("u_n"), settings.n);
    p.set(p.uniform("u_zone_units"), 3.0f);
    p.set(p.uniform("u_coarsest_level"), settings.levels - 1);
    auto array = value(gl::VertexArray::create(device(), "blocks"));
    const auto feedback =
        value(gl::Buffer::create(device(), "feedback", 33 * 33 * 3 * sizeof(float), gl::BufferUsage::ReadBack));
    const gl::Api& gl = device().gl();
    std::array<int, 3> whole{};
    int borders = 0;
    for (const double eye : {128.0, 128.9, 129.3, 130.99, 131.5}) {
        const PostPos viewer{eye, 128.4 + 0.3 * eye - 38};
        p.set(p.uniform("u_base_post"), static_cast<int>(viewer.x), static_cast<int>(viewer.z));
        p.set(p.uniform("u_fraction_m"), static_cast<float>(viewer.x - std::floor(viewer.x)),
              static_cast<float>(viewer.z - std::floor(viewer.z)));
        const ClipmapLayout layout = clipmap_layout(settings, viewer, kPosts - 1, kPosts - 1);
        for (const int first_level : {0, 1}) {
            p.set(p.uniform("u_phong_first_level"), first_level);
            for (const ClipmapBlock& b : layout.blocks) {
                const std::int32_t streamed[6] = {b.x, b.z, b.width, b.depth, b.level, b.level};
                const auto instance =
                    value(gl::Buffer::create(device(), "block", sizeof(streamed), gl::BufferUsage::Static, streamed));
                array.bind();
                for (int i = 0; i < 3; ++i)
                    array.int_attribute(i, instance, 2, gl::AttributeType::Int, 24, static_cast<std::size_t>(i) * 8, 1);
                gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, feedback.id());
                gl.Enable(GL_RASTERIZER_DISCARD);
                gl.BeginTransformFeedback(GL_POINTS);
                gl.DrawArraysInstanced(GL_POINTS, 0, 33 * 33, 1);
                gl.EndTransformFeedback();
                gl.Disable(GL_RASTERIZER_DISCARD);
                gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
                std::vector<std::array<float, 3>> got(33 * 33);
                feedback.read(0, std::as_writable_bytes(std::span(got)));
                const auto level = static_cast<std::size_t>(b.level);
                for (int z = 0; z <= b.depth; ++z)
                    for (int x = 0; x <= b.width; ++x) {
                        const auto& [weight, slope_x, slope_z] = got[static_cast<std::size_t>(z * 33 + x)];
                        const auto on = [&](const ClipmapBlock& w, int shift) {
                            const int px = b.x + x, pz = b.z + z, x0 = w.x >> shift, z0 = w.z >> shift;
                            const int x1 = (w.x + w.width) >> shift, z1 = (w.z + w.depth) >> shift;
                            return px >= x0 && px <= x1 && pz >= z0 && pz <= z1 &&
                                   (px == x0 || px == x1 || pz == z0 || pz == z1);
                        };
                        const bool outer = b.level < settings.levels - 1 && on(layout.windows[level], 0);
                        const bool hole = b.level > 0 && on(layout.windows[level - 1], 1);
                        borders += outer || hole;
                        if (outer || hole || b.level < first_level) {
                            ASSERT_EQ(weight, 0.0f) << "level " << b.level << ", vertex " << x << ", " << z;
                        }
                        ASSERT_GE(weight, 0.0f);
                        ASSERT_LE(weight, 1.0f);
                        whole[level] += weight == 1.0f;
                        ASSERT_NEAR(slope_x, 22.0 / 127 / (1 - std::sqrt(2.0) * 22 / 127), 1e-4);
                        ASSERT_EQ(slope_x, slope_z);
                    }
            }
        }
    }
    EXPECT_GT(borders, 500);
    for (const int count : {whole[0], whole[2]}) EXPECT_GT(count, 100) << "nothing is curved";
}

}  // namespace
}  // namespace tilth::test
