#include "tilth/cache/tile_cache.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "tilth/cache/page_runs.h"
#include "tilth/core/clock.h"
#include "tilth/ground/before_image.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

constexpr std::uint64_t kNotLoaded = ~std::uint64_t{0};
constexpr std::size_t kStampsAStep = 8;      // applied between two looks at the clock
constexpr std::size_t kMostArrivals = 1024;  // remembered for a host that does not ask

}  // namespace

Result<std::unique_ptr<TileCache>> TileCache::create(Ground& ground, const TileGrid& grid,
                                                     std::shared_ptr<TileStore> store, TileTextures& textures,
                                                     const TileCacheSettings& settings) {
    TILTH_ASSERT(store != nullptr, "a tile cache needs a store");
    Result<std::vector<TileIndex>> stored = store->tiles();
    if (!stored) return stored.error();
    std::unique_ptr<TileCache> made(new TileCache(ground, grid, std::move(store), textures, settings));
    for (const TileIndex index : *stored)
        if (grid.exists(index)) made->tiles_[index].stored = true;
    for (const TileIndex index : *stored)
        if (grid.exists(index)) made->suspect_neighbours(index);
    return made;
}

/// The aprons of the tiles about one that holds something may hold some of it.
void TileCache::suspect_neighbours(TileIndex index) {
    for_each_neighbour(index, [&](TileIndex at) {
        if (!grid_.exists(at)) return;
        const auto [found, inserted] = tiles_.try_emplace(at);
        if (inserted) found->second.suspected = true;
    });
}

TileCache::TileCache(Ground& ground, const TileGrid& grid, std::shared_ptr<TileStore> store, TileTextures& textures,
                     const TileCacheSettings& settings)
    : ground_(ground),
      field_(ground.mutable_detail()),
      grid_(grid),
      textures_(textures),
      settings_(settings),
      worker_(std::move(store)) {}

// ---- what there is ----

const TileCache::Tile* TileCache::find(TileIndex index) const {
    const auto found = tiles_.find(index);
    return found == tiles_.end() || found->second.clean ? nullptr : &found->second;
}
TileCache::Tile* TileCache::find(TileIndex index) {
    return const_cast<Tile*>(static_cast<const TileCache*>(this)->find(index));
}

bool TileCache::is_hot(TileIndex index) const {
    const Tile* tile = find(index);
    return tile != nullptr && tile->hot;
}

/// Of a hot tile, or a guest: at its cold owner's border, beside a hot tile.
bool TileCache::is_hot(PageIndex page) const {
    const std::int32_t a_side = grid_.size / kPageTexels;
    const TileIndex owner{floor_divide(page.x, a_side), floor_divide(page.z, a_side)};
    if (is_hot(owner)) return true;
    const std::int32_t x = page.x - owner.x * a_side, z = page.z - owner.z * a_side;
    for (std::int32_t dz = z == 0 ? -1 : 0; dz <= (z == a_side - 1 ? 1 : 0); ++dz)
        for (std::int32_t dx = x == 0 ? -1 : 0; dx <= (x == a_side - 1 ? 1 : 0); ++dx)
            if (is_hot(TileIndex{owner.x + dx, owner.z + dz})) return true;
    return false;
}

bool TileCache::on_gpu(const Tile& tile) const { return settings_.gpu_executor && tile.current; }

Interest TileCache::interest(TileIndex index) const { return interest_in(index, viewers_); }

bool TileCache::held(TileIndex index) const {
    return required_.contains(index) || awaited_.contains(index) || crowded_.contains(index);
}

TileState TileCache::state(TileIndex index) const {
    const Tile* tile = find(index);
    return tile == nullptr ? TileState::Absent : tile->state;
}

bool TileCache::can_be_drawn(TileIndex index) const {
    const Tile* tile = find(index);
    return tile != nullptr && tile->current;
}

std::vector<CachedTile> TileCache::tiles() const {
    std::vector<CachedTile> all;
    for (const auto& [index, tile] : tiles_)
        if (!tile.clean) all.push_back({index, tile.state, interest(index), tile.modified, tile.pending.size()});
    return all;
}

std::vector<TileIndex> TileCache::touched() const {
    std::vector<TileIndex> all;
    for (const auto& [index, tile] : tiles_)
        if (!tile.clean) all.push_back(index);
    return all;
}

std::vector<CachedArrival> TileCache::take_arrivals() { return std::exchange(arrivals_, {}); }
std::vector<Error> TileCache::take_errors() { return std::exchange(errors_, {}); }

std::uint64_t TileCache::waiting_bytes() const {
    std::uint64_t sum = 0;
    for (const auto& [index, tile] : tiles_) {
        sum += tile.pending.size() * sizeof(Stamp);
        if (tile.arriving)
            sum += (tile.arriving->own.pages().size() + tile.arriving->guests.pages().size()) * sizeof(PageCodes);
    }
    return sum;
}

std::vector<TileIndex> TileCache::by_nearness() const {
    std::vector<std::tuple<int, std::int32_t, TileIndex>> order;
    for (const TileIndex index : live_)
        order.emplace_back(-static_cast<int>(interest(index)), tiles_away(index, viewers_), index);
    std::sort(order.begin(), order.end());
    std::vector<TileIndex> sorted;
    for (const auto& [rank, distance, index] : order) sorted.push_back(index);
    return sorted;
}

// ---- a frame ----

void TileCache::set_viewers(std::span<const WorldPos> viewers) {
    viewers_.clear();
    viewer_texels_.clear();
    for (const WorldPos& at : viewers) {
        viewer_texels_.push_back(ground_.map(MapKind::Detail).grid.posts(at));
        viewers_.push_back(tiles_of_viewer(grid_, viewer_texels_.back(), settings_.band));
    }
}

void TileCache::update(double now_ms, gl::CacheStats& stats) {
    now_ms_ = now_ms;
    while (const std::shared_ptr<DiskRequest> done = worker_.poll()) deliver(done, stats);
    for (const TileIndex index : std::vector(live_.begin(), live_.end())) poll_read_back(index, *find(index), stats);
    fetch_the_crowded();
    start_wanted(stats);
    let_go_unwanted(stats);
}

/// Too many stamps wait: the tiles with the most are brought up to date and saved.
void TileCache::fetch_the_crowded() {
    if (pending_ <= settings_.most_pending_in_all) return;
    std::vector<std::pair<std::size_t, TileIndex>> waiting;
    for (const auto& [index, tile] : tiles_)
        if (!tile.pending.empty()) waiting.emplace_back(tile.pending.size(), index);
    std::sort(waiting.rbegin(), waiting.rend());
    std::size_t left = pending_;
    for (const auto& [count, index] : waiting) {
        if (left <= settings_.most_pending_in_all / 2) break;
        crowded_.insert(index);
        left -= count;
    }
}

void TileCache::start_wanted(gl::CacheStats& stats) {
    std::vector<TileIndex> wanted;
    for (const ViewerTiles& viewer : viewers_)
        for_each_tile(viewer.loaded, [&](TileIndex index) { wanted.push_back(index); });
    for (const std::set<TileIndex>* set : {&required_, &awaited_, &crowded_})
        wanted.insert(wanted.end(), set->begin(), set->end());
    for (const TileIndex index : wanted) {
        Tile* tile = find(index);
        if (tile == nullptr) continue;
        if (tile->state == TileState::Absent && now_ms_ < tile->retry_at_ms) continue;
        if (interest(index) >= Interest::Loaded) tile->yielding = false;  // unless it is still in a nearer one's way
        send(index, *tile, TileEvent::Wanted, stats);
    }
}

void TileCache::let_go_unwanted(gl::CacheStats& stats) {
    for (const TileIndex index : std::vector(live_.begin(), live_.end())) {
        Tile& tile = *find(index);
        if (tile.state != TileState::Saving && interest(index) == Interest::None) {
            if (!held(index))
                send(index, tile, TileEvent::Unwanted, stats);
            else if (tile.has_textures)
                give_up_textures(index, tile, stats);  // held for its codes alone
        }
        // A save that waits for its read-back, for an earlier save, or for better times.
        if (tile.state == TileState::Saving && now_ms_ >= tile.retry_at_ms) start_save(index, tile, stats);
    }
}

void TileCache::send(TileIndex index, Tile& tile, TileEvent event, gl::CacheStats& stats) {
    const TileStep step = next_step(tile.state, event, {tile.modified, tile.current});
    tile.state = step.next;
    if (tile.state == TileState::Absent)
        live_.erase(index);
    else
        live_.insert(index);
    switch (step.action) {
        case TileAction::StartLoad:
            tile.wanted_ms = now_ms_;
            start_load(index, tile);
            break;
        case TileAction::CancelLoad:
            if (tile.request) tile.request->cancel();
            tile.request.reset();
            tile.arriving.reset();
            break;
        case TileAction::StartSave:
            start_save(index, tile, stats);
            break;
        case TileAction::Rescue:
            ++stats.rescues;
            break;
        case TileAction::Drop:
            drop(index, tile, stats);
            break;
        case TileAction::None:
        case TileAction::StartFill:  // `transfer` finds it
        case TileAction::RetrySave:  // `let_go_unwanted` does, when the pause is over
            break;
    }
}

void TileCache::deliver(const std::shared_ptr<DiskRequest>& done, gl::CacheStats& stats) {
    if (done->kind == DiskRequest::Kind::Work) {
        finished_.push_back(done);
        return;
    }
    Tile* const tile = find(done->tile);
    if (tile == nullptr) return;
    const bool expected = tile->request == done;
    if (expected) tile->request.reset();
    if (done->kind == DiskRequest::Kind::Save) {
        if (done->outcome) {
            ++stats.saves;
            ++tile->version;
            tile->stored = true;
            tile->modified = tile->changed;
            tile->went_well();
            send(done->tile, *tile, TileEvent::Saved, stats);
        } else {
            tile->changed = true;
            fail(*tile, done->outcome.error(), stats);
            send(done->tile, *tile, TileEvent::SaveFailed, stats);
        }
        return;
    }
    if (done->was_cancelled) ++stats.cancelled;
    if (!expected || done->was_cancelled) return;
    if (!done->outcome) {
        fail(*tile, done->outcome.error(), stats);
        send(done->tile, *tile, TileEvent::LoadFailed, stats);
        return;
    }
    ++stats.loads;
    tile->went_well();
    begin_arrival(done->tile, *tile, done->pieces);
}

void TileCache::fail(Tile& tile, const Error& error, gl::CacheStats& stats) {
    ++stats.failures;
    tile.trouble = error;
    if (!tile.reported) errors_.push_back(error);
    tile.reported = true;
    tile.pause_ms = std::clamp(2 * tile.pause_ms, settings_.least_retry_ms, settings_.most_retry_ms);
    tile.retry_at_ms = now_ms_ + tile.pause_ms;
}

// ---- arriving ----

/// Calls `visit(index, tile, pages that reach into the apron of `of`)` for each neighbour whose codes are not in the
/// field.
template <class Visit>
void TileCache::for_each_cold_neighbour(TileIndex of, const Visit& visit) const {
    const PageRect stored = pages_of(grid_.stored(of));
    for_each_neighbour(of, [&](TileIndex at) {
        const Tile* neighbour = find(at);
        const PageRect strip = intersection(stored, pages_of(grid_.interior(at)));
        if (neighbour != nullptr && !neighbour->hot && !strip.empty()) visit(at, *neighbour, strip);
    });
}

std::vector<LoadPiece> TileCache::pieces_for(TileIndex index, const Tile& tile) const {
    std::vector<LoadPiece> pieces;
    if (tile.stored)
        pieces.push_back({.tile = index, .pages = pages_of(grid_.interior(index)), .version = tile.version});
    for_each_cold_neighbour(index, [&](TileIndex at, const Tile& neighbour, const PageRect& strip) {
        if (neighbour.stored) pieces.push_back({.tile = at, .pages = strip, .version = neighbour.version});
    });
    return pieces;
}

void TileCache::start_load(TileIndex index, Tile& tile) {
    tile.arriving.reset();
    std::vector<LoadPiece> pieces = pieces_for(index, tile);
    if (pieces.empty()) {
        begin_arrival(index, tile, {});
        return;
    }
    const auto rank = static_cast<std::uint32_t>(Interest::Active) - static_cast<std::uint32_t>(interest(index));
    const auto distance = static_cast<std::uint32_t>(std::min(tiles_away(index, viewers_), 999));
    tile.request = DiskRequest::load(index, std::move(pieces), rank * 1000 + distance);
    worker_.submit(tile.request);
}

void TileCache::begin_arrival(TileIndex index, Tile& tile, std::span<LoadPiece> loaded) {
    tile.arriving = std::make_unique<Arrival>();
    Arrival& arrival = *tile.arriving;
    for_each_cold_neighbour(index, [&](TileIndex at, const Tile& neighbour, const PageRect& strip) {
        // What the store has of it counts only if it came along.
        const std::uint64_t version = neighbour.stored ? kNotLoaded : neighbour.version;
        arrival.neighbours.push_back({.owner = at, .version = version, .pages = strip});
    });
    for (LoadPiece& piece : loaded) {
        for (Arrival::Guest& guest : arrival.neighbours)
            if (guest.owner == piece.tile) guest.version = piece.version;
        for (Page& page : piece.loaded) (piece.tile == index ? arrival.own : arrival.guests).put(std::move(page));
    }
}

/// False when a neighbour was saved, and its codes dropped, since they were asked for: or touched for the first time.
bool TileCache::is_current(TileIndex index, const Arrival& arrival) const {
    bool current = true;
    for_each_cold_neighbour(index, [&](TileIndex at, const Tile& neighbour, const PageRect&) {
        current = current && std::any_of(arrival.neighbours.begin(), arrival.neighbours.end(), [&](const auto& guest) {
                      return guest.owner == at && guest.version == neighbour.version;
                  });
    });
    return current;
}

/// Applies up to `most_stamps` of those that wait for a loaded tile and for the guests that come with it. True when it
/// is hot, or was found to be untouched.
bool TileCache::arrive(TileIndex index, Tile& tile, std::size_t most_stamps, gl::CacheStats& stats,
                       gl::StageStats& deform) {
    if (!is_current(index, *tile.arriving)) {
        start_load(index, tile);
        return false;
    }
    Arrival& arrival = *tile.arriving;
    const TexelRect inside = grid_.inside(index);
    for (; arrival.applied < tile.pending.size() && most_stamps > 0; ++arrival.applied, --most_stamps) {
        const Stamp& stamp = tile.pending[arrival.applied];
        keep_images(stamp.edit, stamp.prepared, inside, arrival.own, ground_.map(MapKind::Detail), ground_.shapes());
        const ApplyResult result = apply_stamp(stamp.prepared, arrival.own, inside);
        deform.texels += result.texels;
        deform.saturated += result.saturated;
        ++stats.late_stamps;
    }
    for (Arrival::Guest& guest : arrival.neighbours) {
        const Tile* owner = find(guest.owner);
        if (owner == nullptr || owner->hot) continue;
        const TexelRect clip =
            intersection({texels_of(guest.pages.min).min, texels_of(guest.pages.max).min}, grid_.map);
        for (; guest.applied < owner->pending.size() && most_stamps > 0; ++guest.applied) {
            const PreparedStamp& stamp = owner->pending[guest.applied].prepared;
            if (intersection(stamp.rect(), clip).empty()) continue;
            apply_stamp(stamp, arrival.guests, clip);
            --most_stamps;
        }
    }
    if (most_stamps == 0) return false;  // perhaps there is more
    if (tile.suspected) {
        tile.suspected = false;
        if (tile.pending.empty() && apron_is_untouched(index, arrival)) {
            tile.arriving.reset();
            tile.state = TileState::Absent;
            tile.clean = true;
            live_.erase(index);
            return true;
        }
        tile.was_changed();  // the store shall know of it
    }
    make_hot(index, tile);
    send(index, tile, TileEvent::Loaded, stats);
    return true;
}

bool TileCache::apron_is_untouched(TileIndex index, const Arrival& arrival) const {
    const TexelRect stored = intersection(grid_.stored(index), grid_.map);
    std::vector<std::uint32_t> codes(static_cast<std::size_t>(stored.count()));
    const auto width = static_cast<std::size_t>(stored.width());
    const auto untouched = [&](const DetailField& field) {
        field.copy(stored, codes.data(), width);
        return std::all_of(codes.begin(), codes.end(), [](std::uint32_t code) { return code == kMidCode; });
    };
    return untouched(field_) && untouched(arrival.guests);
}

void TileCache::make_hot(TileIndex index, Tile& tile) {
    const std::unique_ptr<Arrival> arrival = std::move(tile.arriving);
    const auto replace = [&](const PageRect& rect, const DetailField& by) {
        for (const Page& page : field_.pages_in(rect)) field_.erase(page.index);
        for (Page& page : by.pages_in(rect)) field_.put(std::move(page));
    };
    replace(pages_of(grid_.interior(index)), arrival->own);
    for (const Arrival::Guest& guest : arrival->neighbours)
        if (const Tile* owner = find(guest.owner); owner != nullptr && !owner->hot)
            replace(guest.pages, arrival->guests);
    tile.hot = true;
    if (!tile.pending.empty()) tile.unsaved = true;  // the last snapshot may have them waiting
    pending_ -= tile.pending.size();
    tile.pending.clear();
    tile.pending.shrink_to_fit();
    crowded_.erase(index);
}

// ---- textures ----

bool TileCache::is_full() const { return settings_.most_tiles != 0 && textured_.size() >= settings_.most_tiles; }

/// Under a bound: whose textures a tile may have, being nearer.
std::optional<TileIndex> TileCache::makes_way_for(TileIndex index) const {
    if (!is_full()) return std::nullopt;
    const auto rank = [&](TileIndex at) {
        return std::pair(static_cast<int>(interest(at)), -tiles_away(at, viewers_));
    };
    const TileIndex farthest = *std::min_element(textured_.begin(), textured_.end(),
                                                 [&](TileIndex x, TileIndex y) { return rank(x) < rank(y); });
    return rank(farthest) < rank(index) ? std::optional(farthest) : std::nullopt;
}

/// Whether a tile may have textures now.
bool TileCache::make_room(TileIndex index, gl::CacheStats& stats) {
    const std::optional<TileIndex> other = makes_way_for(index);
    return other ? give_up_textures(*other, *find(*other), stats) : !is_full();
}

/// At once, unless the field lacks what they hold: then as soon as that has been read back.
bool TileCache::give_up_textures(TileIndex index, Tile& tile, gl::CacheStats& stats) {
    if (!tile.newer.empty() || !tile.reading.empty()) {
        tile.yielding = true;  // `poll_read_back` sees to it
        return false;
    }
    release_textures(index, tile, stats);
    send(index, tile, TileEvent::Displaced, stats);
    return true;
}

bool TileCache::acquire(TileIndex index, Tile& tile, gl::CacheStats& stats) {
    if (!make_room(index, stats) || !textures_.acquire(index)) return false;
    tile.has_textures = true;
    textured_.insert(index);
    tile.to_fill.clear();
    for (const Page& page : field_.pages_in(pages_of(grid_.stored(index)))) tile.to_fill.insert(page.index);
    return true;
}

void TileCache::release_textures(TileIndex index, Tile& tile, gl::CacheStats& stats) {
    if (!tile.has_textures) return;
    textures_.release(index);
    textured_.erase(index);
    tile.has_textures = tile.current = tile.yielding = false;
    tile.to_fill.clear();
    ++stats.evictions;
}

void TileCache::transfer(FrameBudget& budget, gl::CacheStats& stats, gl::StageStats& deform) {
    const double start_ms = clock_ms();
    bool ring_has_room = true;
    for (const TileIndex index : by_nearness()) {
        Tile& tile = *find(index);
        while (tile.state == TileState::Loading && tile.arriving && budget.allows(0)) {
            const double began_ms = clock_ms();
            arrive(index, tile, kStampsAStep, stats, deform);
            budget.spend(0, clock_ms() - began_ms);
        }
        if (tile.state != TileState::Uploading || interest(index) == Interest::None || !ring_has_room) continue;
        if (!tile.has_textures && interest(index) == Interest::Kept) continue;  // gave them up, or never needed any
        if (!tile.has_textures) {
            // Clearing them counts as a slice: the first of a frame, or one that the budget has room for.
            const auto side = static_cast<std::uint64_t>(grid_.stored_size());
            if (!budget.allows(side * side * settings_.bytes_a_texel)) continue;
            const double began_ms = clock_ms();
            const bool acquired = acquire(index, tile, stats);
            budget.spend(0, clock_ms() - began_ms);
            if (!acquired) continue;
        }
        ring_has_room = fill(index, tile, budget);
        if (tile.to_fill.empty()) finish_fill(index, tile, stats);
    }
    std::set<TileIndex> active;
    for (const ViewerTiles& viewer : viewers_)
        for_each_tile(viewer.active, [&](TileIndex index) { active.insert(index); });
    for (const TileIndex index : active) {
        const Tile* tile = find(index);
        if (tile != nullptr && !tile->current) ++stats.missing_active;
    }
    stats.transfer_ms += clock_ms() - start_ms;
}

/// False when the ring is full.
bool TileCache::fill(TileIndex index, Tile& tile, FrameBudget& budget) {
    const auto run = static_cast<std::int32_t>(std::max<std::uint64_t>(
        budget.settings().slice_bytes / (kPageTexels * kPageTexels * settings_.bytes_a_texel), 1));
    while (!tile.to_fill.empty() && budget.allows(budget.settings().slice_bytes)) {
        const double began_ms = clock_ms();
        const TexelRect rect = take_run(tile.to_fill, run, grid_.stored(index));
        if (rect.empty()) continue;
        if (!textures_.fill(index, rect, field_, true)) {
            add_pages(tile.to_fill, rect);
            return false;
        }
        budget.spend(static_cast<std::uint64_t>(rect.count()) * settings_.bytes_a_texel, clock_ms() - began_ms);
    }
    return true;
}

void TileCache::finish_fill(TileIndex index, Tile& tile, gl::CacheStats& stats) {
    // With the gpu executor the neighbours' textures are ahead of the field that filled the apron.
    for_each_neighbour(index, [&](TileIndex at) {
        const Tile* neighbour = find(at);
        if (neighbour == nullptr || !on_gpu(*neighbour)) return;
        const TexelRect shared = intersection(grid_.stored(index), grid_.interior(at));
        if (!shared.empty()) textures_.exchange(at, index, shared);
    });
    tile.current = true;
    send(index, tile, TileEvent::Filled, stats);
    CachedArrival arrival{.tile = index};
    if (tile.wanted_ms >= 0) arrival.loading_ms = now_ms_ - tile.wanted_ms;
    for (std::size_t i = 0; i < viewer_texels_.size(); ++i) {
        const double lead = texels_until_active(grid_, viewer_texels_[i], index, settings_.band);
        arrival.lead_texels = i == 0 ? lead : std::min(arrival.lead_texels, lead);
    }
    tile.wanted_ms = -1;
    if (arrivals_.size() < kMostArrivals) arrivals_.push_back(arrival);
}

// ---- leaving ----

void TileCache::start_save(TileIndex index, Tile& tile, gl::CacheStats& stats) {
    if (!tile.newer.empty() || !tile.reading.empty()) {
        begin_read_back(index, tile);
        return;
    }
    release_textures(index, tile, stats);
    if (tile.request) return;  // an earlier save of it is still on its way
    tile.request = DiskRequest::save(index, field_.pages_in(pages_of(grid_.interior(index))), 500);
    tile.changed = false;
    worker_.submit(tile.request);
}

/// What the field lacks is on its way from now on, unless something is already, or the ring is full.
void TileCache::begin_read_back(TileIndex index, Tile& tile) {
    if (tile.reading.empty() && !tile.newer.empty() &&
        textures_.begin_read_back(index, rects_of(tile.newer, grid_.inside(index))))
        tile.reading = std::exchange(tile.newer, {});
}

void TileCache::poll_read_back(TileIndex index, Tile& tile, gl::CacheStats& stats) {
    if (tile.yielding) begin_read_back(index, tile);
    if (!tile.reading.empty()) {
        const ReadBackState state = textures_.poll_read_back(index, field_);
        if (state == ReadBackState::Pending) return;
        const std::set<PageIndex> read = std::exchange(tile.reading, {});
        if (state != ReadBackState::Done) {
            tile.newer.insert(read.begin(), read.end());
        } else {
            refill_neighbours(index, read);
        }
    }
    if (tile.yielding && tile.newer.empty() && tile.reading.empty()) give_up_textures(index, tile, stats);
}

/// The field now has what it lacked. Neighbours that are being filled took those texels before they were right.
void TileCache::refill_neighbours(TileIndex index, const std::set<PageIndex>& read) {
    for_each_neighbour(index, [&](TileIndex at) {
        Tile* neighbour = find(at);
        if (neighbour == nullptr || !neighbour->has_textures || neighbour->current) return;
        const PageRect stored = pages_of(grid_.stored(at));
        for (const PageIndex page : read)
            if (stored.contains(page)) neighbour->to_fill.insert(page);
    });
}

void TileCache::drop(TileIndex index, Tile& tile, gl::CacheStats& stats) {
    release_textures(index, tile, stats);
    tile.hot = false;
    tile.wanted_ms = -1;
    for (const Page& page : field_.pages_in(pages_of(grid_.stored(index))))
        if (!is_hot(page.index)) field_.erase(page.index);
}

}  // namespace tilth
