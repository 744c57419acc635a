// Draws the ground: instanced draws of clipmap blocks, and of the stitches between their levels.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
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
#include "tilth/render/terrain_program.h"
#include "tilth/render/view.h"
#include "tilth/world/grid.h"
#include "tilth/world/height_codec.h"

namespace tilth {

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
    std::uint32_t relief_blocks = 0;  ///< of `blocks`: those that a detail backend draws
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
///
/// With a detail backend (`DetailSettings`) blocks of the finest level that have detail in them, within its reach, are
/// drawn by the backend's programs (`render/backends/`), from the relief window; everything else as before. Programs
/// of a backend are made when it first draws and kept, so that switching back and forth costs nothing.
class TerrainRenderer {
public:
    /// Fails with InvalidArgument (settings, map) or ShaderCompile. `shaders` must outlive the renderer.
    static Result<TerrainRenderer> create(gl::Device& device, gl::ShaderLibrary& shaders,
                                          const ClipmapSettings& settings, const MapInfo& map);

    /// Draws one view. `planes`, `slopes` and `bounds` are those of the map. `detail`: nullptr or empty() adds nothing
    /// and costs nothing; its settings are checked (`check_detail`). Fails with InvalidArgument (a view out of range:
    /// nothing is drawn), Unsupported (reversed depth without GL_ARB_clip_control, tessellation without GL 4.0) or
    /// ShaderCompile (programs that were not needed before: nothing is drawn; asked for again next time). Never waits.
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
    /// Programs that are made together, since each may be needed in any frame.
    struct Group {
        std::string key;
        std::vector<TerrainProgram> programs;
    };
    /// Blocks that are drawn by one call.
    struct Run {
        BlockKind kind = BlockKind::Own;
        DetailSource detail = DetailSource::None;
        std::size_t relief = 0;  ///< 0: none; else the plan's recipe, from 1 on
        std::size_t count = 0;
        [[nodiscard]] bool goes_on(const Run& other) const {
            return kind == other.kind && detail == other.detail && relief == other.relief;
        }
    };
    /// What a draw takes from the settings.
    struct Mode {
        BackendPlan plan;
        bool phong = false, debug_view = false;
        double phong_shape = 0;
    };
    /// What the blocks of a draw need; nullptr where they do not. [1]: curved by Phong tessellation.
    struct Groups {
        std::array<Group*, 2> plain{}, detail{};
        Group* relief = nullptr;  ///< by recipe, and of each by kind: Own, Morphing
    };
    /// First and last post of a block.
    struct PostRect {
        Texel first, last;
    };
    TerrainRenderer(gl::Device& device, gl::ShaderLibrary& library, const ClipmapSettings& settings, const MapInfo& map,
                    gl::VertexArray block_array, gl::VertexArray stitch_array, gl::Buffer indices, gl::Buffer blocks,
                    gl::Buffer stitches, gl::TextureBuffer node_weights);
    [[nodiscard]] Mode mode_of(const View& view, const DetailView* detail) const;
    void choose_blocks(const Camera& camera, const HeightBounds& bounds, const DetailView* detail, const Mode& mode);
    [[nodiscard]] Run run_of(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds,
                             const DetailView* detail, const Mode& mode) const;
    /// 1 + the recipe that draws a block; 0 where no relief is to be seen.
    [[nodiscard]] std::size_t relief_of(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds,
                                        const DetailView& detail, const BackendPlan& plan) const;
    [[nodiscard]] BlockKind kind_of(const DrawnBlock& drawn, const Camera& camera) const;
    [[nodiscard]] PostRect posts_of(const ClipmapBlock& block) const;
    /// Codes that a block's vertices may stand at, on the coarse ground.
    [[nodiscard]] CodeRange coarse_codes(const DrawnBlock& drawn, const HeightBounds& bounds) const;
    /// Codes of the detail in a block and `about` texels about it.
    [[nodiscard]] CodeRange relief_codes(const ClipmapBlock& block, const DetailView& detail, std::int32_t about) const;
    /// How many texels about a block decide whether relief is seen in it.
    [[nodiscard]] std::int32_t texels_about(const RelativeBox& box, const DetailView& detail) const;
    /// What moves the surface of a run's blocks; nullptr: nothing.
    static const DetailView* displaced_by(const Run& run, const Mode& mode, const DetailView* detail);
    /// A block whose vertices stand between `codes`, metres from the eye.
    [[nodiscard]] RelativeBox box_of(const DrawnBlock& drawn, const Camera& camera, CodeRange codes) const;
    /// `relief`: what may move the block's surface; nullptr: nothing.
    [[nodiscard]] bool is_visible(const DrawnBlock& drawn, const Camera& camera, const HeightBounds& bounds,
                                  const DetailView* relief, const Mode& mode) const;

    /// Made if it is not there yet.
    Result<Group*> group_of(const std::string& key, std::span<const ProgramChoice> choices, gl::StageStats& stats);
    Result<Groups> groups_for(const Mode& mode, gl::StageStats& stats);
    Result<void> make_flat();
    /// So that drivers compile now.
    void draw_nothing(Group& group, gl::StageStats& stats);
    /// `curved`: by Phong tessellation.
    static TerrainProgram& program_of(const Run& run, const Groups& groups, bool curved);
    void draw_triangles(std::size_t first, std::size_t count, gl::StageStats& stats);
    /// In many small draws; edges are split in at most `factor` parts.
    void draw_patches(std::size_t first, std::size_t count, std::int32_t factor, gl::StageStats& stats);
    void set_state(const View& view);

    gl::Device* device_;
    gl::ShaderLibrary* library_;
    ClipmapSettings settings_;
    MapInfo map_;
    Texel last_post_;
    std::vector<std::unique_ptr<Group>> groups_;
    std::optional<gl::Texture2D> flat_;  ///< one texel, in the place of tiles that are missing; until needed: none
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
