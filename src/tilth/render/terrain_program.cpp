#include "tilth/render/terrain_program.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tilth/core/checks.h"
#include "tilth/core/shared_glsl.h"
#include "tilth/render/backends/refinement_chain.h"
#include "tilth/render/relief_reach.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {
namespace {

enum ReliefUnit { kReliefHeights = kDetailUnit, kReliefSlopes, kReliefPyramid, kReliefRange };

Vec3f normalised(const Vec3f& v) {
    const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return length > 0 ? Vec3f{v.x / length, v.y / length, v.z / length} : Vec3f{0, 1, 0};
}

void set(const gl::Program& program, gl::Uniform uniform, const Vec3f& v) { program.set(uniform, v.x, v.y, v.z); }

/// The base post on the stored map: itself, or within one period of the reflection.
std::int32_t stored_base(std::int32_t base, std::int32_t posts, bool mirrored) {
    const std::int32_t period = 2 * (posts - 1);
    return mirrored ? ((base % period) + period) % period : base;
}

gl::Features features_of(const MapInfo& map, const ProgramChoice& choice) {
    gl::Features features;
    const auto add = [&](bool wanted, const char* name) {
        if (wanted) features.emplace_back(name, "1");
    };
    add(map.precision == HeightPrecision::bits16, "BITS16");
    add(map.mirrored, "MIRRORED");
    add(map.slopes == SlopeFormat::rg16f, "SLOPES_RG16F");
    add(choice.detail != ProgramChoice::Detail::None, "DETAIL");
    add(choice.detail == ProgramChoice::Detail::Relief, "RELIEF");
    add(choice.detail == ProgramChoice::Detail::Tiles && choice.kind == BlockKind::General, "DETAIL_WINDOW");
    add(choice.kind == BlockKind::Own, "ALL_OWN");
    add(choice.kind == BlockKind::Morphing, "ALL_MORPHING");
    add(choice.kind == BlockKind::Refined, "ALL_REFINED");
    add(choice.phong, "PHONG");
    add(choice.debug_view, "DEBUG_VIEW");
    features.insert(features.end(), choice.recipe.features.begin(), choice.recipe.features.end());
    return features;
}

const char* label_of(const ProgramChoice& choice) {
    switch (choice.detail) {
        case ProgramChoice::Detail::None:
            return "terrain";
        case ProgramChoice::Detail::Tiles:
            return "terrain with detail";
        case ProgramChoice::Detail::Relief:
            return choice.recipe.name;
    }
    return "";
}

}  // namespace

Result<TerrainProgram> TerrainProgram::create(gl::ShaderLibrary& shaders, const MapInfo& map,
                                              const ProgramChoice& choice) {
    gl::ProgramOptions stages = choice.recipe.stages;
    if (choice.phong) {
        stages.tess_control = "render/phong/phong.tesc";
        stages.tess_evaluation = "render/phong/phong.tese";
    }
    Result<gl::Program> program = shaders.program(label_of(choice), "render/terrain.vert", "render/terrain.frag",
                                                  features_of(map, choice), stages);
    if (!program) return program.error();
    program->sampler("u_high_plane", kHighUnit);
    program->sampler("u_low_plane", kLowUnit);
    program->sampler("u_slopes", kSlopeUnit);
    program->sampler("u_node_weights", kNodeUnit);
    if (choice.detail == ProgramChoice::Detail::Tiles) {
        int unit = kDetailUnit;
        for (const char* const tile : {"u_detail", "u_detail_x", "u_detail_z", "u_detail_xz"})
            program->sampler(tile, unit++);
    } else if (choice.detail == ProgramChoice::Detail::Relief) {
        program->sampler("u_relief_heights", kReliefHeights);
        program->sampler("u_relief_slopes", kReliefSlopes);
        program->sampler("u_relief_pyramid", kReliefPyramid);
        program->sampler("u_relief_range", kReliefRange);
    }
    return TerrainProgram(std::move(*program), choice);
}

TerrainProgram::TerrainProgram(gl::Program program, const ProgramChoice& choice)
    : program_(std::move(program)), uniforms_(program_), patches_(choice.phong || choice.recipe.patches) {}

TerrainProgram::Uniforms::Uniforms(gl::Program& program)
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
      detail_window_texels(program.uniform("u_detail_window_texels")),
      relief_size(program.uniform("u_relief_size")),
      relief_base_texel(program.uniform("u_relief_base_texel")),
      relief_per_post(program.uniform("u_relief_per_post")),
      relief_texels_per_m(program.uniform("u_relief_texels_per_m")),
      relief_fade_m(program.uniform("u_relief_fade_m")),
      relief_mark_level(program.uniform("u_relief_mark_level")),
      relief_slopes_size(program.uniform("u_relief_slopes_size")),
      relief_extremes_m(program.uniform("u_relief_extremes_m")),
      parallax_steps(program.uniform("u_parallax_steps")),
      parallax_shadow_steps(program.uniform("u_parallax_shadow_steps")),
      parallax_range_m(program.uniform("u_parallax_range_m")),
      parallax_least_tangent(program.uniform("u_parallax_least_tangent")),
      refine_factor_most(program.uniform("u_refine_factor_most")),
      refine_edge_px(program.uniform("u_refine_edge_px")),
      refine_px_per_radian(program.uniform("u_refine_px_per_radian")),
      refine_chain(program.uniform("u_refine_chain")),
      phong_px_per_radian(program.uniform("u_phong_px_per_radian")),
      phong_shape(program.uniform("u_phong_shape")),
      phong_factor_most(program.uniform("u_phong_factor_most")),
      phong_edge_px(program.uniform("u_phong_edge_px")),
      phong_first_level(program.uniform("u_phong_first_level")),
      debug_view(program.uniform("u_debug_view")),
      debug_base_tile(program.uniform("u_debug_base_tile")),
      debug_tile(program.uniform("u_debug_tile")) {}

void TerrainProgram::set_frame(const ProgramFrame& frame) const {
    const gl::Program& program = program_;
    const Uniforms& u = uniforms_;
    const Camera& camera = frame.camera;
    const Shading& shading = frame.shading;
    const GridSpec& grid = frame.map.grid;
    const auto f = [](double value) { return static_cast<float>(value); };
    program.set(u.last_post, frame.last_post.x, frame.last_post.z);
    program.set(u.stored_posts, grid.width, grid.depth);
    program.set(u.base_post, camera.base_x, camera.base_z);
    program.set(u.fraction_m, camera.fraction_x_m, camera.fraction_z_m);
    program.set(u.spacing_m, f(grid.spacing_m));
    program.set(u.eye_code, camera.eye_code);
    program.set(u.eye_above_code_m, camera.eye_above_code_m);
    program.set(u.code_quantum_m, f(frame.map.codec.code_quantum_m()));
    program.set(u.n, frame.clipmap.n);
    program.set(u.zone_units, shared::morph_zone_units(frame.clipmap.n, f(frame.clipmap.blend)));
    program.set(u.coarsest_level, frame.clipmap.levels - 1);
    program.set_mat4(u.clip_from_relative, camera.clip_from_relative.data());
    program.set(u.slopes_size_posts, f(frame.slopes.padded_width()), f(frame.slopes.padded_depth()));
    program.set(u.slopes_last_level, frame.slopes.texture().levels() - 1);
    program.set(u.base_stored_post, f(stored_base(camera.base_x, grid.width, frame.map.mirrored)),
                f(stored_base(camera.base_z, grid.depth, frame.map.mirrored)));

    std::vector<std::int32_t> grids;
    for (const NodeGrid& nodes : frame.refinement.grids)
        for (const std::int32_t value : {nodes.min_x, nodes.min_z, nodes.width, nodes.first}) grids.push_back(value);
    program.set_ivec4s(u.node_grids, grids);

    const double tint_span = std::max(shading.tint_high_m - shading.tint_low_m, 1.0);
    program.set(u.eye_tint, f(1 / tint_span),
                f((camera.eye_y_m + frame.map.codec.middle_m - shading.tint_low_m) / tint_span));
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
    if (const BrushCursor* const cursor = frame.cursor; cursor != nullptr && cursor->radius_m > 0) {
        program.set(u.cursor_m, f(cursor->centre.x - grid.origin.x - camera.eye_x_m),
                    f(cursor->centre.z - grid.origin.z - camera.eye_z_m), f(cursor->radius_m));
        set(program, u.cursor_colour, cursor->colour);
    } else {
        program.set(u.cursor_m, 0.0f, 0.0f, 0.0f);
    }
    program.set(u.phong_shape, f(frame.settings.phong.shape));
    program.set(u.phong_factor_most, frame.settings.phong.most_factor);
    program.set(u.phong_edge_px, f(frame.settings.phong.edge_px));
    // Ground of the finest level that shows relief is not curved, nor what meets it.
    program.set(u.phong_first_level, frame.settings.backend == DetailBackend::None ? 0 : 1);
    program.set(u.phong_px_per_radian, f(camera.pixels_per_radian));
    program.set(u.refine_px_per_radian, f(camera.pixels_per_radian));
    if (frame.settings.debug_view != DebugView::Off) set_debug_view(frame);
}

void TerrainProgram::set_debug_view(const ProgramFrame& frame) const {
    const gl::Program& program = program_;
    program.set(uniforms_.debug_view, static_cast<int>(frame.settings.debug_view));
    if (frame.detail == nullptr || !(frame.detail->spacing_m > 0)) {
        program.set(uniforms_.debug_base_tile, 0, 0);
        program.set(uniforms_.debug_tile, 0.0f, 0.0f, 0.0f);
        return;
    }
    const std::int64_t per_post = texels_per_post(*frame.detail, frame.map.grid);
    const std::int32_t size = frame.detail->grid.size;
    const auto tiles = [&](std::int32_t post) { return static_cast<double>(post * per_post) / size; };
    const double x = tiles(frame.camera.base_x), z = tiles(frame.camera.base_z);
    program.set(uniforms_.debug_base_tile, static_cast<int>(std::floor(x)), static_cast<int>(std::floor(z)));
    program.set(uniforms_.debug_tile, static_cast<float>(x - std::floor(x)), static_cast<float>(z - std::floor(z)),
                static_cast<float>(1 / (frame.detail->spacing_m * size)));
}

void TerrainProgram::set_tiles(const ProgramFrame& frame, const DetailView& detail, DetailSource source,
                               const gl::Texture2D& flat) const {
    TileIndex origin = detail.window.min;
    const auto bind = [&](std::size_t slot, int unit) {
        const gl::Texture2D* const tile = detail.slopes[slot];
        TILTH_EXPECTS(
            tile == nullptr || (tile->width() == detail.grid.stored_size() &&
                                tile->height() == detail.grid.stored_size() && tile->format() == flat.format()),
            "a detail tile's slopes are stored_size texels a side, in the format of the map's slopes");
        (tile != nullptr ? *tile : flat).bind(unit);
    };
    if (source == DetailSource::Window) {
        for (std::size_t slot = 0; slot < 4; ++slot) bind(slot, kDetailUnit + static_cast<int>(slot));
    } else {
        const auto slot = static_cast<std::size_t>(source) - static_cast<std::size_t>(DetailSource::Slot0);
        bind(slot, kDetailUnit);
        origin.x += static_cast<std::int32_t>(slot % 2), origin.z += static_cast<std::int32_t>(slot / 2);
    }
    const gl::Program& program = program_;
    const Uniforms& u = uniforms_;
    const auto f = [](auto value) { return static_cast<float>(value); };
    const DetailPlacement at = detail_placement(detail, origin, frame.map.grid, frame.camera);
    program.set(u.detail_base_texels, at.base_x, at.base_z);
    program.set(u.detail_map_edge, at.map_edge[0], at.map_edge[1], at.map_edge[2], at.map_edge[3]);
    program.set(u.detail_texels_per_m, f(texels_per_post(detail, frame.map.grid) / frame.map.grid.spacing_m));
    program.set(u.detail_apron, f(detail.grid.apron));
    program.set(u.detail_stored_size, f(detail.grid.stored_size()));
    program.set(u.detail_reach_m, f(detail.reach_m));
    program.set(u.detail_tile_texels, f(detail.grid.size));
    program.set(u.detail_window_texels, f(detail.window.columns() * detail.grid.size),
                f(detail.window.rows() * detail.grid.size));
}

void TerrainProgram::bind_relief(const DetailView& detail) const {
    const ReliefWindow& window = *detail.relief->window;
    window.heights().bind(kReliefHeights);
    window.slopes().bind(kReliefSlopes);
    window.pyramid().bind(kReliefPyramid);
    window.range().bind(kReliefRange);
}

void TerrainProgram::set_relief(const ProgramFrame& frame, const DetailView& detail, const BackendPlan& plan) const {
    const ReliefWindow& window = *detail.relief->window;
    TILTH_EXPECTS(window.format() == frame.map.slopes, "the relief window's slopes are in the format of the map's");
    const gl::Program& program = program_;
    const Uniforms& u = uniforms_;
    const auto f = [](auto value) { return static_cast<float>(value); };
    const std::int32_t per_post = texels_per_post(detail, frame.map.grid), size = window.size();
    const auto wrapped = [&](std::int32_t post) {
        const std::int64_t texel = std::int64_t{post} * per_post;
        return static_cast<std::int32_t>(texel & (size - 1));  // a power of two: the remainder, also of negatives
    };
    const std::int32_t base_x = wrapped(frame.camera.base_x), base_z = wrapped(frame.camera.base_z);
    const double texels_per_m = per_post / frame.map.grid.spacing_m;
    program.set(u.relief_size, size);
    program.set(u.relief_base_texel, base_x, base_z);
    program.set(u.relief_per_post, per_post);
    program.set(u.relief_texels_per_m, f(texels_per_m));
    program.set(u.relief_fade_m, plan.displaced.from_m, plan.displaced.to_m, plan.all.from_m, plan.all.to_m);
    program.set(u.relief_mark_level, mark_level(per_post));
    program.set(u.relief_slopes_size, f(size));
    const auto metres = [&](std::uint32_t code) {
        return f((static_cast<double>(code) - kMidCode) * detail.relief->code_quantum_m);
    };
    program.set(u.relief_extremes_m, metres(detail.relief->extremes.max), metres(detail.relief->extremes.min));
    program.set(u.detail_base_texels, f(base_x), f(base_z));
    program.set(u.detail_texels_per_m, f(texels_per_m));
    program.set(u.detail_reach_m, f(detail.reach_m));

    const ParallaxSettings& parallax = frame.settings.parallax;
    program.set(u.parallax_steps, parallax.steps);
    program.set(u.parallax_shadow_steps, parallax.shadow_steps);
    program.set(u.parallax_least_tangent, f(std::tan(parallax.least_elevation_rad)));
    if (parallax.range) program.set(u.parallax_range_m, f(parallax.range->highest_m), f(parallax.range->lowest_m));

    const RefinementSettings& refinement = frame.settings.refinement;
    program.set(u.refine_factor_most, std::min(refinement.most_factor, per_post));
    program.set(u.refine_edge_px, f(refinement.edge_px));
    const std::vector<std::int32_t> chain = refinement_chain(per_post, refinement.most_factor);
    program.set_ivec4s(u.refine_chain, refinement_uniform(chain));
}

}  // namespace tilth
