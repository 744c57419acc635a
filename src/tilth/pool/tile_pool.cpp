#include "tilth/pool/tile_pool.h"

#include <utility>

#include "tilth/core/checks.h"

namespace tilth {

Result<TileSet*> TilePool::acquire(TileIndex tile) {
    TILTH_EXPECTS(!tiles_.contains(tile), "a tile that has textures asks for others");
    if (!fill_) {
        Result<TextureFill> fill = TextureFill::create(*device_);
        if (!fill) return fill.error();
        fill_.emplace(std::move(*fill));
    }
    const bool used_before = !released_.empty();
    Result<std::unique_ptr<TileSet>> taken = take(tile);
    if (!taken) return taken.error();
    if (*taken == nullptr) return static_cast<TileSet*>(nullptr);
    TileSet& set = **taken;
    set.planes.clear(*fill_);
    if (used_before) set.slopes.clear(*fill_);  // new ones are flat
    tiles_[tile] = std::move(*taken);
    return &set;
}

Result<std::unique_ptr<TileSet>> TilePool::take(TileIndex tile) {
    if (!released_.empty()) {
        // A few frames' patience; a new set would be one more for good.
        if (!released_.front().done.signaled()) return std::unique_ptr<TileSet>();
        std::unique_ptr<TileSet> set = std::move(released_.front().set);
        released_.pop_front();
        set->planes.move_to(settings_.grid.stored(tile).min);
        set->slopes.move_to(settings_.grid.stored(tile).min);
        return set;
    }
    if (settings_.most_tiles > 0 && tiles_.size() + released_.size() >= static_cast<std::size_t>(settings_.most_tiles))
        return std::unique_ptr<TileSet>();
    return make(tile);
}

Result<std::unique_ptr<TileSet>> TilePool::make(TileIndex tile) {
    const TexelRect rect = settings_.grid.stored(tile);
    Result<HeightPlanes> planes = HeightPlanes::create(
        *device_, {.label = "detail tile", .rect = rect, .map = settings_.grid.map, .precision = settings_.precision});
    if (!planes) return planes.error();
    Result<SlopeMap> slopes = SlopeMap::create(
        *device_, {.label = "slopes of a detail tile", .rect = rect, .format = settings_.slopes, .levels = 1});
    if (!slopes) return slopes.error();
    return std::make_unique<TileSet>(TileSet{std::move(*planes), std::move(*slopes)});
}

void TilePool::release(TileIndex tile) {
    const auto found = tiles_.find(tile);
    TILTH_EXPECTS(found != tiles_.end(), "a tile without textures gives them up");
    released_.push_back({std::move(found->second), gl::Fence::insert(*device_)});
    tiles_.erase(found);
}

void TilePool::trim() {
    for (Released& released : released_) ++released.idle_frames;
    while (!released_.empty() && released_.front().idle_frames > kIdleFrames && released_.front().done.signaled())
        released_.pop_front();
}

TileSet* TilePool::find(TileIndex tile) {
    const auto found = tiles_.find(tile);
    return found == tiles_.end() ? nullptr : found->second.get();
}

const TileSet* TilePool::find(TileIndex tile) const {
    const auto found = tiles_.find(tile);
    return found == tiles_.end() ? nullptr : found->second.get();
}

std::uint64_t TilePool::bytes() const {
    std::uint64_t sum = 0;
    for (const auto& [tile, set] : tiles_) sum += set->planes.bytes() + set->slopes.bytes();
    for (const Released& released : released_) sum += released.set->planes.bytes() + released.set->slopes.bytes();
    return sum;
}

std::uint64_t TilePool::bytes_per_tile() const {
    const auto side = static_cast<std::uint64_t>(settings_.grid.stored_size());
    return side * side * bytes_a_texel(settings_.precision, settings_.slopes);
}

}  // namespace tilth
