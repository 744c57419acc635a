#include "tilth/relief_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tilth/gl/stage_clock.h"
#include "tilth/render/relief_reach.h"
#include "tilth/world/texel_rects.h"

namespace tilth {
namespace {

constexpr std::size_t kMostRanges = 1u << 14;  // pages: more than any window shows

}  // namespace

ReliefStage::ReliefStage(gl::Device& device, gl::ShaderLibrary& shaders, const Ground& ground, const TileCache& cache,
                         GpuTiles& textures, SlopeFormat slopes)
    : device_(&device), shaders_(&shaders), ground_(&ground), cache_(&cache), textures_(&textures), slopes_(slopes) {
    textures_->note_changes(true);
}

ReliefStage::~ReliefStage() { textures_->note_changes(false); }

Result<void> ReliefStage::make(std::int32_t size, gl::StageStats& derive) {
    const MapGeometry& map = ground_->map(MapKind::Detail);
    if (!pass_) {
        const std::uint64_t linked = shaders_->programs_linked();
        Result<ReliefPass> pass =
            ReliefPass::create(*device_, *shaders_, map.precision, slopes_, map.codec.code_quantum_m());
        derive.programs += shaders_->programs_linked() - linked;
        if (!pass) return pass.error();
        pass_.emplace(std::move(*pass));
    }
    if (window_ && window_->size() == size) return {};
    window_.reset();
    square_.reset();
    sources_.clear();
    Result<ReliefWindow> window = ReliefWindow::create(*device_, size, slopes_);
    if (!window) return window.error();
    window_.emplace(std::move(*window));
    return {};
}

std::vector<ReliefStage::Source> ReliefStage::sources_in(const TexelRect& square) const {
    std::vector<Source> found;
    for_each_tile(tiles_of(cache_->grid(), square), [&](TileIndex tile) {
        const TileSet* const set = cache_->can_be_drawn(tile) ? textures_->set_of(tile) : nullptr;
        if (set != nullptr) found.push_back({tile, set->planes.high().serial()});
    });
    return found;
}

Result<ReliefView> ReliefStage::update(WorldPos eye, std::int32_t size, gl::FrameStats& stats) {
    const gl::StageClock clock(stats.derive);
    std::vector<TexelRect> changed = textures_->take_changes();
    for (const TexelRect& rect : changed) for_each_page(pages_of(rect), [&](PageIndex page) { ranges_.erase(page); });
    if (ranges_.size() > kMostRanges) ranges_.clear();
    if (const Result<void> made = make(size, stats.derive); !made) return made.error();

    const MapGeometry& map = ground_->map(MapKind::Detail);
    const PostPos at = map.grid.posts(eye);
    // What is no number is refused by the renderer, after this.
    const auto texel = [](double t) {
        return std::isnan(t) ? 0 : static_cast<std::int32_t>(std::floor(std::clamp(t, -1e9, 1e9)));
    };
    const TexelRect square = relief_square({texel(at.x), texel(at.z)}, size, kReliefStep);
    std::vector<Source> sources = sources_in(square);

    // Slopes about a code that changed have changed, too: at most two texels off.
    for (TexelRect& rect : changed) rect = expanded(rect, 2);
    if (!square_) {
        // A new window shows untouched ground already.
        for (const Source& source : sources) changed.push_back(cache_->grid().inside(source.tile));
    } else {
        for (const TexelRect& part : newly_covered(*square_, square)) changed.push_back(part);
        const auto note_missing = [&](const std::vector<Source>& in, const std::vector<Source>& from) {
            for (const Source& source : from)
                if (std::find(in.begin(), in.end(), source) == in.end())
                    changed.push_back(cache_->grid().inside(source.tile));
        };
        note_missing(sources, sources_);
        note_missing(sources_, sources);
    }
    if (all_stale_) changed.assign(1, square);
    all_stale_ = false;
    square_ = square;
    sources_ = std::move(sources);

    std::vector<ReliefSource> from;
    for (const Source& source : sources_) {
        const TileSet* const set = textures_->set_of(source.tile);
        from.push_back({&set->planes, &set->slopes, cache_->grid().inside(source.tile)});
    }
    pass_->run(changed, square, from, *window_, stats.derive);
    return ReliefView{.window = &*window_,
                      .bounds = this,
                      .square = square,
                      .code_quantum_m = map.codec.code_quantum_m(),
                      .extremes = query(square)};
}

// ---- where there is detail ----

CodeRange ReliefStage::range_of_page(PageIndex page) const {
    if (const auto found = ranges_.find(page); found != ranges_.end()) return found->second;
    const CodeRange range = range_in(ground_->detail().find(page), page, texels_of(page));
    return ranges_.emplace(page, range).first->second;
}

CodeRange ReliefStage::query(const TexelRect& rect) const {
    CodeRange all{kMidCode, kMidCode};
    for (const Source& source : sources_) {
        const TexelRect part = intersection(rect, cache_->grid().inside(source.tile));
        if (part.empty()) continue;
        if (textures_->has_deformer())
            all.include(textures_->bounds(source.tile, part));
        else
            for_each_page(pages_of(part), [&](PageIndex page) { all.include(range_of_page(page)); });
    }
    return all;
}

Result<void> ReliefStage::reload(gl::ShaderLibrary& shaders) {
    all_stale_ = true;  // by the new shaders
    return pass_ ? pass_->reload(shaders) : Result<void>();
}

}  // namespace tilth
