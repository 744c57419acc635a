// Meshes through the vertex and geometry shaders of backend "geometry", captured by transform feedback; and what they
// ought to give, from integers and doubles alone.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "support/gl_context.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/height_field.h"
#include "tilth/pool/height_planes.h"
#include "tilth/render/backends/backend_plan.h"
#include "tilth/render/backends/refinement_chain.h"

namespace tilth::test {

/// A vertex as transform feedback gives it, relative to the eye.
struct CapturedVertex {
    std::array<float, 3> position_m{};
    std::array<float, 4> clip{};
    /// Bit for bit.
    friend bool operator==(const CapturedVertex& a, const CapturedVertex& b) {
        return std::memcmp(&a, &b, sizeof(CapturedVertex)) == 0;
    }
};
static_assert(sizeof(CapturedVertex) == 7 * sizeof(float));

/// Ground, detail and eye of one drawing.
struct RefinementSetting {
    std::int32_t texels_per_post = 3;
    std::vector<std::int32_t> chain{1, 3};
    double edge_px = 0, px_per_radian = 779;
    double fade_from_m = 1000, fade_to_m = 2000;  ///< of what the mesh shows
    float spacing_m = 0.3f;
    std::array<float, 2> fraction_m{0.1f, 0.2f};
    Texel base_post{40, 40}, base_texel{16, 16};
    float eye_above_m = 3;  ///< the codec's middle
    std::int32_t window_size = 1024;
};

/// Posts apart that the mesh's vertices are is 2^level; the triangles are `corners`, three vertices of the 33 x 33
/// each, drawn for every block, whose origins are posts / 2^level.
struct RefinementMesh {
    std::int32_t level = 0;
    std::vector<std::array<std::uint16_t, 3>> corners;
    std::vector<Texel> blocks;  ///< origins
    std::int32_t quads = 32;    ///< a side of every block

    [[nodiscard]] Texel post(std::size_t block, std::uint16_t vertex) const {
        const std::int32_t x = std::min(vertex % 33, quads), z = std::min(vertex / 33, quads);
        return {(blocks[block].x + x) << level, (blocks[block].z + z) << level};
    }
};

/// The mesh that the renderer draws.
inline std::vector<std::array<std::uint16_t, 3>> block_triangles(std::int32_t quads = 32) {
    std::vector<std::array<std::uint16_t, 3>> triangles;
    const auto at = [](std::int32_t x, std::int32_t z) { return static_cast<std::uint16_t>(z * 33 + x); };
    for (std::int32_t z = 0; z < quads; ++z)
        for (std::int32_t x = 0; x < quads; ++x) {
            triangles.push_back({at(x, z), at(x, z + 1), at(x + 1, z + 1)});
            triangles.push_back({at(x, z), at(x + 1, z + 1), at(x + 1, z)});
        }
    return triangles;
}

/// The same cells, each with either diagonal, either winding and any corner first.
inline std::vector<std::array<std::uint16_t, 3>> shuffled_triangles(std::mt19937_64& random) {
    auto triangles = block_triangles();
    for (std::size_t i = 0; i < triangles.size(); i += 2) {
        if (random() % 2 != 0) {
            const std::uint16_t low = triangles[i][0], far = triangles[i][1], high = triangles[i][2],
                                right = triangles[i + 1][2];
            triangles[i] = {low, far, right};
            triangles[i + 1] = {right, far, high};
        }
        for (std::size_t t = i; t < i + 2; ++t) {
            std::rotate(triangles[t].begin(), triangles[t].begin() + static_cast<long>(random() % 3),
                        triangles[t].end());
            if (random() % 2 != 0) std::swap(triangles[t][0], triangles[t][1]);
        }
    }
    return triangles;
}

/// Textures of a map and of the window of its detail.
class RefinementScene {
public:
    static constexpr std::int32_t kPosts = 161;

    explicit RefinementScene(std::int32_t window_size = 1024)
        : guard_(test::device()),
          shaders_(test::shaders()),
          codec_(HeightCodec::for_range(-20, 20)),
          field_(kPosts, kPosts),
          planes_(value(HeightPlanes::create(test::device(), kPosts, kPosts, HeightPrecision::bits32))),
          detail_m(static_cast<std::size_t>(window_size) * static_cast<std::size_t>(window_size)),
          size_(window_size),
          heights_(value(gl::Texture2D::create(
              test::device(), "heights",
              {.format = gl::Format::R32F, .width = size_, .height = size_, .wrap = gl::Wrap::Repeat}))),
          pyramid_(value(gl::Texture2D::create(test::device(), "pyramid",
                                               {.format = gl::Format::Rg32F,
                                                .width = size_ / 2,
                                                .height = size_ / 2,
                                                .levels = 6,
                                                .filter = gl::Filter::NearestMipNearest,
                                                .wrap = gl::Wrap::Repeat}))),
          array_(value(gl::VertexArray::create(test::device(), "blocks"))) {}

    void set_ground(const std::function<double(Texel)>& height_m) {
        for (std::int32_t z = 0; z < kPosts; ++z)
            for (std::int32_t x = 0; x < kPosts; ++x)
                field_.set_code({x, z}, codec_.code(height_m({x, z}), HeightPrecision::bits32));
        gl::TransferStats transfer;
        planes_.upload(field_, field_.rect(), transfer);
    }
    /// Metres at a texel of the window; presence follows from `set_presence` alone.
    void set_detail(const std::function<float(Texel)>& height_m) {
        for (std::int32_t z = 0; z < size_; ++z)
            for (std::int32_t x = 0; x < size_; ++x) detail_m[index({x, z}, size_)] = height_m({x, z});
        heights_.upload(0, heights_.bounds(), detail_m.data());
    }
    /// Whether nodes of 2^(mark_level + 1) texels hold detail.
    void set_presence(std::int32_t mark_level, const std::function<bool(Texel)>& present) {
        mark_level_ = mark_level;
        const std::int32_t nodes = size_ >> (mark_level + 1);
        present_.assign(static_cast<std::size_t>(nodes) * static_cast<std::size_t>(nodes), 0);
        std::vector<float> range(present_.size() * 2);
        for (std::int32_t z = 0; z < nodes; ++z)
            for (std::int32_t x = 0; x < nodes; ++x) {
                const std::size_t at = index({x, z}, nodes);
                present_[at] = present({x, z});
                range[2 * at + (at % 2)] = present_[at] == 0 ? 0.0f : (at % 2 == 0 ? 0.5f : -0.5f);
            }
        pyramid_.upload(mark_level, pyramid_.bounds(mark_level), range.data());
    }

    /// All detail and marks: only what follows from numbers.
    [[nodiscard]] double base_m(Texel post, const RefinementSetting& s) const {
        return codec_.height_m(field_.code(post)) - codec_.middle_m - double{s.eye_above_m};
    }
    [[nodiscard]] double distance_m(Texel post, const RefinementSetting& s) const {
        const double x = (post.x - s.base_post.x) * double{s.spacing_m} - double{s.fraction_m[0]};
        const double z = (post.z - s.base_post.z) * double{s.spacing_m} - double{s.fraction_m[1]};
        return std::hypot(x, base_m(post, s), z);
    }
    [[nodiscard]] double share(double distance_m, const RefinementSetting& s) const {
        const double t = std::clamp((s.fade_to_m - distance_m) / (s.fade_to_m - s.fade_from_m), 0.0, 1.0);
        return t * t * (3 - 2 * t);
    }
    /// At n / f posts from the base post; f divides the texels a post.
    [[nodiscard]] double detail_at_m(std::int32_t nx, std::int32_t nz, std::int32_t f,
                                     const RefinementSetting& s) const {
        const auto texel = [&](std::int32_t n, std::int32_t base) {
            return (n * (s.texels_per_post / f) + base) & (size_ - 1);
        };
        return detail_m[index({texel(nx, s.base_texel.x), texel(nz, s.base_texel.z)}, size_)];
    }
    [[nodiscard]] bool marked(Texel post, const RefinementSetting& s) const {
        if (share(distance_m(post, s), s) <= 0) return false;
        const std::int32_t node = 2 << mark_level_, nodes = size_ / node;
        const auto node_of = [&](std::int32_t texel) { return ((texel % size_ + size_) % size_) / node; };
        const std::int32_t tx = (post.x - s.base_post.x) * s.texels_per_post + s.base_texel.x;
        const std::int32_t tz = (post.z - s.base_post.z) * s.texels_per_post + s.base_texel.z;
        for (std::int32_t z = -s.texels_per_post; z < s.texels_per_post; ++z)
            for (std::int32_t x = -s.texels_per_post; x < s.texels_per_post; ++x)
                if (present_[index({node_of(tx + x), node_of(tz + z)}, nodes)] != 0) return true;
        return false;
    }
    /// Parts that a corner allows its edges.
    [[nodiscard]] std::int32_t factor(Texel post, const RefinementSetting& s) const {
        if (!marked(post, s)) return 1;
        const double post_px = double{s.spacing_m} * s.px_per_radian / distance_m(post, s);
        for (const std::int32_t factor : s.chain)
            if (factor * s.edge_px > 0 && post_px / factor <= s.edge_px) return factor;
        return s.chain.back();
    }

    enum class Stages { Plain, Input, Refined };  ///< no relief; relief, before refinement; all
    /// The triangles that come out, and with `primitives` how many GL counted.
    std::vector<std::array<CapturedVertex, 3>> capture(Stages stages, const RefinementSetting& s,
                                                       const RefinementMesh& mesh, std::size_t most_triangles,
                                                       std::uint64_t* primitives = nullptr);

    /// Metres at (i - side / 2, j - side / 2) / parts posts from the base post, row by row, as shaders see them.
    std::vector<float> relief_points(const RefinementSetting& s, std::int32_t side, std::int32_t parts);

    [[nodiscard]] std::int32_t size() const { return size_; }

private:
    static std::size_t index(Texel t, std::int32_t width) {
        return static_cast<std::size_t>(t.z) * static_cast<std::size_t>(width) + static_cast<std::size_t>(t.x);
    }
    gl::Program& program(Stages stages, std::int32_t most_factor);
    void set_relief(gl::Program& p, const RefinementSetting& s) const;

    gl::StateGuard guard_;
    gl::ShaderLibrary shaders_;
    HeightCodec codec_;
    HeightField field_;
    HeightPlanes planes_;

public:
    std::vector<float> detail_m;  ///< of the window

private:
    std::int32_t size_;
    gl::Texture2D heights_, pyramid_;
    gl::VertexArray array_;
    std::int32_t mark_level_ = 0;
    std::vector<std::uint8_t> present_;
    std::vector<std::pair<std::int32_t, gl::Program>> programs_;  ///< by -2, -1 or the most factor
};

inline gl::Program& RefinementScene::program(Stages stages, std::int32_t most_factor) {
    const std::int32_t key = stages == Stages::Plain ? -2 : stages == Stages::Input ? -1 : most_factor;
    for (auto& [known, made] : programs_)
        if (known == key) return made;
    gl::Features features{{"ALL_OWN", "1"}};
    gl::ProgramOptions options;
    if (stages == Stages::Input) features.emplace_back("RELIEF_MESH", "1");
    options.feedback = {stages == Stages::Input ? "r_position_m" : "v_position_m", "gl_Position"};
    if (stages == Stages::Refined) {
        // What the plan says of a map that has as many texels a post.
        const DetailSettings settings{.backend = DetailBackend::Geometry};
        const BackendPlan plan = plan_geometry({.settings = settings, .reach_m = 100, .texels_per_post = most_factor});
        const ReliefRecipe& recipe = plan.recipes.at(0);
        features.insert(features.end(), recipe.features.begin(), recipe.features.end());
        options.geometry = recipe.stages.geometry;
    }
    programs_.emplace_back(key,
                           value(shaders_.program("refinement test", "render/terrain.vert", "", features, options)));
    gl::Program& made = programs_.back().second;
    made.sampler("u_high_plane", 0);
    made.sampler("u_low_plane", 1);
    made.sampler("u_relief_heights", 2);
    made.sampler("u_relief_pyramid", 3);
    return made;
}

inline void RefinementScene::set_relief(gl::Program& p, const RefinementSetting& s) const {
    p.set(p.uniform("u_relief_size"), size_);
    p.set(p.uniform("u_relief_base_texel"), s.base_texel.x, s.base_texel.z);
    p.set(p.uniform("u_relief_per_post"), s.texels_per_post);
    p.set(p.uniform("u_relief_texels_per_m"), static_cast<float>(s.texels_per_post) / s.spacing_m);
    const auto from = static_cast<float>(s.fade_from_m), to = static_cast<float>(s.fade_to_m);
    p.set(p.uniform("u_relief_fade_m"), from, to, from, to);
    p.set(p.uniform("u_relief_mark_level"), mark_level_);
}

inline std::vector<float> RefinementScene::relief_points(const RefinementSetting& s, std::int32_t side,
                                                         std::int32_t parts) {
    const gl::Api& gl = test::device().gl();
    gl::Program p = value(shaders_.program("relief points", "../tests/render/shaders/relief_points.vert", "", {},
                                           {.feedback = {"height_m"}}));
    p.sampler("u_relief_heights", 2);
    p.bind();
    heights_.bind(2);
    set_relief(p, s);
    p.set(p.uniform("u_side"), side);
    p.set(p.uniform("u_parts"), parts);
    std::vector<float> heights(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    const auto feedback = value(
        gl::Buffer::create(test::device(), "feedback", heights.size() * sizeof(float), gl::BufferUsage::ReadBack));
    const auto none = value(gl::VertexArray::create(test::device(), "no inputs"));
    none.bind();
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, feedback.id());
    gl.Enable(GL_RASTERIZER_DISCARD);
    gl.BeginTransformFeedback(GL_POINTS);
    gl.DrawArrays(GL_POINTS, 0, side * side);
    gl.EndTransformFeedback();
    gl.Disable(GL_RASTERIZER_DISCARD);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
    feedback.read(0, std::as_writable_bytes(std::span(heights)));
    return heights;
}

inline std::vector<std::array<CapturedVertex, 3>> RefinementScene::capture(Stages stages, const RefinementSetting& s,
                                                                           const RefinementMesh& mesh,
                                                                           std::size_t most_triangles,
                                                                           std::uint64_t* primitives) {
    const gl::Api& gl = test::device().gl();
    gl::Program& p = program(stages, s.chain.back());
    p.bind();
    planes_.high().bind(0);
    planes_.low().bind(1);
    heights_.bind(2);
    pyramid_.bind(3);
    p.set(p.uniform("u_last_post"), kPosts - 1, kPosts - 1);
    p.set(p.uniform("u_stored_posts"), kPosts, kPosts);
    p.set(p.uniform("u_base_post"), s.base_post.x, s.base_post.z);
    p.set(p.uniform("u_fraction_m"), s.fraction_m[0], s.fraction_m[1]);
    p.set(p.uniform("u_spacing_m"), s.spacing_m);
    p.set(p.uniform("u_eye_code"), unsigned{kMidCode});
    p.set(p.uniform("u_eye_above_code_m"), s.eye_above_m);
    p.set(p.uniform("u_code_quantum_m"), static_cast<float>(codec_.code_quantum_m()));
    // A camera that looks askew, so that every component of a clip position depends on all of the position.
    const std::array<float, 16> clip{1.21f, -0.32f, 0.18f, 0.17f, 0.23f,  1.43f, -0.54f, -0.53f,
                                     0.37f, 0.61f,  0.84f, 0.83f, -0.01f, 0.02f, -0.2f,  0.03f};
    p.set_mat4(p.uniform("u_clip_from_relative"), clip.data());
    set_relief(p, s);
    const auto chain = refinement_uniform(s.chain);
    p.set(p.uniform("u_refine_chain"), chain[0], chain[1], chain[2], chain[3]);
    p.set(p.uniform("u_refine_px_per_radian"), static_cast<float>(s.px_per_radian));
    p.set(p.uniform("u_refine_edge_px"), static_cast<float>(s.edge_px));

    std::vector<std::array<std::int32_t, 6>> blocks;
    for (const Texel& origin : mesh.blocks)
        blocks.push_back({origin.x, origin.z, mesh.quads, mesh.quads, mesh.level, mesh.level});
    const auto streamed = value(gl::Buffer::create(test::device(), "blocks", std::as_bytes(std::span(blocks)).size(),
                                                   gl::BufferUsage::Static, blocks.data()));
    const auto indices =
        value(gl::Buffer::create(test::device(), "indices", std::as_bytes(std::span(mesh.corners)).size(),
                                 gl::BufferUsage::Static, mesh.corners.data()));
    array_.bind();
    for (int i = 0; i < 3; ++i)
        array_.int_attribute(i, streamed, 2, gl::AttributeType::Int, 24, static_cast<std::size_t>(i) * 8, 1);
    array_.index_buffer(indices);

    std::vector<std::array<CapturedVertex, 3>> triangles(most_triangles);
    const auto feedback = value(gl::Buffer::create(test::device(), "feedback", most_triangles * sizeof(triangles[0]),
                                                   gl::BufferUsage::ReadBack));
    auto generated = value(gl::Query::create(test::device(), "generated", gl::QueryKind::PrimitivesGenerated));
    GLuint written_query = 0;
    gl.GenQueries(1, &written_query);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, feedback.id());
    gl.Enable(GL_RASTERIZER_DISCARD);
    generated.begin();
    gl.BeginQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, written_query);
    gl.BeginTransformFeedback(GL_TRIANGLES);
    gl.DrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(mesh.corners.size() * 3), GL_UNSIGNED_SHORT, nullptr,
                             static_cast<GLsizei>(blocks.size()));
    gl.EndTransformFeedback();
    gl.EndQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    generated.end();
    gl.Disable(GL_RASTERIZER_DISCARD);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
    GLuint written = 0;
    gl.GetQueryObjectuiv(written_query, GL_QUERY_RESULT, &written);
    gl.DeleteQueries(1, &written_query);
    if (primitives != nullptr) *primitives = generated.result();
    EXPECT_EQ(written, generated.result()) << "the feedback buffer was too small";
    triangles.resize(std::min<std::size_t>(written, most_triangles));
    if (!triangles.empty()) feedback.read(0, std::as_writable_bytes(std::span(triangles)));
    return triangles;
}

}  // namespace tilth::test
