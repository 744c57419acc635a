#include "tilth/coarse_stage.h"

#include <algorithm>
#include <utility>

#include "tilth/gl/stage_clock.h"
#include "tilth/ground/apply_edit.h"
#include "tilth/ground/before_image.h"

namespace tilth {

Result<std::unique_ptr<CoarseStage>> CoarseStage::create(gl::Device& device, gl::ShaderLibrary& shaders, Ground& ground,
                                                         const TerrainSettings& settings, ExecutorKind executor,
                                                         gl::FrameStats& stats) {
    const HeightField& field = ground.coarse();
    const MapGeometry& map = ground.map(MapKind::Coarse);
    std::unique_ptr<CoarseStage> made(new CoarseStage(device, ground, settings));
    Result<HeightPlanes> planes = HeightPlanes::create(device, field.width(), field.depth(), map.precision);
    if (!planes) return planes.error();
    made->planes_ = std::move(*planes);
    Result<SlopeMap> slopes = SlopeMap::create(device, field.width(), field.depth(), settings.slopes);
    if (!slopes) return slopes.error();
    made->slopes_ = std::move(*slopes);
    if (executor == ExecutorKind::Gpu) {
        Result<Deformer> deformer = Deformer::create(device, shaders);
        if (!deformer) return deformer.error();
        made->deformer_ = std::move(*deformer);
        Result<SlopePass> pass =
            SlopePass::create(device, shaders, map.precision, settings.slopes, made->slope_settings());
        if (!pass) return pass.error();
        made->slope_pass_ = std::move(*pass);
        ++stats.derive.programs;
    }
    made->planes_->upload(field, field.rect(), stats.transfer);
    made->changed_.push_back(field.rect());
    made->derive(stats);
    return made;
}

SlopeSettings CoarseStage::slope_settings() const {
    return {settings_.stencil, map().codec.code_quantum_m(), map().grid.spacing_m};
}

Result<void> CoarseStage::reload(gl::ShaderLibrary& shaders) {
    Result<void> result;
    if (slope_pass_)
        if (Result<void> reloaded = slope_pass_->reload(shaders); !reloaded) result = std::move(reloaded);
    if (deformer_)
        if (Result<void> reloaded = deformer_->reload(); !reloaded) result = std::move(reloaded);
    return result;
}

Result<void> CoarseStage::apply(std::span<const GroundEdit> edits, gl::FrameStats& stats) {
    outcome_ = {};
    {
        const gl::StageClock clock(stats.deform);
        if (deformer_) look_before_saturating(edits, stats);
        for (const GroundEdit& edit : edits) {
            if (deformer_ && edit.kind == GroundEdit::Kind::Stamp) {
                queue(edit, stats);
                continue;
            }
            draw(stats);
            if (is_ahead()) ++stats.deform.fallbacks;
            read_back(stats);
            apply_on_cpu(edit, stats);
            if (deformer_) upload(stats);  // what follows is drawn over it
        }
        draw(stats);
    }
    upload(stats);
    if (changes_ != nullptr)
        changes_->finish(MapKind::Coarse, [&](const Change& change) {
            return deformer_ ? bounds_.query(change.rect) : range_in(ground_.coarse(), change.rect);
        });
    derive(stats);
    return std::exchange(outcome_, {});
}

/// Before it is applied. `ahead`: the ground's codes may be out of date.
void CoarseStage::note_change(const GroundEdit& edit, bool ahead) {
    if (changes_ == nullptr) return;
    for (const ChangedRect& changed : changed_by(ground_, edit))
        if (changed.map == MapKind::Coarse)
            changes_->note(MapKind::Coarse, {}, changed.rect,
                           ahead ? bounds_.query(changed.rect) : range_in(ground_.coarse(), changed.rect),
                           changed.sequence, changed.sequence);
}

StampRange CoarseStage::range_of(const PreparedStamp& stamp) const {
    // Smooth reads one post further, whose codes may then spread into the rectangle.
    const CodeRange old = bounds_.query(expanded(stamp.rect(), 1));
    return range_after(stamp, old.min, old.max);
}

/// Bounds of what only the GPU knows are wider than the truth. Before stamps are counted one by one, look.
void CoarseStage::look_before_saturating(std::span<const GroundEdit> edits, gl::FrameStats& stats) {
    if (!is_ahead()) return;
    for (const GroundEdit& edit : edits) {
        if (edit.kind != GroundEdit::Kind::Stamp) continue;
        const PreparedStamp stamp = prepare(edit.record, map(), ground_.shapes());
        if (stamp.rect().empty() || !range_of(stamp).may_saturate) continue;
        read_back(stats);
        ++stats.deform.fallbacks;
        return;
    }
}

/// A stamp for the GPU, to be drawn with those that follow.
void CoarseStage::queue(const GroundEdit& edit, gl::FrameStats& stats) {
    DeformStamp stamp{.prepared = prepare(edit.record, map(), ground_.shapes())};
    const TexelRect rect = stamp.prepared.rect();
    if (rect.empty()) return;
    StampRange range = range_of(stamp.prepared);
    const bool undoable = edit.stroke != nullptr && !edit.stroke->forgotten;
    if (undoable && (range.may_saturate || stamp.prepared.rule() != StampRule::Add)) {
        bool lacks = false;
        for_each_page(pages_of(rect), [&](PageIndex page) { lacks = lacks || !edit.stroke->coarse.contains(page); });
        if (lacks) {
            draw(stats);
            if (std::any_of(newer_.begin(), newer_.end(),
                            [&](const TexelRect& newer) { return !intersection(newer, expanded(rect, 64)).empty(); })) {
                read_back(stats);
                ++stats.deform.fallbacks;
                range = range_of(stamp.prepared);
            }
            keep_images(edit, stamp.prepared, ground_.coarse(), map(), ground_.shapes());
        }
    }
    note_change(edit, true);
    stamp.may_saturate = range.may_saturate;
    bounds_.widen_by(rect, range.min, range.max);
    batch_.push_back(stamp);
    placed_.push_back(edit);
}

void CoarseStage::draw(gl::FrameStats& stats) {
    if (batch_.empty()) return;
    std::size_t done = 0;
    const Result<void> applied = deformer_->apply(batch_, *planes_, stats.deform, done);
    std::vector<TexelRect> drawn;
    for (std::size_t i = 0; i < done; ++i) drawn.push_back(batch_[i].prepared.rect());
    drawn = disjoint(drawn);
    changed_.insert(changed_.end(), drawn.begin(), drawn.end());
    newer_.insert(newer_.end(), drawn.begin(), drawn.end());
    if (newer_.size() > 256) newer_ = disjoint(newer_);
    const std::vector<GroundEdit> edits = std::exchange(placed_, {});
    batch_.clear();
    if (applied) return;
    outcome_ = applied.error();
    read_back(stats);
    for (std::size_t i = done; i < edits.size(); ++i) {
        ++stats.deform.fallbacks;
        apply_on_cpu(edits[i], stats);
    }
    upload(stats);
}

/// The ground's codes are current.
void CoarseStage::apply_on_cpu(const GroundEdit& edit, gl::FrameStats& stats) {
    note_change(edit, false);
    const ApplyResult result = apply_edit(ground_, MapKind::Coarse, edit);
    stats.deform.texels += result.texels;
    stats.deform.saturated += result.saturated;
    if (!result.rect.empty()) stale_.push_back(result.rect);
}

void CoarseStage::upload(gl::FrameStats& stats) {
    for (const TexelRect& rect : disjoint(std::exchange(stale_, {}))) {
        planes_->upload(ground_.coarse(), rect, stats.transfer);
        bounds_.widen(rect, ground_.coarse());
        changed_.push_back(rect);
    }
}

void CoarseStage::derive(gl::FrameStats& stats) {
    const std::vector<TexelRect> changed = disjoint(std::exchange(changed_, {}));
    if (changed.empty()) return;
    const gl::StageClock clock(stats.derive);
    if (slope_pass_)
        slope_pass_->run(changed, *planes_, *slopes_, stats.derive, stats.mips);
    else
        upload_slopes(changed, ground_.coarse(), slope_settings(), *slopes_, stats.derive, stats.mips, stats.transfer);
}

void CoarseStage::read_back(gl::FrameStats& stats) {
    if (!deformer_) return;
    deformer_->finish(stats.deform);
    for (const TexelRect& rect : disjoint(std::exchange(newer_, {}))) {
        planes_->read_back(rect, ground_.mutable_coarse(), stats.transfer);
        bounds_.widen(rect, ground_.coarse());
    }
}

}  // namespace tilth
