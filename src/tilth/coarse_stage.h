// The facade's side of the coarse map: planes, slopes and bounds, and the edits that change them.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/deform/deformer.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/ground/change_set.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/stamp_range.h"
#include "tilth/ground/undo_history.h"
#include "tilth/pool/height_planes.h"
#include "tilth/pool/slope_map.h"
#include "tilth/render/height_bounds.h"
#include "tilth/terrain.h"

namespace tilth {

/// The coarse map of a terrain that draws: dense, wholly resident. With executor gpu the planes are ahead of the
/// ground's codes until `read_back`.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`.
class CoarseStage {
public:
    /// Uploads the ground's codes and derives all slopes. `executor` is not `Automatic`.
    static Result<std::unique_ptr<CoarseStage>> create(gl::Device& device, gl::ShaderLibrary& shaders, Ground& ground,
                                                       const TerrainSettings& settings, ExecutorKind executor,
                                                       gl::FrameStats& stats);

    /// Applies edits of the coarse map in order, then slopes and mips over what changed. Undo, and what the GPU
    /// refuses, is done by the CPU, waits where the GPU is ahead, and counts as a fallback there. Fails with the GPU's
    /// error; every edit is applied all the same.
    Result<void> apply(std::span<const GroundEdit> edits, gl::FrameStats& stats);
    /// The ground's codes become those of the planes. Waits.
    void read_back(gl::FrameStats& stats);
    [[nodiscard]] bool is_ahead() const { return !newer_.empty(); }
    /// Counts of saturated texels that have arrived by now.
    void collect(gl::StageStats& deform) {
        if (deformer_) deformer_->collect(deform);
    }
    Result<void> reload(gl::ShaderLibrary& shaders);
    /// What the last `apply` changed goes here, if anywhere.
    void publish_to(ChangeSet* changes) { changes_ = changes; }

    /// With executor gpu, shared with the detail map; else nullptr.
    [[nodiscard]] Deformer* deformer() { return deformer_ ? &*deformer_ : nullptr; }
    [[nodiscard]] const HeightPlanes& planes() const { return *planes_; }
    [[nodiscard]] const SlopeMap& slopes() const { return *slopes_; }
    [[nodiscard]] const HeightBounds& bounds() const { return bounds_; }

private:
    CoarseStage(gl::Device& device, Ground& ground, const TerrainSettings& settings)
        : device_(device), ground_(ground), settings_(settings), bounds_(ground.coarse()) {}

    [[nodiscard]] SlopeSettings slope_settings() const;
    [[nodiscard]] const MapGeometry& map() const { return ground_.map(MapKind::Coarse); }
    [[nodiscard]] StampRange range_of(const PreparedStamp& stamp) const;
    void note_change(const GroundEdit& edit, bool ahead);
    void look_before_saturating(std::span<const GroundEdit> edits, gl::FrameStats& stats);
    void queue(const GroundEdit& edit, gl::FrameStats& stats);
    void draw(gl::FrameStats& stats);
    void apply_on_cpu(const GroundEdit& edit, gl::FrameStats& stats);
    void upload(gl::FrameStats& stats);
    void derive(gl::FrameStats& stats);

    gl::Device& device_;
    Ground& ground_;
    const TerrainSettings& settings_;
    std::optional<HeightPlanes> planes_;
    std::optional<Deformer> deformer_;     ///< executor gpu only
    std::optional<SlopePass> slope_pass_;  ///< executor gpu only
    std::optional<SlopeMap> slopes_;
    HeightBounds bounds_;
    std::vector<TexelRect> newer_;  ///< where the ground's codes are out of date
    // While edits are applied:
    std::vector<DeformStamp> batch_;  ///< stamps that the GPU has not been given yet
    std::vector<GroundEdit> placed_;  ///< their edits
    std::vector<TexelRect> stale_;    ///< where the planes are behind the ground's codes
    std::vector<TexelRect> changed_;  ///< of this call: where slopes are out of date
    Result<void> outcome_;
    ChangeSet* changes_ = nullptr;
};

}  // namespace tilth
