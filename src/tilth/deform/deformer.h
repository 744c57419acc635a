// The GPU executor: stamps applied by passes over their rectangles.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/deform/stamp_batches.h"
#include "tilth/deform/weight_atlas.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/texel_pass.h"
#include "tilth/gl/texture_copy.h"
#include "tilth/ground/prepared_stamp.h"
#include "tilth/pool/height_planes.h"

namespace tilth {

/// A stamp for the GPU. `may_saturate` costs a pass of its own, in which the saturated texels are counted; leave it
/// false when the bounds of the ground under the stamp rule it out.
struct DeformStamp {
    PreparedStamp prepared;
    bool may_saturate = false;
};

/// Planes that stamps go to: a map's, or one tile's.
struct DeformTarget {
    HeightPlanes* planes = nullptr;
    /// Texels of the map whose saturation is counted here. A texel that several tiles hold counts once: give each
    /// tile its interior.
    TexelRect counted;
};

/// Writes stamps into height planes.
///
/// A pass draws the texels of its stamps into a scratch pair, reading the planes, and copies them back; no texel is
/// read and written by the same draw, nothing outside the stamps' rectangles is touched. Stamps whose rules read their
/// own texel only share passes (`plan_batches`); smooth is a pass of its own. The arithmetic is
/// shaders/shared/stamp_math.glsl, which the CPU executor compiles as C++: both leave the same bits.
/// Stamps across tiles: each tile's part of the rectangle, apron included, lies beside the others in the scratch, so
/// that all tiles share one framebuffer and one set-up, with one draw a tile. The scratch grows to the largest pass
/// seen, at most about one tile (or 1 024 x 1 024 texels); beyond that the parts go into several passes. Programs are
/// compiled at first use, one for each combination of what a pass holds. Thread: the one that owns the context. GL
/// state: the caller holds a `gl::StateGuard`.
class Deformer {
public:
    static Result<Deformer> create(gl::Device& device, gl::ShaderLibrary& shaders);

    /// Applies `stamps` in order to each of `targets`, which differ, are of one map and of one precision: to all the
    /// texels of the map that the target holds. Never waits for the GPU. Counts passes, draws, texels, bytes, programs.
    /// Smooth reads what the target holds, its outermost texels repeated: the outer ring of an apron is then wrong, and
    /// the caller copies the apron from the tiles that own it before anything else is applied.
    /// Fails with ShaderCompile, OutOfMemory, or Unsupported (stamp images that exceed the largest texture); then the
    /// first `applied` stamps are in the planes, wholly, and the rest has not begun; Unsupported is about the next one.
    Result<void> apply(std::span<const DeformStamp> stamps, std::span<const DeformTarget> targets,
                       gl::StageStats& stats, std::size_t& applied);
    /// To one map.
    Result<void> apply(std::span<const DeformStamp> stamps, HeightPlanes& planes, gl::StageStats& stats,
                       std::size_t& applied) {
        const DeformTarget target{&planes, planes.held()};
        return apply(stamps, {&target, 1}, stats, applied);
    }
    Result<void> apply(std::span<const DeformStamp> stamps, HeightPlanes& planes, gl::StageStats& stats) {
        std::size_t applied = 0;
        return apply(stamps, planes, stats, applied);
    }

    /// Reads the shaders of all passes made so far again; each that fails keeps its last good program.
    Result<void> reload();

    /// Adds the saturated texels whose counts have arrived. Never waits.
    void collect(gl::StageStats& stats);
    /// Waits for all counts.
    void finish(gl::StageStats& stats);

    [[nodiscard]] std::uint64_t bytes() const;

private:
    struct Variant {
        bool bits16 = false, profiles = false, images = false, only_add = false, one_stamp = false, smooth = false,
             count = false;
        auto operator<=>(const Variant&) const = default;
    };
    Deformer(gl::Device& device, gl::ShaderLibrary& shaders, gl::TextureCopy copy);

    /// What is drawn at once: rectangles of the scratch for one target.
    struct TargetDraw {
        const HeightPlanes* planes = nullptr;
        std::vector<gl::PassRect> rects;
    };
    using ScratchPass = std::vector<TargetDraw>;
    struct ScratchPlan {
        std::vector<ScratchPass> passes;
        std::int32_t width = 0, depth = 0;  ///< that the scratch must have
    };
    enum class Part { Whole, Counted };
    static ScratchPlan plan(const StampBatch& batch, std::span<const DeformTarget> targets, Part part);

    /// `list`: the stamps of the batch as the shader reads them, their weights in the atlas.
    Result<void> run(const StampBatch& batch, std::span<const DeformStamp> stamps, std::span<const StampParams> list,
                     std::span<const DeformTarget> targets, gl::StageStats& stats);
    Result<void> upload_lists(std::span<const StampParams> list, const StampBatch& batch, gl::StageStats& stats);
    Result<void> reserve_scratch(std::int32_t width, std::int32_t height, std::size_t planes);
    Result<gl::TexelPass*> pass_for(const Variant& variant, gl::StageStats& stats);
    /// `list`: of one stamp.
    Result<void> count_saturated(Variant variant, std::span<const StampParams> list, const ScratchPlan& parts,
                                 gl::StageStats& stats);
    Result<void> draw(const Variant& variant, std::span<const StampParams> list, const ScratchPass& parts,
                      gl::StageStats& stats);
    void copy_back(const ScratchPass& parts);

    gl::Device* device_;
    gl::ShaderLibrary* shaders_;
    gl::TextureCopy copy_;
    WeightAtlas atlas_;
    std::vector<gl::Texture2D> scratch_;  ///< as many as the maps have planes
    std::optional<gl::TextureBuffer> stamps_, order_;
    std::map<Variant, std::unique_ptr<gl::TexelPass>> passes_;
    std::vector<gl::Query> counting_;
};

}  // namespace tilth
