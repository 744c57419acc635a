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
#include "tilth/gl/offset_pointer.h"
#include "tilth/render/relief_reach.h"
#include "tilth/source/mirrored_source.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {
namespace {

constexpr std::int32_t kMeshVertices = kBlockQuads + 1;  // a side; terrain.vert holds the same number
constexpr int kBlockIndices = kBlockQuads * kBlockQuads * 6;
constexpr int kStitchIndices = kBlockQuads * 3;  // kBlockQuads / 2 triangles on row 0 and as many on column 0
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

std::int32_t post_of(std::int32_t vertex, std::int32_t level, std::int32_t last) {
    return static_cast<std::int32_t>(std::min(std::int64_t{vertex} << level, std::int64_t{last}));
}

constexpr BlockKind kKinds[] = {BlockKind::Own, BlockKind::Morphing, BlockKind::Refined, BlockKind::General};
constexpr BlockKind kReliefKinds[] = {BlockKind::Own, BlockKind::Morphing};  // of the finest level's own blocks

/// Texels before a block in which relief that hides it is looked for.
constexpr double kMostHidden = 256;
/// `refine_above_px` that refines nothing.
constexpr double kNeverRefine = 1e6;
/// Patches in a draw where `Quirks::patch_draws_must_be_small`, for edges split in at most `factor` parts (a triangle
/// split 16 times has 217 vertices). Powers of two, so that a block is drawn by whole draws.
int patches_a_draw(std::int32_t factor) { return factor <= 8 ? 256 : factor <= 16 ? 128 : factor <= 32 ? 64 : 16; }
static_assert(kBlockIndices % (256 * 3) == 0);

/// A choice for each kind of block.
std::vector<ProgramChoice> choices_of_kinds(ProgramChoice::Detail detail, const ProgramChoice& like) {
    std::vector<ProgramChoice> choices;
    for (const BlockKind kind : kKinds) {
        choices.push_back(like);
        choices.back().kind = kind;
        choices.back().detail = detail;
    }
    return choices;
}

std::string key_of(const char* what, bool curved, bool debug_view) {
    return text(what, curved ? " curved" : "", debug_view ? " debug" : "");
}

std::string key_of(const BackendPlan& plan, bool debug_view) {
    std::string key = debug_view ? "relief debug" : "relief";
    for (const ReliefRecipe& recipe : plan.recipes) {
        key += text("; ", recipe.name);
        for (const auto& [name, value] : recipe.features) key += text(" ", name, "=", value);
    }
    return key;
}

}  // namespace

Result<TerrainRenderer> TerrainRenderer::create(gl::Device& device, gl::ShaderLibrary& shaders,
                                                const ClipmapSettings& settings, const MapInfo& map) {
    if (Result<void> checked = check_clipmap(settings); !checked) return checked.error();
    if (map.grid.width < 2 || map.grid.depth < 2 || !(map.grid.spacing_m > 0))
        return Error{ErrorCode::InvalidArgument,
                     text("a map to draw has 2 x 2 posts or more and a spacing above 0, not ", map.grid.width, " x ",
                          map.grid.depth, " posts ", map.grid.spacing_m, " m apart")};
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
    TerrainRenderer made(device, shaders, settings, map, std::move(*block_array), std::move(*stitch_array),
                         std::move(*indices), std::move(*blocks), std::move(*stitches), std::move(*weights));
    gl::StageStats unwanted;
    const auto plain =
        made.group_of(key_of("plain", false, false), choices_of_kinds(ProgramChoice::Detail::None, {}), unwanted);
    if (!plain) return plain.error();
    return made;
}

TerrainRenderer::TerrainRenderer(gl::Device& device, gl::ShaderLibrary& library, const ClipmapSettings& settings,
                                 const MapInfo& map, gl::VertexArray block_array, gl::VertexArray stitch_array,
                                 gl::Buffer indices, gl::Buffer blocks, gl::Buffer stitches,
                                 gl::TextureBuffer node_weights)
    : device_(&device),
      library_(&library),
      settings_(settings),
      map_(map),
      last_post_(map.mirrored ? Texel{MirroredSource::kSide - 1, MirroredSource::kSide - 1}
                              : Texel{map.grid.width - 1, map.grid.depth - 1}),
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

Result<void> TerrainRenderer::reload(gl::ShaderLibrary& shaders) {
    Result<void> result;
    for (const std::unique_ptr<Group>& group : groups_)
        for (TerrainProgram& made : group->programs)
            if (Result<void> reloaded = shaders.reload(made.program()); !reloaded) result = std::move(reloaded);
    return result;
}

TerrainRenderer::Mode TerrainRenderer::mode_of(const View& view, const DetailView* detail) const {
    Mode mode;
    if (detail == nullptr) return mode;
    const DetailSettings& settings = detail->settings;
    mode.phong = settings.phong.on;
    mode.phong_shape = settings.phong.shape;
    mode.debug_view = settings.debug_view != DebugView::Off;
    if (!detail->relief || detail->empty() || !(detail->reach_m > 0)) return mode;
    const double reach_m = relief_reach(settings_, map_.grid.spacing_m, texels_per_post(*detail, map_.grid),
                                        settings.reach, detail->reach_m)
                               .reach_m;
    if (!(reach_m > 0)) return mode;
    mode.plan = plan_backend({.settings = settings,
                              .reach_m = reach_m,
                              .texels_per_post = texels_per_post(*detail, map_.grid),
                              .reversed_depth = view.depth == DepthConvention::Reversed});
    return mode;
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
    const Mode mode = mode_of(view, detail);
    choose_blocks(*camera, bounds, detail, mode);
    if (drawn_.blocks.empty()) return {};

    const gl::DebugGroup group(*device_, "tilth terrain");
    const gl::Api& gl = device_->gl();
    set_state(view);
    const Result<Groups> groups = groups_for(mode, stats);
    if (!groups) return groups.error();
    planes.high().bind(kHighUnit);
    planes.low().bind(kLowUnit);
    slopes.texture().bind(kSlopeUnit);
    if (!refinement_.weights.empty()) node_weights_.replace(std::as_bytes(std::span(refinement_.weights)));
    node_weights_.bind(kNodeUnit);
    const DetailSettings none;
    const ProgramFrame frame{.map = map_,
                             .clipmap = settings_,
                             .last_post = last_post_,
                             .camera = *camera,
                             .shading = shading,
                             .cursor = cursor,
                             .slopes = slopes,
                             .refinement = refinement_,
                             .settings = detail != nullptr ? detail->settings : none,
                             .detail = detail};
    std::vector<const TerrainProgram*> ready;
    const auto use = [&](const Run& run, bool curved) -> const TerrainProgram& {
        TerrainProgram& wanted = program_of(run, *groups, curved);
        wanted.program().bind();
        if (std::find(ready.begin(), ready.end(), &wanted) == ready.end()) {
            wanted.set_frame(frame);
            if (run.relief != 0) wanted.set_relief(frame, *detail, mode.plan);
            ready.push_back(&wanted);
        }
        if (run.relief != 0)
            wanted.bind_relief(*detail);
        else if (run.detail != DetailSource::None)
            wanted.set_tiles(frame, *detail, run.detail, *flat_);
        return wanted;
    };

    const bool wireframe = detail != nullptr && detail->settings.debug_view == DebugView::Wireframe;
    if (wireframe) gl.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    const std::int32_t curve_factor = frame.settings.phong.most_factor;
    const std::int32_t relief_factor =
        mode.plan.empty() ? 1 : std::min(frame.settings.refinement.most_factor, texels_per_post(*detail, map_.grid));
    block_buffer_.replace(std::as_bytes(std::span(drawn_.blocks)));
    std::size_t first = 0;
    for (const Run& run : runs_) {
        const TerrainProgram& program = use(run, mode.phong && run.relief == 0);
        block_array_.bind();
        if (program.patches())
            draw_patches(first, run.count, run.relief != 0 ? relief_factor : curve_factor, stats);
        else
            draw_triangles(first, run.count, stats);
        first += run.count;
    }
    if (!drawn_.stitches.empty()) {
        use({.kind = BlockKind::General,
             .detail = counts_.detail_blocks > 0 ? DetailSource::Window : DetailSource::None},
            false);
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
    if (wireframe) gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    stats.passes += 1;
    stats.primitives += drawn_.blocks.size() * (kBlockIndices / 3) + drawn_.stitches.size() * (kStitchIndices / 3);
    stats.bytes += (drawn_.blocks.size() + drawn_.stitches.size()) * sizeof(DrawnBlock) +
                   refinement_.weights.size() * sizeof(float);
    stats.cpu_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return {};
}

void TerrainRenderer::draw_triangles(std::size_t first, std::size_t count, gl::StageStats& stats) {
    describe_instances(block_array_, block_buffer_, first);
    device_->gl().DrawElementsInstanced(GL_TRIANGLES, kBlockIndices, GL_UNSIGNED_SHORT, nullptr,
                                        static_cast<GLsizei>(count));
    stats.draws += 1;
}

void TerrainRenderer::draw_patches(std::size_t first, std::size_t count, std::int32_t factor, gl::StageStats& stats) {
    const gl::Api& gl = device_->gl();
    gl.PatchParameteri(GL_PATCH_VERTICES, 3);
    if (!device_->quirks().patch_draws_must_be_small) {
        describe_instances(block_array_, block_buffer_, first);
        gl.DrawElementsInstanced(GL_PATCHES, kBlockIndices, GL_UNSIGNED_SHORT, nullptr, static_cast<GLsizei>(count));
        stats.draws += 1;
        return;
    }
    const int indices = patches_a_draw(factor) * 3;
    for (std::size_t block = first; block < first + count; ++block) {
        describe_instances(block_array_, block_buffer_, block);
        for (int at = 0; at < kBlockIndices; at += indices) {
            gl.DrawElementsInstanced(GL_PATCHES, indices, GL_UNSIGNED_SHORT,
                                     gl::offset_pointer(static_cast<std::size_t>(at) * sizeof(std::uint16_t)), 1);
            stats.draws += 1;
        }
    }
}

// ---- programs ----

TerrainProgram& TerrainRenderer::program_of(const Run& run, const Groups& groups, bool curved) {
    const auto kind = static_cast<std::size_t>(run.kind);
    if (run.relief != 0) return groups.relief->programs[(run.relief - 1) * std::size(kReliefKinds) + kind];
    const auto& of_detail = run.detail == DetailSource::None ? groups.plain : groups.detail;
    return of_detail[curved ? 1 : 0]->programs[kind];
}

Result<TerrainRenderer::Group*> TerrainRenderer::group_of(const std::string& key,
                                                          std::span<const ProgramChoice> choices,
                                                          gl::StageStats& stats) {
    for (const std::unique_ptr<Group>& group : groups_)
        if (group->key == key) return group.get();
    auto group = std::make_unique<Group>(Group{key, {}});
    const std::uint64_t linked = library_->programs_linked();
    Result<void> outcome;
    for (const ProgramChoice& choice : choices) {
        Result<TerrainProgram> made = TerrainProgram::create(*library_, map_, choice);
        if (!made) {
            outcome = made.error();
            break;
        }
        group->programs.push_back(std::move(*made));
    }
    stats.programs += library_->programs_linked() - linked;
    if (!outcome) return outcome.error();
    groups_.push_back(std::move(group));
    return groups_.back().get();
}

Result<TerrainRenderer::Groups> TerrainRenderer::groups_for(const Mode& mode, gl::StageStats& stats) {
    Groups groups;
    const std::size_t there = groups_.size();
    for (const bool curved : {false, true}) {
        if (curved && !mode.phong) break;
        const ProgramChoice like{.phong = curved, .debug_view = mode.debug_view};
        const auto plain = group_of(key_of("plain", curved, mode.debug_view),
                                    choices_of_kinds(ProgramChoice::Detail::None, like), stats);
        if (!plain) return plain.error();
        groups.plain[curved ? 1 : 0] = *plain;
        if (counts_.detail_blocks == 0) continue;
        const auto detail = group_of(key_of("detail", curved, mode.debug_view),
                                     choices_of_kinds(ProgramChoice::Detail::Tiles, like), stats);
        if (!detail) return detail.error();
        groups.detail[curved ? 1 : 0] = *detail;
    }
    if (!mode.plan.empty()) {  // with the tile, not with the first block of it that is in sight
        std::vector<ProgramChoice> choices;
        for (const ReliefRecipe& recipe : mode.plan.recipes)
            for (const BlockKind kind : kReliefKinds)
                choices.push_back({.kind = kind,
                                   .detail = ProgramChoice::Detail::Relief,
                                   .recipe = recipe,
                                   .debug_view = mode.debug_view});
        const auto relief = group_of(key_of(mode.plan, mode.debug_view), choices, stats);
        if (!relief) return relief.error();
        groups.relief = *relief;
    }
    if (groups_.size() == there) return groups;
    if (const Result<void> made = make_flat(); !made) return made.error();
    for (std::size_t g = there; g < groups_.size(); ++g) draw_nothing(*groups_[g], stats);
    return groups;
}

Result<void> TerrainRenderer::make_flat() {
    if (flat_) return {};
    const bool bytes = map_.slopes == SlopeFormat::rg8;
    auto flat = gl::Texture2D::create(
        *device_, "flat detail", {.format = bytes ? gl::Format::Rg8 : gl::Format::Rg16F, .filter = gl::Filter::Linear});
    if (!flat) return flat.error();
    const std::uint8_t of_bytes[] = {128, 128}, of_halves[] = {0, 0, 0, 0};
    flat->upload(0, flat->bounds(), bytes ? of_bytes : of_halves);
    flat_ = std::move(*flat);
    return {};
}

void TerrainRenderer::draw_nothing(Group& group, gl::StageStats& stats) {
    // A block without size, by uniforms that are still 0: a point, no pixel, and a compiled program.
    const DrawnBlock nothing;
    block_buffer_.replace(std::as_bytes(std::span(&nothing, 1)));
    block_array_.bind();
    for (int unit = kDetailUnit; unit < kDetailUnit + 4; ++unit) flat_->bind(unit);
    for (TerrainProgram& made : group.programs) {
        made.program().bind();
        if (made.patches())
            draw_patches(0, 1, 1, stats);
        else
            draw_triangles(0, 1, stats);
    }
}

// ---- what to draw ----

void TerrainRenderer::choose_blocks(const Camera& camera, const HeightBounds& bounds, const DetailView* detail,
                                    const Mode& mode) {
    const DetailView* const there = detail != nullptr && !detail->empty() && detail->reach_m > 0 ? detail : nullptr;
    const ClipmapLayout layout = clipmap_layout(settings_, camera.eye_posts, last_post_.x, last_post_.z);
    ClipmapSettings settings = settings_;
    if (mode.phong) settings.refine_above_px = kNeverRefine;
    refinement_ = clipmap_refinement(settings, layout, camera, {map_.grid, map_.codec, map_.mirrored, bounds});
    drawn_ = drawn_blocks(layout, refinement_, last_post_.x, last_post_.z);

    struct Choice {
        DrawnBlock drawn;
        Run run;
        double distance = 0;
    };
    std::vector<Choice> choices;
    for (const DrawnBlock& drawn : drawn_.blocks) {
        const Run run = run_of(drawn, camera, bounds, there, mode);
        if (debug_.cull_blocks && !is_visible(drawn, camera, bounds, displaced_by(run, mode, there), mode)) {
            ++counts_.culled_blocks;
            continue;
        }
        const ClipmapBlock& b = drawn.block;
        const double unit = std::ldexp(1.0, b.level);
        choices.push_back({drawn, run,
                           std::max(std::abs((b.x + b.width * 0.5) * unit - camera.eye_posts.x),
                                    std::abs((b.z + b.depth * 0.5) * unit - camera.eye_posts.z))});
    }
    if (debug_.cull_blocks)
        std::erase_if(drawn_.stitches,
                      [&](const DrawnBlock& s) { return !is_visible(s, camera, bounds, nullptr, mode); });
    std::erase_if(drawn_.stitches, [&](const DrawnBlock& s) { return s.base_level == debug_.omit_stitches_of_level; });

    // Front to back: by the level of the surface; blocks of one kind together; then by the distance of a block's
    // middle.
    const auto order = [](const Choice& c) {
        return std::tuple(c.drawn.base_level, c.run.kind, c.run.detail, c.run.relief, c.distance);
    };
    std::stable_sort(choices.begin(), choices.end(),
                     [&](const Choice& a, const Choice& b) { return order(a) < order(b); });
    drawn_.blocks.clear();
    runs_.clear();
    for (const auto& [drawn, run, distance] : choices) {
        drawn_.blocks.push_back(drawn);
        if (runs_.empty() || !runs_.back().goes_on(run)) runs_.push_back(run);
        ++runs_.back().count;
        counts_.detail_blocks += run.detail != DetailSource::None && run.relief == 0;
        counts_.relief_blocks += run.relief != 0;
        counts_.refined_blocks += drawn.base_level != drawn.block.level;
    }
    counts_.blocks = static_cast<std::uint32_t>(drawn_.blocks.size());
    counts_.stitches = static_cast<std::uint32_t>(drawn_.stitches.size());
}

TerrainRenderer::Run TerrainRenderer::run_of(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds,
                                             const DetailView* detail, const Mode& mode) const {
    const BlockKind kind = kind_of(drawn, camera);
    if (detail == nullptr) return {kind};
    if (!mode.plan.empty() && drawn.base_level == 0)
        if (const std::size_t relief = relief_of(drawn, camera, bounds, *detail, mode.plan); relief != 0)
            return {kind, DetailSource::None, relief};
    const PostRect posts = posts_of(drawn.block);
    const DetailSource source = detail_source(*detail, posts.first, posts.last, map_.grid, camera);
    return {source == DetailSource::Window ? BlockKind::General : kind, source};
}

const DetailView* TerrainRenderer::displaced_by(const Run& run, const Mode& mode, const DetailView* detail) {
    return run.relief != 0 && mode.plan.recipes[run.relief - 1].displaces ? detail : nullptr;
}

std::size_t TerrainRenderer::relief_of(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds,
                                       const DetailView& detail, const BackendPlan& plan) const {
    const RelativeBox box = box_of(drawn, camera, coarse_codes(drawn, bounds));
    const auto nearest = [](double min, double max) { return std::max({min, -max, 0.0}); };
    const auto farthest = [](double min, double max) { return std::max(std::abs(min), std::abs(max)); };
    const double from_m =
        std::hypot(nearest(box.min.x, box.max.x), nearest(box.min.y, box.max.y), nearest(box.min.z, box.max.z));
    if (!(from_m < static_cast<double>(plan.all.to_m))) return 0;
    if (relief_codes(drawn.block, detail, texels_about(box, detail)) == CodeRange{kMidCode, kMidCode}) return 0;
    return 1 + plan.recipe_of(from_m, std::hypot(farthest(box.min.x, box.max.x), farthest(box.min.y, box.max.y),
                                                 farthest(box.min.z, box.max.z)));
}

CodeRange TerrainRenderer::relief_codes(const ClipmapBlock& block, const DetailView& detail, std::int32_t about) const {
    const auto [first, last] = posts_of(block);
    const std::int32_t per_post = texels_per_post(detail, map_.grid);
    const TexelRect texels =
        expanded({{first.x * per_post, first.z * per_post}, {last.x * per_post + 1, last.z * per_post + 1}}, about);
    return detail.relief->bounds->query(intersection(texels, detail.relief->square));
}

std::int32_t TerrainRenderer::texels_about(const RelativeBox& box, const DetailView& detail) const {
    const std::int32_t per_post = texels_per_post(detail, map_.grid);
    // Nodes about the block's outer posts reach beyond it.
    const std::int32_t nodes = std::max(ReliefWindow::kTopCells, per_post + (2 << mark_level(per_post)));
    // And so do rays: what stands before the block hides it as far as its height over the least slope of sight.
    const double highest_m =
        (static_cast<double>(detail.relief->extremes.max) - kMidCode) * detail.relief->code_quantum_m;
    const double across_m = std::hypot(std::max(-box.min.x, box.max.x), std::max(-box.min.z, box.max.z));
    const double above_m = std::max(-box.max.y, 1e-3);
    const double hidden = std::max(highest_m, 0.0) * across_m / above_m * per_post / map_.grid.spacing_m;
    return std::max(nodes, static_cast<std::int32_t>(std::min(hidden, kMostHidden)));
}

TerrainRenderer::PostRect TerrainRenderer::posts_of(const ClipmapBlock& b) const {
    return {{post_of(b.x, b.level, last_post_.x), post_of(b.z, b.level, last_post_.z)},
            {post_of(b.x + b.width, b.level, last_post_.x), post_of(b.z + b.depth, b.level, last_post_.z)}};
}

BlockKind TerrainRenderer::kind_of(const DrawnBlock& drawn, const Camera& camera) const {
    if (drawn.base_level != drawn.block.level) return BlockKind::Refined;
    if (drawn.base_level == settings_.levels - 1) return BlockKind::Own;
    // The farthest corner decides; half a unit more than the float's rounding of a distance below 2^10 units.
    const ClipmapBlock& b = drawn.block;
    const double unit = std::ldexp(1.0, b.level);
    const double farthest =
        std::max({std::abs(b.x - camera.eye_posts.x / unit), std::abs(b.x + b.width - camera.eye_posts.x / unit),
                  std::abs(b.z - camera.eye_posts.z / unit), std::abs(b.z + b.depth - camera.eye_posts.z / unit)});
    const float alpha = shared::morph_alpha(static_cast<float>(farthest) + 0.5f, settings_.n,
                                            shared::morph_zone_units(settings_.n, static_cast<float>(settings_.blend)));
    return alpha > 0 ? BlockKind::Morphing : BlockKind::Own;
}

CodeRange TerrainRenderer::coarse_codes(const DrawnBlock& drawn, const HeightBounds& bounds) const {
    const auto [first, last] = posts_of(drawn.block);
    // Refinement reads vertices of the surface about it, and morphing those of the next level about them.
    const std::int64_t margin = std::int64_t{4} << drawn.base_level;
    const auto clamped = [](std::int64_t p, std::int32_t end) {
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(p, 0, end));
    };
    PostRange x{clamped(first.x - margin, last_post_.x), clamped(last.x + margin, last_post_.x)};
    PostRange z{clamped(first.z - margin, last_post_.z), clamped(last.z + margin, last_post_.z)};
    if (map_.mirrored) {
        x = folded_range(x.min, x.max, map_.grid.width);
        z = folded_range(z.min, z.max, map_.grid.depth);
    }
    return bounds.query({{x.min, z.min}, {x.max + 1, z.max + 1}});
}

RelativeBox TerrainRenderer::box_of(const DrawnBlock& drawn, const Camera& camera, CodeRange codes) const {
    const auto [first, last] = posts_of(drawn.block);
    const auto height = [&](std::uint32_t code) {
        return (static_cast<double>(code) - 2147483648.0) * map_.codec.code_quantum_m() - camera.eye_y_m;
    };
    const double s = map_.grid.spacing_m;
    return {{first.x * s - camera.eye_x_m, height(codes.min), first.z * s - camera.eye_z_m},
            {last.x * s - camera.eye_x_m, height(codes.max), last.z * s - camera.eye_z_m}};
}

bool TerrainRenderer::is_visible(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds,
                                 const DetailView* relief, const Mode& mode) const {
    RelativeBox box = box_of(drawn, camera, coarse_codes(drawn, bounds));
    if (relief != nullptr) {
        const CodeRange moved = relief_codes(drawn.block, *relief, 1);
        const auto metres = [&](std::uint32_t code) {
            return (static_cast<double>(code) - 2147483648.0) * relief->relief->code_quantum_m;
        };
        box.min.y += std::min(metres(moved.min), 0.0);
        box.max.y += std::max(metres(moved.max), 0.0);
    }
    if (mode.phong) {
        // A curved triangle leaves its corners by a quarter of `shape` of what slopes differ by along its edges: at
        // most 2, say, on ground that is no cliff.
        const double bulge_m = 0.5 * mode.phong_shape * map_.grid.spacing_m * std::ldexp(1.0, drawn.block.level);
        box.min.y -= bulge_m, box.max.y += bulge_m;
    }
    return !is_culled(box, camera);
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

}  // namespace tilth
