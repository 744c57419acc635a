#include "tilth/gpu_tiles.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "tilth/core/checks.h"
#include "tilth/core/log.h"
#include "tilth/gl/api.h"
#include "tilth/gl/stage_clock.h"
#include "tilth/ground/stamp_range.h"
#include "tilth/pool/gl_rect.h"
#include "tilth/world/texel_rects.h"

namespace tilth {
namespace {

constexpr std::size_t kMostChanges = 1024;

/// One plane of the codes of `rect`, row by row, to memory that must be written once and front to back.
void write_plane(const DetailField& field, const TexelRect& rect, std::uint32_t shift, std::uint16_t* out) {
    const PageRect pages = pages_of(rect);
    std::vector<const PageCodes*> row(static_cast<std::size_t>(pages.max.x - pages.min.x));
    std::int32_t row_page = pages.min.z - 1;
    for (std::int32_t z = rect.min.z; z < rect.max.z; ++z) {
        if (const std::int32_t page_z = page_of({0, z}).z; page_z != row_page) {
            row_page = page_z;
            for (std::size_t i = 0; i < row.size(); ++i)
                row[i] = field.find({pages.min.x + static_cast<std::int32_t>(i), page_z});
        }
        for (std::size_t i = 0; i < row.size(); ++i) {
            const TexelRect page = texels_of({pages.min.x + static_cast<std::int32_t>(i), row_page});
            const TexelRect part = intersection(page, rect);
            if (row[i] == nullptr) {
                out = std::fill_n(out, part.width(), static_cast<std::uint16_t>(kMidCode >> shift));
                continue;
            }
            const std::uint32_t* codes = row[i]->data() + (z - page.min.z) * kPageTexels + (part.min.x - page.min.x);
            out = std::transform(codes, codes + part.width(), out,
                                 [shift](std::uint32_t code) { return static_cast<std::uint16_t>(code >> shift); });
        }
    }
}

CodeBounds::Range range_of(const CodeView& codes, const TexelRect& rect) {
    CodeBounds::Range range;
    for (std::int32_t z = rect.min.z; z < rect.max.z; ++z) {
        const std::uint32_t* row = codes.at({rect.min.x, z});
        for (std::int32_t x = 0; x < rect.width(); ++x) range.include({row[x], row[x]});
    }
    return range;
}

}  // namespace

GpuTiles::GpuTiles(gl::Device& device, gl::ShaderLibrary& shaders, Deformer* deformer, gl::TextureCopy copy,
                   const GpuTilesSettings& settings)
    : device_(&device),
      shaders_(&shaders),
      deformer_(deformer),
      copy_(std::move(copy)),
      settings_(settings),
      pool_(device, settings.pool) {}

Result<std::unique_ptr<GpuTiles>> GpuTiles::create(gl::Device& device, gl::ShaderLibrary& shaders, Deformer* deformer,
                                                   const GpuTilesSettings& settings) {
    Result<gl::TextureCopy> copy = gl::TextureCopy::create(device);
    if (!copy) return copy.error();
    return std::unique_ptr<GpuTiles>(new GpuTiles(device, shaders, deformer, std::move(*copy), settings));
}

void GpuTiles::report(const Error& error) {
    if (!refused_) log(LogLevel::Warning, text("detail tiles: ", error.message));
    refused_ = true;
}

SlopePass* GpuTiles::slope_pass() {
    if (deformer_ == nullptr) return nullptr;
    if (!slope_pass_) {
        Result<SlopePass> made =
            SlopePass::create(*device_, *shaders_, settings_.pool.precision, settings_.pool.slopes, settings_.slopes);
        if (!made) {
            report(made.error());
            ++stats_->derive.fallbacks;
            return nullptr;
        }
        ++stats_->derive.programs;
        slope_pass_.emplace(std::move(*made));
    }
    return &*slope_pass_;
}

GpuTiles::Tile& GpuTiles::tile(TileIndex index) {
    const auto found = tiles_.find(index);
    TILTH_ASSERT(found != tiles_.end(), text("tile ", index.x, ", ", index.z, " has no textures"));
    return found->second;
}

const GpuTiles::Tile& GpuTiles::tile(TileIndex index) const { return const_cast<GpuTiles*>(this)->tile(index); }

// ---- textures ----

bool GpuTiles::acquire(TileIndex index) {
    Result<TileSet*> set = pool_.acquire(index);
    if (!set) {
        report(set.error());
        return false;
    }
    if (*set == nullptr) return false;
    refused_ = false;
    tiles_.emplace(index, Tile{*set, CodeBounds((*set)->planes.held()), std::nullopt});
    note((*set)->planes.held());
    return true;
}

void GpuTiles::release(TileIndex index) {
    Tile& given_up = tile(index);
    if (given_up.reading)
        for (const auto& [ticket, slice] : given_up.reading->in_flight) down_->cancel(ticket);
    note(given_up.set->planes.held());
    tiles_.erase(index);
    pool_.release(index);
}

void GpuTiles::note_changes(bool on) {
    notes_changes_ = on;
    changes_.clear();
}

void GpuTiles::note(const TexelRect& rect) {
    if (!notes_changes_) return;
    if (changes_.size() >= std::max(most_changes_, kMostChanges)) {  // nobody asked for a while
        changes_ = disjoint(changes_);
        most_changes_ = 2 * changes_.size();
    }
    changes_.push_back(rect);
}

std::vector<TexelRect> GpuTiles::take_changes() {
    most_changes_ = 0;
    return std::exchange(changes_, {});
}

// ---- codes from the CPU ----

bool GpuTiles::fill(TileIndex index, const TexelRect& rect, const DetailField& field, bool paging) {
    Tile& filled = tile(index);
    const TexelRect part = intersection(rect, filled.set->planes.held());
    if (part.empty()) return true;
    note(part);
    SlopePass* const pass = slope_pass();
    if (paging) {
        if (!fill_through_ring(filled, part, field, pass == nullptr)) return false;
    } else {
        fill_at_once(filled, part, field, pass == nullptr);
    }
    if (deformer_ != nullptr) note_codes(filled, part, field);
    if (pass == nullptr) return true;
    const gl::StageClock clock(stats_->derive);
    pass->run({&part, 1}, filled.set->planes, filled.set->slopes, stats_->derive, stats_->mips);
    return true;
}

TexelRect GpuTiles::read_by(const TexelRect& stale, const TileSet& set) const {
    if (stale.empty()) return {};
    return intersection(expanded(stale, stencil_reach(settings_.slopes.stencil)), set.planes.held());
}

void GpuTiles::fill_at_once(Tile& filled, const TexelRect& part, const DetailField& field, bool slopes) {
    TileSet& set = *filled.set;
    const TexelRect stale = stale_slopes(part, set.planes.held(), set.planes.map(), settings_.slopes.stencil);
    const CodeView codes = gathered_.gather(field, slopes ? bounds_of(part, read_by(stale, set)) : part);
    set.planes.upload(codes, part, stats_->transfer);
    if (!slopes) return;
    const gl::StageClock clock(stats_->derive);
    upload_slopes({&part, 1}, codes, set.planes.map(), settings_.slopes, set.slopes, stats_->derive, stats_->mips,
                  stats_->transfer);
}

bool GpuTiles::fill_through_ring(Tile& filled, const TexelRect& part, const DetailField& field, bool slopes) {
    TileSet& set = *filled.set;
    const bool two_planes = settings_.pool.precision == HeightPrecision::bits32;
    const TexelRect stale =
        slopes ? stale_slopes(part, set.planes.held(), set.planes.map(), settings_.slopes.stencil) : TexelRect{};
    const auto plane_bytes = static_cast<std::size_t>(part.count()) * sizeof(std::uint16_t);
    const std::size_t codes_bytes = plane_bytes * (two_planes ? 2 : 1);
    const std::size_t size = codes_bytes + static_cast<std::size_t>(stale.count()) * slope_bytes(settings_.pool.slopes);
    if (!up_) {
        Result<UploadRing> ring = UploadRing::create(*device_, settings_.slot_bytes, settings_.slots);
        if (ring)
            up_.emplace(std::move(*ring));
        else
            report(ring.error());
    }
    if (!up_ || size > up_->slot_bytes()) {
        ++stats_->derive.fallbacks;
        fill_at_once(filled, part, field, slopes);
        return true;
    }
    const std::optional<std::span<std::byte>> bytes = up_->begin(size);
    if (!bytes) return false;
    write_plane(field, part, 16, reinterpret_cast<std::uint16_t*>(bytes->data()));
    if (two_planes) write_plane(field, part, 0, reinterpret_cast<std::uint16_t*>(bytes->data() + plane_bytes));
    if (!stale.empty()) {
        const gl::StageClock clock(stats_->derive);
        store_slopes(stale, gathered_.gather(field, read_by(stale, set)), set.planes.map(), settings_.slopes,
                     settings_.pool.slopes, bytes->data() + codes_bytes);
    }
    const Texel origin = set.planes.origin();
    gl::TransferStats& moved = stats_->transfer;
    bool uploaded = up_->to_texture(set.planes.high(), 0, gl_rect(part, origin), 0, moved);
    if (uploaded && two_planes)
        uploaded = up_->to_texture(set.planes.low(), 0, gl_rect(part, origin), plane_bytes, moved);
    if (uploaded && !stale.empty()) {
        uploaded = up_->to_texture(set.slopes.texture(), 0, gl_rect(stale, origin), codes_bytes, moved);
        stats_->derive.texels += static_cast<std::uint64_t>(stale.count());
        stats_->derive.bytes += size - codes_bytes;
    }
    up_->end();
    return uploaded;
}

void GpuTiles::note_codes(Tile& filled, const TexelRect& part, const DetailField& field) {
    for_each_page(pages_of(part), [&](PageIndex at) {
        const TexelRect page = texels_of(at), here = intersection(page, part);
        const PageCodes* codes = field.find(at);
        filled.bounds.put(here, range_in(codes, at, here));
    });
    if (filled.reading) filled.reading->stamped_since = bounds_of(filled.reading->stamped_since, part);
}

// ---- stamps ----

namespace {

bool may_saturate_in(const TexelRect& interior, const CodeBounds& bounds, const PreparedStamp& stamp) {
    // Of the interior alone: texels of the apron are counted by their own tiles, and their bounds never narrow.
    const CodeBounds::Range old = bounds.query(intersection(stamp.rect(), interior));
    return old.min <= old.max && range_after(stamp, old.min, old.max).may_saturate;
}

/// `rect`: of the stamp, not empty.
void widen_by(const PreparedStamp& stamp, const TexelRect& rect, CodeBounds& bounds) {
    // Smooth reads one texel further, whose codes may then spread into the rectangle.
    const CodeBounds::Range old = bounds.query(expanded(rect, 1));
    const StampRange range = range_after(stamp, old.min, old.max);
    bounds.widen(rect, {range.min, range.max});
}

}  // namespace

bool GpuTiles::may_saturate(TileIndex index, const PreparedStamp& stamp) const {
    return may_saturate_in(settings_.pool.grid.interior(index), tile(index).bounds, stamp);
}

std::size_t GpuTiles::first_that_may_saturate(std::span<const PreparedStamp> stamps,
                                              std::span<const TileIndex> tiles) const {
    std::size_t first = stamps.size();
    for (const TileIndex index : tiles) {
        const TexelRect interior = settings_.pool.grid.interior(index);
        CodeBounds bounds = tile(index).bounds;
        for (std::size_t i = 0; i < first; ++i) {
            if (may_saturate_in(interior, bounds, stamps[i])) first = i;
            const TexelRect rect = intersection(stamps[i].rect(), interior);
            if (!rect.empty()) widen_by(stamps[i], rect, bounds);
        }
    }
    return first;
}

Result<void> GpuTiles::stamp(std::span<const PreparedStamp> stamps, std::span<const TileIndex> tiles,
                             std::size_t& applied) {
    applied = 0;
    TILTH_EXPECTS(deformer_ != nullptr, "executor cpu stamps the field and fills the tiles from it");
    std::vector<DeformTarget> targets;
    for (const TileIndex index : tiles)
        targets.push_back({&tile(index).set->planes, settings_.pool.grid.interior(index)});

    std::vector<DeformStamp> list;
    for (const PreparedStamp& stamp : stamps) {
        list.push_back({.prepared = stamp});
        for (const TileIndex index : tiles) {
            Tile& stamped = tile(index);
            const TexelRect rect = intersection(stamp.rect(), stamped.set->planes.held());
            if (rect.empty()) continue;
            note(rect);
            list.back().may_saturate = list.back().may_saturate || may_saturate(index, stamp);
            widen_by(stamp, rect, stamped.bounds);
            if (stamped.reading) stamped.reading->stamped_since = bounds_of(stamped.reading->stamped_since, rect);
        }
    }
    Result<void> drawn;
    {
        const gl::StageClock clock(stats_->deform);
        drawn = deformer_->apply(list, targets, stats_->deform, applied);
    }
    const gl::StageClock clock(stats_->derive);
    std::vector<TexelRect> changed;
    for (std::size_t i = 0; i < applied; ++i) changed.push_back(stamps[i].rect());
    std::vector<SlopeTarget> derived;
    for (const TileIndex index : tiles)
        derived.push_back({&tile(index).set->planes, &tile(index).set->slopes, changed});
    if (SlopePass* const pass = slope_pass()) pass->run(derived, stats_->derive);
    return drawn;
}

void GpuTiles::exchange(TileIndex from, TileIndex to, const TexelRect& rect) {
    TILTH_EXPECTS(deformer_ != nullptr, "executor cpu fills aprons from the field");
    const Tile& owner = tile(from);
    Tile& other = tile(to);
    const TexelRect part = intersection(intersection(rect, owner.set->planes.held()), other.set->planes.held());
    if (part.empty()) return;
    note(part);
    const std::vector<const gl::Texture2D*> sources = owner.set->planes.targets(), copies = other.set->planes.targets();
    const gl::Rect to_rect = gl_rect(part, other.set->planes.origin());
    const gl::CopyRect copy{gl_rect(part, owner.set->planes.origin()), to_rect.min_x, to_rect.min_y};
    for (std::size_t p = 0; p < sources.size(); ++p) copy_.run(*sources[p], *copies[p], {&copy, 1});
    other.bounds.widen(part, owner.bounds.query(part));
    if (other.reading) other.reading->stamped_since = bounds_of(other.reading->stamped_since, part);
    const gl::StageClock clock(stats_->derive);
    if (SlopePass* const pass = slope_pass())
        pass->run({&part, 1}, other.set->planes, other.set->slopes, stats_->derive, stats_->mips);
}

// ---- codes to the CPU ----

std::vector<GpuTiles::Slice> GpuTiles::slices(std::span<const TexelRect> rects, const TexelRect& held) const {
    const auto most = static_cast<std::int64_t>(settings_.slot_bytes / code_bytes());  // texels
    std::vector<Slice> made;
    std::int64_t left = 0;
    const auto add = [&](const TexelRect& piece) {
        if (piece.count() > left) made.emplace_back(), left = most;
        made.back().push_back(piece);
        left -= piece.count();
    };
    for (const TexelRect& rect : rects) {
        const TexelRect part = intersection(rect, held);
        if (part.empty()) continue;
        const auto columns = static_cast<std::int32_t>(std::min<std::int64_t>(part.width(), most));
        const auto rows = static_cast<std::int32_t>(std::max<std::int64_t>(1, most / columns));
        for (std::int32_t z = part.min.z; z < part.max.z; z += rows)
            for (std::int32_t x = part.min.x; x < part.max.x; x += columns)
                add(intersection(part, {{x, z}, {x + columns, z + rows}}));
    }
    std::reverse(made.begin(), made.end());
    return made;
}

bool GpuTiles::begin_slice(Tile& read) {
    std::vector<ReadBackRing::Piece> pieces;
    const Slice& slice = read.reading->waiting.back();
    for (const gl::Texture2D* plane : read.set->planes.targets())
        for (const TexelRect& rect : slice) pieces.push_back({plane, gl_rect(rect, read.set->planes.origin())});
    const std::optional<std::uint64_t> ticket = down_->begin(pieces, stats_->transfer);
    if (!ticket) return false;
    read.reading->in_flight.emplace_back(*ticket, slice);
    read.reading->waiting.pop_back();
    return true;
}

bool GpuTiles::begin_read_back(TileIndex index, std::span<const TexelRect> rects) {
    Tile& read = tile(index);
    TILTH_EXPECTS(!read.reading, "two read-backs of a tile at a time");
    if (!down_) {
        Result<ReadBackRing> ring = ReadBackRing::create(*device_, settings_.slot_bytes, settings_.slots);
        if (!ring) {
            report(ring.error());
            return false;
        }
        down_.emplace(std::move(*ring));
    }
    read.reading.emplace();
    read.reading->waiting = slices(rects, read.set->planes.held());
    if (!read.reading->waiting.empty() && !begin_slice(read)) {
        read.reading.reset();
        return false;
    }
    while (!read.reading->waiting.empty() && begin_slice(read)) continue;
    return true;
}

ReadBackState GpuTiles::poll_read_back(TileIndex index, DetailField& field) {
    Tile& read = tile(index);
    if (!read.reading) return ReadBackState::None;
    ReadBack& reading = *read.reading;
    bool failed = false;
    std::erase_if(reading.in_flight, [&](const auto& slice) {
        if (failed) return false;
        const ReadBackRing::State state =
            down_->poll(slice.first, [&](std::span<const std::byte> bytes) { take(slice.second, bytes, read, field); });
        failed = state == ReadBackRing::State::Failed;
        return state != ReadBackRing::State::Pending;
    });
    if (failed) {
        for (const auto& [ticket, slice] : reading.in_flight) down_->cancel(ticket);
        read.reading.reset();
        return ReadBackState::Failed;
    }
    while (!reading.waiting.empty() && begin_slice(read)) continue;
    if (!reading.waiting.empty() || !reading.in_flight.empty()) return ReadBackState::Pending;
    read.reading.reset();
    return ReadBackState::Done;
}

void GpuTiles::take(const Slice& slice, std::span<const std::byte> bytes, Tile& read, DetailField& field) {
    std::size_t texels = 0;
    for (const TexelRect& rect : slice) texels += static_cast<std::size_t>(rect.count());
    const bool two_planes = read.set->planes.targets().size() == 2;
    std::size_t first = 0;
    for (const TexelRect& rect : slice) {
        const auto count = static_cast<std::size_t>(rect.count());
        arrived_.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            std::uint16_t high = 0, low = 0;
            std::memcpy(&high, bytes.data() + (first + i) * sizeof high, sizeof high);
            if (two_planes) std::memcpy(&low, bytes.data() + (texels + first + i) * sizeof low, sizeof low);
            arrived_[i] = std::uint32_t{high} << 16 | low;
        }
        const CodeView codes{arrived_.data(), static_cast<std::size_t>(rect.width()), rect};
        scatter(codes, field);
        narrow(read, codes);
        first += count;
    }
}

/// The bounds of what has just been read; of a page that changed since the reading began they would be out of date.
void GpuTiles::narrow(Tile& read, const CodeView& codes) {
    for_each_page(pages_of(codes.rect), [&](PageIndex at) {
        const TexelRect page = texels_of(at), here = intersection(page, codes.rect);
        const bool older = read.reading && !intersection(read.reading->stamped_since, page).empty();
        if (!older) read.bounds.put(here, range_of(codes, here));
    });
}

void GpuTiles::read_back_now(TileIndex index, std::span<const TexelRect> rects, DetailField& field) {
    Tile& read = tile(index);
    for (const TexelRect& rect : rects) {
        const TexelRect part = intersection(rect, read.set->planes.held());
        if (part.empty()) continue;
        const auto stride = static_cast<std::size_t>(part.width());
        arrived_.resize(static_cast<std::size_t>(part.count()));
        read.set->planes.read_back(part, arrived_.data(), stride, stats_->transfer);
        const CodeView codes{arrived_.data(), stride, part};
        scatter(codes, field);
        narrow(read, codes);
    }
}

void GpuTiles::finish() { device_->gl().Finish(); }

// ---- reports ----

const gl::Texture2D* GpuTiles::slopes_of(TileIndex index) const {
    const TileSet* set = pool_.find(index);
    return set != nullptr ? &set->slopes.texture() : nullptr;
}

std::vector<std::uint32_t> GpuTiles::codes(TileIndex index, const TexelRect& rect) const {
    gl::TransferStats unwanted;
    std::vector<std::uint32_t> read(static_cast<std::size_t>(rect.count()));
    tile(index).set->planes.read_back(rect, read.data(), static_cast<std::size_t>(rect.width()), unwanted);
    return read;
}

std::uint64_t GpuTiles::working_bytes() const {
    return (up_ ? up_->bytes() : 0) + (down_ ? down_->bytes() : 0) + (slope_pass_ ? slope_pass_->bytes() : 0);
}

Result<void> GpuTiles::reload(gl::ShaderLibrary& shaders) {
    return slope_pass_ ? slope_pass_->reload(shaders) : Result<void>{};
}

}  // namespace tilth
