#include "tilth/render/terrain_renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>

#include "tilth/core/checks.h"
#include "tilth/core/shared_glsl.h"
#include "tilth/gl/api.h"
#include "tilth/gl/debug_group.h"
#include "tilth/source/mirrored_source.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {
namespace {

constexpr std::int32_t kMeshVertices = kBlockQuads + 1;  // a side; terrain.vert holds the same number
constexpr int kBlockIndices = kBlockQuads * kBlockQuads * 6;
constexpr int kStitchIndices = kBlockQuads * 3;  // kBlockQuads / 2 triangles on row 0 and as many on column 0
constexpr int kHighUnit = 0, kLowUnit = 1, kSlopeUnit = 2, kNodeUnit = 3;
constexpr int kDetailUnit = 4;  // and the three after it; 8 and up are the host's (shade.glsl)

static_assert(sizeof(DrawnBlock) == 6 * sizeof(std::int32_t), "streamed as it is: three ivec2");

/// The mesh, row by row, each quad split along the diagonal from (i, j) to (i + 1, j + 1), counter-clockwise seen from
/// above; then the triangles (2i, 2i+1, 2i+2) of row 0 and of column 0. A stitch has no depth or no width, so that one
/// of the two collapses to a point.
std::vector<std::uint16_t> mesh_indices() {
    std::vector<std::uint16_t> indices;
    indices.reserve(kBlockIndices + kStitchIndices);
    const auto add = [&](std::int32_t x, std::int32_t z) {
        indices.push_back(static_cast<std::uint16_t>(z * kMeshVertices + x));
    };
    for (std::int32_t z = 0; z < kBlockQuads; ++z) {
        for (std::int32_t x = 0; x < kBlockQuads; ++x) {
            add(x, z), add(x, z + 1), add(x + 1, z + 1);
            add(x, z), add(x + 1, z + 1), add(x + 1, z);
        }
    }
    for (std::int32_t i = 0; i < kBlockQuads; i += 2) add(i, 0), add(i + 1, 0), add(i + 2, 0);
    for (std::int32_t i = 0; i < kBlockQuads; i += 2) add(0, i), add(0, i + 1), add(0, i + 2);
    return indices;
}

/// Instances from the `first`-th of the buffer on: GL 3.3 has no base instance.
void describe_instances(gl::VertexArray& array, const gl::Buffer& instances, std::size_t first = 0) {
    constexpr int stride = sizeof(DrawnBlock);
    const std::size_t at = first * sizeof(DrawnBlock);
    array.int_attribute(0, instances, 2, gl::AttributeType::Int, stride, at + offsetof(ClipmapBlock, x), 1);
    array.int_attribute(1, instances, 2, gl::AttributeType::Int, stride, at + offsetof(ClipmapBlock, width), 1);
    array.int_attribute(2, instances, 2, gl::AttributeType::Int, stride, at + offsetof(ClipmapBlock, level), 1);
}

Vec3f normalised(const Vec3f& v) {
    const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return length > 0 ? Vec3f{v.x / length, v.y / length, v.z / length} : Vec3f{0, 1, 0};
}

void set(const gl::Program& program, gl::Uniform uniform, const Vec3f& v) { program.set(uniform, v.x, v.y, v.z); }

std::int32_t post_of(std::int32_t vertex, std::int32_t level, std::int32_t last) {
    return static_cast<std::int32_t>(std::min(std::int64_t{vertex} << level, std::int64_t{last}));
}

/// The base post on the stored map: itself, or within one period of the reflection.
std::int32_t stored_base(std::int32_t base, std::int32_t posts, bool mirrored) {
    const std::int32_t period = 2 * (posts - 1);
    return mirrored ? ((base % period) + period) % period : base;
}

}  // namespace

Result<TerrainRenderer> TerrainRenderer::create(gl::Device& device, gl::ShaderLibrary& shaders,
                                                const ClipmapSettings& settings, const MapInfo& map) {
    if (Result<void> checked = check_clipmap(settings); !checked) return checked.error();
    if (map.grid.width < 2 || map.grid.depth < 2 || !(map.grid.spacing_m > 0))
        return Error{ErrorCode::InvalidArgument,
                     text("a map to draw has 2 x 2 posts or more and a spacing above 0, not ", map.grid.width, " x ",
                          map.grid.depth, " posts ", map.grid.spacing_m, " m apart")};
    auto by_kind = make_shaders(shaders, map, false);
    if (!by_kind) return by_kind.error();

    auto block_array = gl::VertexArray::create(device, "clipmap blocks");
    if (!block_array) return block_array.error();
    auto stitch_array = gl::VertexArray::create(device, "clipmap stitches");
    if (!stitch_array) return stitch_array.error();
    const std::vector<std::uint16_t> mesh = mesh_indices();
    auto indices =
        gl::Buffer::create(device, "clipmap mesh", mesh.size() * sizeof(mesh[0]), gl::BufferUsage::Static, mesh.data());
    if (!indices) return indices.error();
    auto blocks = gl::Buffer::create(device, "clipmap blocks", 256 * sizeof(DrawnBlock), gl::BufferUsage::Stream);
    if (!blocks) return blocks.error();
    auto stitches = gl::Buffer::create(device, "clipmap stitches", 256 * sizeof(DrawnBlock), gl::BufferUsage::Stream);
    if (!stitches) return stitches.error();
    auto weights =
        gl::TextureBuffer::create(device, "clipmap refinement", gl::Format::R32F, 1024, gl::BufferUsage::Stream);
    if (!weights) return weights.error();
    return TerrainRenderer(device, shaders, settings, map, std::move(*by_kind), std::move(*block_array),
                           std::move(*stitch_array), std::move(*indices), std::move(*blocks), std::move(*stitches),
                           std::move(*weights));
}

Result<std::vector<TerrainRenderer::Shader>> TerrainRenderer::make_shaders(gl::ShaderLibrary& shaders,
                                                                           const MapInfo& map, bool detail) {
    gl::Features features;
    if (map.precision == HeightPrecision::bits16) features.emplace_back("BITS16", "1");
    if (map.mirrored) features.emplace_back("MIRRORED", "1");
    if (map.slopes == SlopeFormat::rg16f) features.emplace_back("SLOPES_RG16F", "1");
    if (detail) features.emplace_back("DETAIL", "1");
    std::vector<Shader> by_kind;
    for (const char* const kind : {"ALL_OWN", "ALL_MORPHING", "ALL_REFINED", ""}) {
        gl::Features of_kind = features;
        if (*kind != '\0')
            of_kind.emplace_back(kind, "1");
        else if (detail)
            of_kind.emplace_back("DETAIL_WINDOW", "1");
        auto program = shaders.program(detail ? "terrain with detail" : "terrain", "render/terrain.vert",
                                       "render/terrain.frag", of_kind);
        if (!program) return program.error();
        program->sampler("u_high_plane", kHighUnit);
        program->sampler("u_low_plane", kLowUnit);
        program->sampler("u_slopes", kSlopeUnit);
        program->sampler("u_node_weights", kNodeUnit);
        if (detail) {
            int unit = kDetailUnit;
            for (const char* const tile : {"u_detail", "u_detail_x", "u_detail_z", "u_detail_xz"})
                program->sampler(tile, unit++);
        }
        const Uniforms uniforms(*program);
        by_kind.push_back({std::move(*program), uniforms});
    }
    return by_kind;
}

TerrainRenderer::TerrainRenderer(gl::Device& device, gl::ShaderLibrary& library, const ClipmapSettings& settings,
                                 const MapInfo& map, std::vector<Shader> shaders_by_kind, gl::VertexArray block_array,
                                 gl::VertexArray stitch_array, gl::Buffer indices, gl::Buffer blocks,
                                 gl::Buffer stitches, gl::TextureBuffer node_weights)
    : device_(&device),
      library_(&library),
      settings_(settings),
      map_(map),
      last_post_(map.mirrored ? Texel{MirroredSource::kSide - 1, MirroredSource::kSide - 1}
                              : Texel{map.grid.width - 1, map.grid.depth - 1}),
      shaders_(std::move(shaders_by_kind)),
      block_array_(std::move(block_array)),
      stitch_array_(std::move(stitch_array)),
      indices_(std::move(indices)),
      block_buffer_(std::move(blocks)),
      stitch_buffer_(std::move(stitches)),
      node_weights_(std::move(node_weights)) {
    describe_instances(block_array_, block_buffer_);
    block_array_.index_buffer(indices_);
    describe_instances(stitch_array_, stitch_buffer_);
    stitch_array_.index_buffer(indices_);
}

TerrainRenderer::Uniforms::Uniforms(gl::Program& program)
    : last_post(program.uniform("u_last_post")),
      stored_posts(program.uniform("u_stored_posts")),
      base_post(program.uniform("u_base_post")),
      fraction_m(program.uniform("u_fraction_m")),
      spacing_m(program.uniform("u_spacing_m")),
      eye_code(program.uniform("u_eye_code")),
      eye_above_code_m(program.uniform("u_eye_above_code_m")),
      code_quantum_m(program.uniform("u_code_quantum_m")),
      n(program.uniform("u_n")),
      zone_units(program.uniform("u_zone_units")),
      coarsest_level(program.uniform("u_coarsest_level")),
      clip_from_relative(program.uniform("u_clip_from_relative")),
      slopes_size_posts(program.uniform("u_slopes_size_posts")),
      slopes_last_level(program.uniform("u_slopes_last_level")),
      node_grids(program.uniform("u_node_grids")),
      base_stored_post(program.uniform("u_base_stored_post")),
      eye_tint(program.uniform("u_eye_tint")),
      to_light(program.uniform("u_to_light")),
      ambient(program.uniform("u_ambient")),
      diffuse(program.uniform("u_diffuse")),
      specular(program.uniform("u_specular")),
      specular_exponent(program.uniform("u_specular_exponent")),
      fog_colour(program.uniform("u_fog_colour")),
      fog_density(program.uniform("u_fog_density")),
      low_colour(program.uniform("u_low_colour")),
      high_colour(program.uniform("u_high_colour")),
      steep_colour(program.uniform("u_steep_colour")),
      cursor_m(program.uniform("u_cursor_m")),
      cursor_colour(program.uniform("u_cursor_colour")),
      detail_base_texels(program.uniform("u_detail_base_texels")),
      detail_texels_per_m(program.uniform("u_detail_texels_per_m")),
      detail_apron(program.uniform("u_detail_apron")),
      detail_stored_size(program.uniform("u_detail_stored_size")),
      detail_map_edge(program.uniform("u_detail_map_edge")),
      detail_reach_m(program.uniform("u_detail_reach_m")),
      detail_tile_texels(program.uniform("u_detail_tile_texels")),
      detail_window_texels(program.uniform("u_detail_window_texels")) {}

Result<void> TerrainRenderer::reload(gl::ShaderLibrary& shaders) {
    Result<void> result;
    for (std::vector<Shader>* const made : {&shaders_, &detail_shaders_})
        for (Shader& shader : *made)
            if (Result<void> reloaded = shaders.reload(shader.program); !reloaded) result = std::move(reloaded);
    return result;
}

Result<void> TerrainRenderer::draw(const View& view, const Shading& shading, const BrushCursor* cursor,
                                   const HeightPlanes& planes, const SlopeMap& slopes, const HeightBounds& bounds,
                                   gl::StageStats& stats, const DetailView* detail) {
    const auto start = std::chrono::steady_clock::now();
    counts_ = {};
    if (view.depth == DepthConvention::Reversed && !device_->capabilities().clip_control)
        return Error{ErrorCode::Unsupported,
                     "view.depth is Reversed, which needs GL_ARB_clip_control (GL 4.5), and this context has it not; "
                     "use DepthConvention::Standard"};
    const Result<Camera> camera = make_camera(view, map_.grid, map_.codec);
    if (!camera) return camera.error();
    if (!camera->draws) return {};
    choose_blocks(*camera, bounds, detail);
    if (drawn_.blocks.empty()) return {};
    const bool with_detail = counts_.detail_blocks > 0;

    const gl::DebugGroup group(*device_, "tilth terrain");
    const gl::Api& gl = device_->gl();
    set_state(view);
    if (with_detail && detail_shaders_.empty())
        if (Result<void> made = make_detail_programs(stats); !made) return made;
    planes.high().bind(kHighUnit);
    planes.low().bind(kLowUnit);
    slopes.texture().bind(kSlopeUnit);
    if (!refinement_.weights.empty()) node_weights_.replace(std::as_bytes(std::span(refinement_.weights)));
    node_weights_.bind(kNodeUnit);
    std::array<bool, 2 * kKinds> ready{};
    const auto use = [&](Kind kind, DetailSource source) {
        const auto index = static_cast<std::size_t>(kind);
        const bool fine = source != DetailSource::None;
        const Shader& shader = fine ? detail_shaders_[index] : shaders_[index];
        shader.program.bind();
        bool& is_ready = ready[index + (fine ? kKinds : 0)];
        if (!is_ready) set_uniforms(shader, *camera, shading, cursor, slopes);
        is_ready = true;
        if (fine) set_detail(shader, *detail, source, *camera);
    };

    block_buffer_.replace(std::as_bytes(std::span(drawn_.blocks)));
    std::size_t first = 0;
    for (const auto& [kind, source, count] : runs_) {
        use(kind, source);
        block_array_.bind();
        describe_instances(block_array_, block_buffer_, first);
        gl.DrawElementsInstanced(GL_TRIANGLES, kBlockIndices, GL_UNSIGNED_SHORT, nullptr, static_cast<GLsizei>(count));
        stats.draws += 1;
        first += count;
    }
    if (!drawn_.stitches.empty()) {
        use(Kind::General, with_detail ? DetailSource::Window : DetailSource::None);
        gl.Disable(GL_CULL_FACE);   // a triangle without area has no front,
        gl.Enable(GL_DEPTH_CLAMP);  // and where a rasteriser finds a pixel in it, the depth there may be anything:
        gl.DepthFunc(view.depth == DepthConvention::Reversed ? GL_GEQUAL : GL_LEQUAL);  // still before the background
        stitch_buffer_.replace(std::as_bytes(std::span(drawn_.stitches)));
        stitch_array_.bind();
        gl.DrawElementsInstanced(GL_TRIANGLES, kStitchIndices, GL_UNSIGNED_SHORT,
                                 reinterpret_cast<const void*>(kBlockIndices * sizeof(std::uint16_t)),
                                 static_cast<GLsizei>(drawn_.stitches.size()));
        stats.draws += 1;
    }
    stats.passes += 1;
    stats.primitives += drawn_.blocks.size() * (kBlockIndices / 3) + drawn_.stitches.size() * (kStitchIndices / 3);
    stats.bytes += (drawn_.blocks.size() + drawn_.stitches.size()) * sizeof(DrawnBlock) +
                   refinement_.weights.size() * sizeof(float);
    stats.cpu_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return {};
}

Result<void> TerrainRenderer::make_detail_programs(gl::StageStats& stats) {
    const std::uint64_t linked = library_->programs_linked();
    auto made = make_shaders(*library_, map_, true);
    stats.programs += library_->programs_linked() - linked;
    if (!made) return made.error();
    const bool bytes = map_.slopes == SlopeFormat::rg8;
    auto flat = gl::Texture2D::create(
        *device_, "flat detail", {.format = bytes ? gl::Format::Rg8 : gl::Format::Rg16F, .filter = gl::Filter::Linear});
    if (!flat) return flat.error();
    const std::uint8_t of_bytes[] = {128, 128}, of_halves[] = {0, 0, 0, 0};
    flat->upload(0, flat->bounds(), bytes ? of_bytes : of_halves);
    flat_ = std::move(*flat);
    detail_shaders_ = std::move(*made);

    // A block without size, by uniforms that are still 0: a point, no pixel, and a compiled program.
    const DrawnBlock nothing;
    block_buffer_.replace(std::as_bytes(std::span(&nothing, 1)));
    block_array_.bind();
    describe_instances(block_array_, block_buffer_);
    for (int unit = kDetailUnit; unit < kDetailUnit + 4; ++unit) flat_->bind(unit);
    for (const Shader& shader : detail_shaders_) {
        shader.program.bind();
        device_->gl().DrawElementsInstanced(GL_TRIANGLES, kBlockIndices, GL_UNSIGNED_SHORT, nullptr, 1);
        stats.draws += 1;
    }
    return {};
}

void TerrainRenderer::choose_blocks(const Camera& camera, const HeightBounds& bounds, const DetailView* detail) {
    const DetailView* const there = detail != nullptr && !detail->empty() && detail->reach_m > 0 ? detail : nullptr;
    const ClipmapLayout layout = clipmap_layout(settings_, camera.eye_posts, last_post_.x, last_post_.z);
    refinement_ = clipmap_refinement(settings_, layout, camera, {map_.grid, map_.codec, map_.mirrored, bounds});
    drawn_ = drawn_blocks(layout, refinement_, last_post_.x, last_post_.z);
    if (debug_.cull_blocks) {
        const auto hidden = [&](const DrawnBlock& drawn) { return !is_visible(drawn, camera, bounds); };
        counts_.culled_blocks = static_cast<std::uint32_t>(std::erase_if(drawn_.blocks, hidden));
        std::erase_if(drawn_.stitches, hidden);
    }
    std::erase_if(drawn_.stitches, [&](const DrawnBlock& s) { return s.base_level == debug_.omit_stitches_of_level; });
    // Front to back: by the level of the surface; blocks of one kind together; then by the distance of a block's
    // middle.
    const auto distance = [&](const ClipmapBlock& b) {
        const double unit = std::ldexp(1.0, b.level);
        return std::max(std::abs((b.x + b.width * 0.5) * unit - camera.eye_posts.x),
                        std::abs((b.z + b.depth * 0.5) * unit - camera.eye_posts.z));
    };
    const auto order = [&](const DrawnBlock& drawn) {
        const Run run = run_of(drawn, camera, there);
        return std::tuple(drawn.base_level, run.kind, run.detail, distance(drawn.block));
    };
    std::stable_sort(drawn_.blocks.begin(), drawn_.blocks.end(),
                     [&](const DrawnBlock& a, const DrawnBlock& b) { return order(a) < order(b); });
    runs_.clear();
    for (const DrawnBlock& drawn : drawn_.blocks) {
        const Run run = run_of(drawn, camera, there);
        if (runs_.empty() || runs_.back().kind != run.kind || runs_.back().detail != run.detail) runs_.push_back(run);
        ++runs_.back().count;
        if (run.detail != DetailSource::None) ++counts_.detail_blocks;
    }
    counts_.blocks = static_cast<std::uint32_t>(drawn_.blocks.size());
    counts_.refined_blocks = static_cast<std::uint32_t>(
        std::count_if(drawn_.blocks.begin(), drawn_.blocks.end(),
                      [](const DrawnBlock& drawn) { return drawn.base_level != drawn.block.level; }));
    counts_.stitches = static_cast<std::uint32_t>(drawn_.stitches.size());
}

TerrainRenderer::Run TerrainRenderer::run_of(const DrawnBlock& drawn, const Camera& camera,
                                             const DetailView* detail) const {
    const Kind kind = kind_of(drawn, camera);
    if (detail == nullptr) return {kind};
    const ClipmapBlock& b = drawn.block;
    const DetailSource source =
        detail_source(*detail, {post_of(b.x, b.level, last_post_.x), post_of(b.z, b.level, last_post_.z)},
                      {post_of(b.x + b.width, b.level, last_post_.x), post_of(b.z + b.depth, b.level, last_post_.z)},
                      map_.grid, camera);
    return {source == DetailSource::Window ? Kind::General : kind, source};
}

TerrainRenderer::Kind TerrainRenderer::kind_of(const DrawnBlock& drawn, const Camera& camera) const {
    if (drawn.base_level != drawn.block.level) return Kind::Refined;
    if (drawn.base_level == settings_.levels - 1) return Kind::Own;
    // The farthest corner decides; half a unit more than the float's rounding of a distance below 2^10 units.
    const ClipmapBlock& b = drawn.block;
    const double unit = std::ldexp(1.0, b.level);
    const double farthest =
        std::max({std::abs(b.x - camera.eye_posts.x / unit), std::abs(b.x + b.width - camera.eye_posts.x / unit),
                  std::abs(b.z - camera.eye_posts.z / unit), std::abs(b.z + b.depth - camera.eye_posts.z / unit)});
    const float alpha = shared::morph_alpha(static_cast<float>(farthest) + 0.5f, settings_.n,
                                            shared::morph_zone_units(settings_.n, static_cast<float>(settings_.blend)));
    return alpha > 0 ? Kind::Morphing : Kind::Own;
}

bool TerrainRenderer::is_visible(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds) const {
    const ClipmapBlock& block = drawn.block;
    const std::int32_t x0 = post_of(block.x, block.level, last_post_.x);
    const std::int32_t x1 = post_of(block.x + block.width, block.level, last_post_.x);
    const std::int32_t z0 = post_of(block.z, block.level, last_post_.z);
    const std::int32_t z1 = post_of(block.z + block.depth, block.level, last_post_.z);
    // Refinement reads vertices of the surface about it, and morphing those of the next level about them.
    const std::int64_t margin = std::int64_t{4} << drawn.base_level;
    const auto clamped = [](std::int64_t p, std::int32_t last) {
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(p, 0, last));
    };
    PostRange x{clamped(x0 - margin, last_post_.x), clamped(x1 + margin, last_post_.x)};
    PostRange z{clamped(z0 - margin, last_post_.z), clamped(z1 + margin, last_post_.z)};
    if (map_.mirrored) {
        x = folded_range(x.min, x.max, map_.grid.width);
        z = folded_range(z.min, z.max, map_.grid.depth);
    }
    const CodeRange codes = bounds.query({{x.min, z.min}, {x.max + 1, z.max + 1}});
    const auto height = [&](std::uint32_t code) {
        return (static_cast<double>(code) - 2147483648.0) * map_.codec.code_quantum_m() - camera.eye_y_m;
    };
    const double s = map_.grid.spacing_m;
    return !is_culled({{x0 * s - camera.eye_x_m, height(codes.min), z0 * s - camera.eye_z_m},
                       {x1 * s - camera.eye_x_m, height(codes.max), z1 * s - camera.eye_z_m}},
                      camera);
}

void TerrainRenderer::set_state(const View& view) {
    const gl::Api& gl = device_->gl();
    const bool reversed = view.depth == DepthConvention::Reversed;
    gl.Viewport(0, 0, view.width, view.height);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(reversed ? GL_GREATER : GL_LESS);
    gl.DepthMask(GL_TRUE);
    gl.DepthRange(0.0, 1.0);
    if (device_->capabilities().clip_control)
        gl.ClipControl(GL_LOWER_LEFT, reversed ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
    if (debug_.cull_back_faces) {
        gl.Enable(GL_CULL_FACE);
        gl.CullFace(GL_BACK);
        gl.FrontFace(GL_CCW);
    } else {
        gl.Disable(GL_CULL_FACE);
    }
    for (const GLenum off :
         {GL_BLEND, GL_DITHER, GL_POLYGON_SMOOTH, GL_COLOR_LOGIC_OP, GL_SCISSOR_TEST, GL_STENCIL_TEST,
          GL_RASTERIZER_DISCARD, GL_POLYGON_OFFSET_FILL, GL_DEPTH_CLAMP, GL_SAMPLE_ALPHA_TO_COVERAGE,
          GL_SAMPLE_ALPHA_TO_ONE, GL_SAMPLE_COVERAGE, GL_SAMPLE_MASK, GL_PRIMITIVE_RESTART})
        gl.Disable(off);
    for (GLenum plane = 0; plane < 8; ++plane) gl.Disable(GL_CLIP_DISTANCE0 + plane);
    gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void TerrainRenderer::set_uniforms(const Shader& shader, const Camera& camera, const Shading& shading,
                                   const BrushCursor* cursor, const SlopeMap& slopes) const {
    const gl::Program& program = shader.program;
    const Uniforms& u = shader.uniforms;
    const GridSpec& grid = map_.grid;
    const auto f = [](double value) { return static_cast<float>(value); };
    program.set(u.last_post, last_post_.x, last_post_.z);
    program.set(u.stored_posts, grid.width, grid.depth);
    program.set(u.base_post, camera.base_x, camera.base_z);
    program.set(u.fraction_m, camera.fraction_x_m, camera.fraction_z_m);
    program.set(u.spacing_m, f(grid.spacing_m));
    program.set(u.eye_code, camera.eye_code);
    program.set(u.eye_above_code_m, camera.eye_above_code_m);
    program.set(u.code_quantum_m, f(map_.codec.code_quantum_m()));
    program.set(u.n, settings_.n);
    program.set(u.zone_units, shared::morph_zone_units(settings_.n, f(settings_.blend)));
    program.set(u.coarsest_level, settings_.levels - 1);
    program.set_mat4(u.clip_from_relative, camera.clip_from_relative.data());
    program.set(u.slopes_size_posts, f(slopes.padded_width()), f(slopes.padded_depth()));
    program.set(u.slopes_last_level, slopes.texture().levels() - 1);
    program.set(u.base_stored_post, f(stored_base(camera.base_x, grid.width, map_.mirrored)),
                f(stored_base(camera.base_z, grid.depth, map_.mirrored)));

    std::vector<std::int32_t> grids;
    for (const NodeGrid& nodes : refinement_.grids)
        for (const std::int32_t value : {nodes.min_x, nodes.min_z, nodes.width, nodes.first}) grids.push_back(value);
    program.set_ivec4s(u.node_grids, grids);

    const double tint_span = std::max(shading.tint_high_m - shading.tint_low_m, 1.0);
    program.set(u.eye_tint, f(1 / tint_span),
                f((camera.eye_y_m + map_.codec.middle_m - shading.tint_low_m) / tint_span));
    set(program, u.to_light, normalised(shading.to_light));
    program.set(u.ambient, shading.ambient);
    program.set(u.diffuse, shading.diffuse);
    program.set(u.specular, shading.specular);
    program.set(u.specular_exponent, shading.specular_exponent);
    set(program, u.fog_colour, shading.fog_colour);
    program.set(u.fog_density, f(shading.fog_density));
    set(program, u.low_colour, shading.low_colour);
    set(program, u.high_colour, shading.high_colour);
    set(program, u.steep_colour, shading.steep_colour);
    if (cursor != nullptr && cursor->radius_m > 0) {
        program.set(u.cursor_m, f(cursor->centre.x - grid.origin.x - camera.eye_x_m),
                    f(cursor->centre.z - grid.origin.z - camera.eye_z_m), f(cursor->radius_m));
        set(program, u.cursor_colour, cursor->colour);
    } else {
        program.set(u.cursor_m, 0.0f, 0.0f, 0.0f);
    }
}

void TerrainRenderer::set_detail(const Shader& shader, const DetailView& detail, DetailSource source,
                                 const Camera& camera) const {
    TileIndex origin = detail.window.min;
    const auto bind = [&](std::size_t slot, int unit) {
        const gl::Texture2D* const tile = detail.slopes[slot];
        TILTH_EXPECTS(
            tile == nullptr || (tile->width() == detail.grid.stored_size() &&
                                tile->height() == detail.grid.stored_size() && tile->format() == flat_->format()),
            "a detail tile's slopes are stored_size texels a side, in the format of the map's slopes");
        (tile != nullptr ? *tile : *flat_).bind(unit);
    };
    if (source == DetailSource::Window) {
        for (std::size_t slot = 0; slot < 4; ++slot) bind(slot, kDetailUnit + static_cast<int>(slot));
    } else {
        const auto slot = static_cast<std::size_t>(source) - static_cast<std::size_t>(DetailSource::Slot0);
        bind(slot, kDetailUnit);
        origin.x += static_cast<std::int32_t>(slot % 2), origin.z += static_cast<std::int32_t>(slot / 2);
    }
    const gl::Program& program = shader.program;
    const Uniforms& u = shader.uniforms;
    const auto f = [](auto value) { return static_cast<float>(value); };
    const DetailPlacement at = detail_placement(detail, origin, map_.grid, camera);
    program.set(u.detail_base_texels, at.base_x, at.base_z);
    program.set(u.detail_map_edge, at.map_edge[0], at.map_edge[1], at.map_edge[2], at.map_edge[3]);
    program.set(u.detail_texels_per_m, f(texels_per_post(detail, map_.grid) / map_.grid.spacing_m));
    program.set(u.detail_apron, f(detail.grid.apron));
    program.set(u.detail_stored_size, f(detail.grid.stored_size()));
    program.set(u.detail_reach_m, f(detail.reach_m));
    program.set(u.detail_tile_texels, f(detail.grid.size));
    program.set(u.detail_window_texels, f(detail.window.columns() * detail.grid.size),
                f(detail.window.rows() * detail.grid.size));
}

}  // namespace tilth
