// What does the clipmap cost beyond its triangles? A frame of it against a plain indexed mesh of the very same
// triangles (vertex buffer, no height planes, no morph, compact vertices block by block) with the same fragment shader,
// in turn, by resolution. The ratio is to be at most 1.3. Eye 2 m above ridged ground of 1 025 x 1 025 posts, n = 255,
// 5 levels.
#include <array>
#include <cmath>
#include <numbers>

#include "render/support/clipmap_twin.h"
#include "support/bench_device.h"
#include "tilth/core/hash.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/render/terrain_renderer.h"
#include "tilth/source/ridged_source.h"

namespace tilth::bench {
namespace {

constexpr std::int32_t kPosts = 1025;

/// The ground of all rows: heights, slopes, bounds, renderer.
struct Scene {
    Scene()
        : source(make_ridged_source({.seed = 7, .size = kPosts, .relief_m = 200})),
          codec(HeightCodec::for_range(source->min_m(), source->max_m())),
          field(codes_of(*source, codec)),
          planes(value(HeightPlanes::create(device(), kPosts, kPosts, HeightPrecision::bits32))),
          slopes(value(SlopeMap::create(device(), kPosts, kPosts, SlopeFormat::rg8))),
          bounds(field),
          info{.grid = {.spacing_m = 1, .width = kPosts, .depth = kPosts}, .codec = codec},
          renderer(value(TerrainRenderer::create(device(), shaders(), settings, info))) {
        gl::TransferStats transfer;
        gl::StageStats stage;
        planes.upload(field, field.rect(), transfer);
        const TexelRect whole = field.rect();
        upload_slopes({&whole, 1}, field, {SlopeStencil::Central, codec.code_quantum_m(), 1.0}, slopes, stage, stage,
                      transfer);
    }
    static HeightField codes_of(const HeightSource& source, const HeightCodec& codec) {
        HeightField made(kPosts, kPosts);
        for (std::int32_t z = 0; z < kPosts; ++z)
            for (std::int32_t x = 0; x < kPosts; ++x)
                made.set_code({x, z}, codec.code(source.height_m({x, z}), HeightPrecision::bits32));
        return made;
    }
    ClipmapSettings settings{};
    std::unique_ptr<RasterSource> source;
    HeightCodec codec;
    HeightField field;
    HeightPlanes planes;
    SlopeMap slopes;
    HeightBounds bounds;
    MapInfo info;
    TerrainRenderer renderer;
};

Scene& scene() {
    static Scene* const made = new Scene;
    return *made;
}

/// The triangles of the renderer's last frame as a plain mesh.
class PlainMesh {
public:
    PlainMesh(Scene& scene, const Camera& camera)
        : program_(value(shaders().program("plain mesh", "render/plain_mesh.vert", "render/terrain.frag"))),
          array_(value(gl::VertexArray::create(device(), "plain mesh"))) {
        const test::ClipmapTwin twin(scene.settings, camera, scene.info.grid, scene.codec, scene.field, scene.bounds);
        std::vector<std::array<float, 5>> vertices;
        std::vector<std::uint32_t> indices;
        constexpr std::int32_t kVertices = kBlockQuads + 1;
        for (const DrawnBlock& drawn : scene.renderer.last_drawn().blocks) {
            const ClipmapBlock& b = drawn.block;
            const auto first = static_cast<std::uint32_t>(vertices.size());
            for (std::int32_t j = 0; j < kVertices; ++j)
                for (std::int32_t i = 0; i < kVertices; ++i) {
                    const std::int32_t x = std::min((b.x + std::min(i, b.width)) << b.level, kPosts - 1);
                    const std::int32_t z = std::min((b.z + std::min(j, b.depth)) << b.level, kPosts - 1);
                    const float y = drawn.base_level == b.level ? twin.vertex_m(b.level, x, z)
                                                                : twin.refined_m(drawn.base_level, x, z);
                    vertices.push_back({static_cast<float>(x - camera.base_x) - camera.fraction_x_m, y,
                                        static_cast<float>(z - camera.base_z) - camera.fraction_z_m, 0.0f,
                                        static_cast<float>(drawn.base_level)});
                }
            for (std::int32_t j = 0; j < kBlockQuads; ++j)
                for (std::int32_t i = 0; i < kBlockQuads; ++i) {
                    const std::uint32_t at = first + static_cast<std::uint32_t>(j * kVertices + i);
                    for (const std::int32_t step : {0, kVertices, kVertices + 1, 0, kVertices + 1, 1})
                        indices.push_back(at + static_cast<std::uint32_t>(step));
                }
        }
        triangles_ = indices.size() / 3;
        vertex_buffer_ = value(gl::Buffer::create(device(), "plain vertices", vertices.size() * sizeof(vertices[0]),
                                                  gl::BufferUsage::Static, vertices.data()));
        index_buffer_ = value(gl::Buffer::create(device(), "plain indices", indices.size() * sizeof(indices[0]),
                                                 gl::BufferUsage::Static, indices.data()));
        array_.bind();
        array_.float_attribute(0, *vertex_buffer_, 3, gl::AttributeType::Float, 20, 0);
        array_.float_attribute(1, *vertex_buffer_, 2, gl::AttributeType::Float, 20, 12);
        array_.index_buffer(*index_buffer_);
        set_uniforms(scene, camera);
    }

    /// Expects the state that the renderer's draw left: the same depth test, culling, viewport.
    void draw(Scene& scene) {
        const gl::Api& gl = device().gl();
        gl.Enable(GL_CULL_FACE);
        gl.Disable(GL_DEPTH_CLAMP);
        gl.DepthFunc(GL_LESS);
        program_.bind();
        scene.slopes.texture().bind(0);
        array_.bind();
        gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(triangles_ * 3), GL_UNSIGNED_INT, nullptr);
    }
    [[nodiscard]] std::size_t triangles() const { return triangles_; }

private:
    void set_uniforms(const Scene& scene, const Camera& camera) {
        const Shading shading;
        const auto f = [](double v) { return static_cast<float>(v); };
        program_.bind();
        program_.sampler("u_slopes", 0);
        program_.set_mat4(program_.uniform("u_clip_from_relative"), camera.clip_from_relative.data());
        program_.set(program_.uniform("u_slopes_size_posts"), f(scene.slopes.padded_width()),
                     f(scene.slopes.padded_depth()));
        program_.set(program_.uniform("u_slopes_last_level"), SlopeMap::kLevels - 1);
        program_.set(program_.uniform("u_base_stored_post"), f(camera.base_x), f(camera.base_z));
        program_.set(program_.uniform("u_stored_posts"), kPosts, kPosts);
        program_.set(program_.uniform("u_fraction_m"), camera.fraction_x_m, camera.fraction_z_m);
        program_.set(program_.uniform("u_spacing_m"), 1.0f);
        program_.set(program_.uniform("u_eye_tint"), 0.01f, 0.5f);
        program_.set(program_.uniform("u_to_light"), 0.5f, 0.62f, 0.6f);
        program_.set(program_.uniform("u_ambient"), shading.ambient);
        program_.set(program_.uniform("u_diffuse"), shading.diffuse);
        program_.set(program_.uniform("u_specular"), shading.specular);
        program_.set(program_.uniform("u_specular_exponent"), shading.specular_exponent);
        program_.set(program_.uniform("u_fog_colour"), 0.6f, 0.6f, 0.6f);
        program_.set(program_.uniform("u_low_colour"), 0.3f, 0.34f, 0.18f);
        program_.set(program_.uniform("u_high_colour"), 0.6f, 0.6f, 0.5f);
        program_.set(program_.uniform("u_steep_colour"), 0.4f, 0.35f, 0.3f);
    }
    gl::Program program_;
    gl::VertexArray array_;
    std::optional<gl::Buffer> vertex_buffer_, index_buffer_;
    std::size_t triangles_ = 0;
};

void clipmap_frame(benchmark::State& state) {
    const auto width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
    Scene& s = scene();
    gl::Texture2D colour = value(gl::Texture2D::create(device(), "bench colour", {gl::Format::Rgba8, width, height}));
    gl::Texture2D depth = value(gl::Texture2D::create(device(), "bench depth", {gl::Format::Depth32F, width, height}));
    gl::Framebuffer target = value(gl::Framebuffer::create(device(), "bench target"));
    const gl::Texture2D* const colours[] = {&colour};
    target.attach(colours, 0, &depth);

    const double eye_y = s.codec.height_m(s.field.code({512, 512})) + 2;
    const View view{.eye = {512.25, eye_y, 512.5},
                    .forward = {0.8, -0.05, 0.6},
                    .fov_y_rad = std::numbers::pi / 3,
                    .width = width,
                    .height = height,
                    .near_m = 0.1,
                    .far_m = 5000};
    const Camera camera = value(make_camera(view, s.info.grid, s.codec));
    const gl::Api& gl = device().gl();
    const auto clear = [&] {
        target.bind();
        gl.DepthMask(GL_TRUE);
        gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    };
    gl::StageStats stats;
    const auto clipmap = [&] {
        clear();
        check(s.renderer.draw(view, {}, nullptr, s.planes, s.slopes, s.bounds, stats));
    };
    clipmap();
    PlainMesh mesh(s, camera);
    const auto plain = [&] {
        clear();
        mesh.draw(s);
    };
    plain();
    clipmap();
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
    const auto picture = [&] {
        target.read(colour.bounds(), gl::Format::Rgba8, pixels.data());
        return hash_bytes(std::as_bytes(std::span(pixels)));
    };
    const std::uint64_t hash = picture();

    Pair pair;
    for (auto _ : state) pair.run(state, clipmap, plain);
    pair.report(state, "plain_mesh");
    state.counters["triangles"] = static_cast<double>(mesh.triangles());
    state.counters["stitch_triangles"] = s.renderer.last_counts().stitches * (kBlockQuads / 2);
    state.counters["Mtri_per_s"] = static_cast<double>(mesh.triangles()) / (pair.subject().p50 * 1000);
    state.counters["ns_per_pixel"] = pair.subject().p50 * 1e6 / (static_cast<double>(width) * height);
    report_hash(state, hash);
}
BENCHMARK(clipmap_frame)
    ->Args({1280, 720})
    ->Args({1600, 900})
    ->Args({1920, 1080})
    ->ArgNames({"width", "height"})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(15);

}  // namespace
}  // namespace tilth::bench
