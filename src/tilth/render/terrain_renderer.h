// Draws the ground: instanced draws of clipmap blocks, and of the stitches between their levels.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/objects.h"
#include "tilth/gl/shader_library.h"
#include "tilth/pool/height_planes.h"
#include "tilth/pool/slope_map.h"
#include "tilth/render/camera.h"
#include "tilth/render/clipmap_layout.h"
#include "tilth/render/clipmap_refinement.h"
#include "tilth/render/detail_blocks.h"
#include "tilth/render/detail_view.h"
#include "tilth/render/height_bounds.h"
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

/// Switches for tests and for finding faults; the defaults are right for everybody else.
struct RendererDebug {
    std::int32_t omit_stitches_of_level = -1;  ///< shows the cracks that the stitches close
    bool cull_blocks = true;                   ///< by the frustum
    bool cull_back_faces = true;               ///< ground seen from below; stitches are never culled
};

/// What the last `draw` drew.
struct RenderCounts {
    std::uint32_t blocks = 0, refined_blocks = 0, culled_blocks = 0, stitches = 0;
    std::uint32_t detail_blocks = 0;  ///< of `blocks`: those that sample a detail tile
};

/// Draws a map by a geometry clipmap (`clipmap_layout.h`), morphed, refined where the ground is rough
/// (`clipmap_refinement.h`) and without cracks, shaded per fragment.
///
/// One mesh of 33 x 33 vertices without a vertex buffer serves every block; the vertex shader reads the height planes.
/// Colours are linear RGB. Whether they are encoded is the host's choice and left as it is: with GL_FRAMEBUFFER_SRGB
/// enabled and an sRGB target GL encodes them, else they are stored as they are.
/// Cost: a draw for each level and kind of block and one for the stitches, at most (n / 32)^2 * levels blocks of 2 048
/// triangles (four times as many where all ground is rough), 24 bytes streamed for each. Thread: the one that owns the
/// context. GL state: the caller holds a `gl::StateGuard`; draws into the bound draw framebuffer, viewport (0, 0,
/// width, height), and sets every other state that it depends on. Clears nothing.
///
/// Fine detail shows as slopes that are added to the map's for shading, faded out by distance and by resolution
/// (`render/detail_slopes.glsl`), in programs of their own, which only the blocks take that lie in reach of the eye and
/// touch a tile that is there (`detail_blocks.h`); all others cost what they cost without. The four programs are made
/// in the first frame that needs one of them: a world that nobody dents never pays. They are made together, and each is
/// drawn with once at once, because drivers compile at the first draw (llvmpipe: some 0.3 s each cold, a few ms from
/// its disk cache), so that the frame of the first print carries it all and no frame of a walk across a tile's border
/// does. Measured on llvmpipe at 1280 x 720: detail in one tile adds 30 ns of CPU time a pixel in reach, on borders 70.
class TerrainRenderer {
public:
    /// Fails with InvalidArgument (settings, map) or ShaderCompile. `shaders` must outlive the renderer.
    static Result<TerrainRenderer> create(gl::Device& device, gl::ShaderLibrary& shaders,
                                          const ClipmapSettings& settings, const MapInfo& map);

    /// Draws one view. `planes`, `slopes` and `bounds` are those of the map. `detail`: nullptr or empty() adds nothing
    /// and costs nothing. Fails with InvalidArgument (a view out of range: nothing is drawn), Unsupported (reversed
    /// depth without GL_ARB_clip_control) or ShaderCompile (the detail programs: nothing is drawn; asked for again next
    /// time). Never waits.
    Result<void> draw(const View& view, const Shading& shading, const BrushCursor* cursor, const HeightPlanes& planes,
                      const SlopeMap& slopes, const HeightBounds& bounds, gl::StageStats& stats,
                      const DetailView* detail = nullptr);

    /// Reads the shaders again; each program that fails stays as it was, and the last error comes back.
    Result<void> reload(gl::ShaderLibrary& shaders);

    [[nodiscard]] RendererDebug& debug() { return debug_; }
    [[nodiscard]] const RenderCounts& last_counts() const { return counts_; }
    /// The blocks and stitches of the last `draw`, in the order in which they were drawn.
    [[nodiscard]] const DrawnBlocks& last_drawn() const { return drawn_; }
    [[nodiscard]] const ClipmapSettings& settings() const { return settings_; }
    /// The last post of the drawn world on each axis.
    [[nodiscard]] Texel last_post() const { return last_post_; }

private:
    /// What a block's vertices need; a program for each (`render/terrain.vert`). Stitches take the general one.
    enum class Kind { Own, Morphing, Refined, General };
    static constexpr std::size_t kKinds = 4;

    struct Uniforms {
        explicit Uniforms(gl::Program& program);
        gl::Uniform last_post, stored_posts, base_post, fraction_m, spacing_m, eye_code, eye_above_code_m,
            code_quantum_m, n, zone_units, coarsest_level, clip_from_relative, slopes_size_posts, slopes_last_level,
            node_grids, base_stored_post, eye_tint, to_light, ambient, diffuse, specular, specular_exponent, fog_colour,
            fog_density, low_colour, high_colour, steep_colour, cursor_m, cursor_colour;
        gl::Uniform detail_base_texels, detail_texels_per_m, detail_apron, detail_stored_size, detail_map_edge,
            detail_reach_m, detail_tile_texels, detail_window_texels;
    };
    struct Shader {
        gl::Program program;
        Uniforms uniforms;
    };
    /// Blocks that are drawn by one call.
    struct Run {
        Kind kind = Kind::Own;
        DetailSource detail = DetailSource::None;
        std::size_t count = 0;
    };
    static Result<std::vector<Shader>> make_shaders(gl::ShaderLibrary& shaders, const MapInfo& map, bool detail);
    TerrainRenderer(gl::Device& device, gl::ShaderLibrary& library, const ClipmapSettings& settings, const MapInfo& map,
                    std::vector<Shader> shaders_by_kind, gl::VertexArray block_array, gl::VertexArray stitch_array,
                    gl::Buffer indices, gl::Buffer blocks, gl::Buffer stitches, gl::TextureBuffer node_weights);
    [[nodiscard]] bool is_visible(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds) const;
    void choose_blocks(const Camera& camera, const HeightBounds& bounds, const DetailView* detail);
    [[nodiscard]] Run run_of(const DrawnBlock& drawn, const Camera& camera, const DetailView* detail) const;
    [[nodiscard]] Kind kind_of(const DrawnBlock& drawn, const Camera& camera) const;
    Result<void> make_detail_programs(gl::StageStats& stats);
    void set_state(const View& view);
    void set_uniforms(const Shader& shader, const Camera& camera, const Shading& shading, const BrushCursor* cursor,
                      const SlopeMap& slopes) const;
    /// Binds the tiles of `source` and says where they lie. The program is bound.
    void set_detail(const Shader& shader, const DetailView& detail, DetailSource source, const Camera& camera) const;

    gl::Device* device_;
    gl::ShaderLibrary* library_;
    ClipmapSettings settings_;
    MapInfo map_;
    Texel last_post_;
    std::vector<Shader> shaders_;         ///< by kind
    std::vector<Shader> detail_shaders_;  ///< by kind: of one tile, but the general one of a window. Empty until needed
    std::optional<gl::Texture2D> flat_;   ///< one texel, in the place of tiles that are missing; until needed: none
    gl::VertexArray block_array_, stitch_array_;
    gl::Buffer indices_, block_buffer_, stitch_buffer_;
    gl::TextureBuffer node_weights_;
    ClipmapRefinement refinement_;  ///< of the current draw
    DrawnBlocks drawn_;             ///< of the current draw
    std::vector<Run> runs_;         ///< of the current draw, in the order of the blocks
    RendererDebug debug_;
    RenderCounts counts_;
};

}  // namespace tilth
