// One program that draws blocks of ground, and everything that is set in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/objects.h"
#include "tilth/gl/shader_library.h"
#include "tilth/pool/slope_map.h"
#include "tilth/render/backends/backend_plan.h"
#include "tilth/render/camera.h"
#include "tilth/render/clipmap_refinement.h"
#include "tilth/render/detail_blocks.h"
#include "tilth/render/detail_view.h"
#include "tilth/render/view.h"
#include "tilth/world/grid.h"
#include "tilth/world/height_codec.h"

namespace tilth {

/// The map that is drawn.
struct MapInfo {
    GridSpec grid;  ///< of the stored map: width and depth are those of the planes
    HeightCodec codec;
    HeightPrecision precision = HeightPrecision::bits32;
    SlopeFormat slopes = SlopeFormat::rg8;
    bool mirrored = false;  ///< the map is repeated by reflection to 2^20 x 2^20 posts
};

/// What a block's vertices need (`render/terrain.vert`). Stitches take the general one.
enum class BlockKind : std::uint8_t { Own, Morphing, Refined, General };

/// Texture units: 8 and up are the host's (`render/shade.glsl`).
inline constexpr int kHighUnit = 0, kLowUnit = 1, kSlopeUnit = 2, kNodeUnit = 3;
inline constexpr int kDetailUnit = 4;  ///< and the three after it: tiles, or the relief window's textures

/// What a program is made from.
struct ProgramChoice {
    enum class Detail : std::uint8_t { None, Tiles, Relief };
    BlockKind kind = BlockKind::General;
    Detail detail = Detail::None;
    ReliefRecipe recipe;  ///< with Relief
    bool phong = false;
    bool debug_view = false;
};

/// What a frame sets in every program.
struct ProgramFrame {
    const MapInfo& map;
    const ClipmapSettings& clipmap;
    Texel last_post;
    const Camera& camera;
    const Shading& shading;
    const BrushCursor* cursor = nullptr;
    const SlopeMap& slopes;
    const ClipmapRefinement& refinement;
    const DetailSettings& settings;
    const DetailView* detail = nullptr;  ///< for debug views
};

/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class TerrainProgram {
public:
    /// Fails with ShaderCompile or Unsupported.
    static Result<TerrainProgram> create(gl::ShaderLibrary& shaders, const MapInfo& map, const ProgramChoice& choice);

    [[nodiscard]] gl::Program& program() { return program_; }
    [[nodiscard]] bool patches() const { return patches_; }

    // The program is bound.
    void set_frame(const ProgramFrame& frame) const;
    /// Binds the tiles of `source` and says where they lie; `flat` in the place of tiles that are missing.
    void set_tiles(const ProgramFrame& frame, const DetailView& detail, DetailSource source,
                   const gl::Texture2D& flat) const;
    /// Says where the relief window lies, and the backends' knobs.
    void set_relief(const ProgramFrame& frame, const DetailView& detail, const BackendPlan& plan) const;
    void bind_relief(const DetailView& detail) const;

private:
    TerrainProgram(gl::Program program, const ProgramChoice& choice);
    void set_debug_view(const ProgramFrame& frame) const;

    struct Uniforms {
        explicit Uniforms(gl::Program& program);
        gl::Uniform last_post, stored_posts, base_post, fraction_m, spacing_m, eye_code, eye_above_code_m,
            code_quantum_m, n, zone_units, coarsest_level, clip_from_relative, slopes_size_posts, slopes_last_level,
            node_grids, base_stored_post, eye_tint, to_light, ambient, diffuse, specular, specular_exponent, fog_colour,
            fog_density, low_colour, high_colour, steep_colour, cursor_m, cursor_colour;
        gl::Uniform detail_base_texels, detail_texels_per_m, detail_apron, detail_stored_size, detail_map_edge,
            detail_reach_m, detail_tile_texels, detail_window_texels;
        gl::Uniform relief_size, relief_base_texel, relief_per_post, relief_texels_per_m, relief_fade_m,
            relief_mark_level, relief_slopes_size, relief_extremes_m;
        gl::Uniform parallax_steps, parallax_shadow_steps, parallax_range_m, parallax_least_tangent;
        gl::Uniform refine_factor_most, refine_edge_px, refine_px_per_radian, refine_chain;
        gl::Uniform phong_px_per_radian, phong_shape, phong_factor_most, phong_edge_px, phong_first_level;
        gl::Uniform debug_view, debug_base_tile, debug_tile;
    };
    gl::Program program_;
    Uniforms uniforms_;
    bool patches_ = false;
};

}  // namespace tilth
