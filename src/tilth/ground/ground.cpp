#include "tilth/ground/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "tilth/core/hash.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/detail_hash.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/ground/turn.h"
#include "tilth/source/mirrored_source.h"
#include "tilth/world/tile_grid.h"

namespace tilth {
namespace {

constexpr std::int32_t kMirroredPosts = 1 << 20;
constexpr double kLargestOrigin = 1e9;         // metres
constexpr double kLargestCentre = 1e10;        // metres: 2^-24 m in 64 bits reach 5e11
constexpr double kFixedPerMetre = 16777216.0;  // 2^24
constexpr double kLargestRadiusTexels = 8192;
constexpr std::uint32_t kLargestRadius = 8192u << 18;  // of a record, 2^-18 texel
constexpr double kCoarseRadiusPosts = 8;               // `auto` takes the coarse map from here on

Error invalid(std::string message) { return {ErrorCode::InvalidArgument, std::move(message)}; }

bool is_power_of_two(double value) {
    int exponent = 0;
    return std::isfinite(value) && value > 0 && std::frexp(value, &exponent) == 0.5;
}

Result<void> check_settings(const GroundSettings& s) {
    if (!(std::abs(s.origin.x) <= kLargestOrigin && std::abs(s.origin.z) <= kLargestOrigin))
        return invalid(text("origin: (", s.origin.x, ", ", s.origin.z, ") is not within 1e9 m of zero"));
    if (!(s.spacing_m >= 1e-3 && s.spacing_m <= 1e5))
        return invalid(text("spacing: ", s.spacing_m, " m is not in [0.001, 100000]"));
    if (s.quantum_m && !(is_power_of_two(*s.quantum_m) && *s.quantum_m >= std::ldexp(1.0, -20) && *s.quantum_m <= 1024))
        return invalid(text("quantum: ", *s.quantum_m, " m is not a power of two in [2^-20, 1024]"));
    if (s.texels_per_post < 1 || s.texels_per_post > 64)
        return invalid(text("texels_per_post: ", s.texels_per_post, " is not in 1..64"));
    if (s.tile_size < 64 || s.tile_size > 8192 || s.tile_size % 64 != 0)
        return invalid(text("tile_size: ", s.tile_size, " is not a multiple of 64 in 64..8192"));
    return {};
}

// Height on the triangles of one map: cells split along the diagonal from (i, j) to (i + 1, j + 1).
template <class CodeAt>
double interpolated_m(const MapGeometry& map, WorldPos at, const CodeAt& code_at) {
    const PostPos p = map.grid.posts(at);
    const double x = std::clamp(p.x, 0.0, map.grid.width - 1.0), z = std::clamp(p.z, 0.0, map.grid.depth - 1.0);
    const auto i = std::min(static_cast<std::int32_t>(x), map.grid.width - 2);
    const auto j = std::min(static_cast<std::int32_t>(z), map.grid.depth - 2);
    const double u = x - i, v = z - j;
    const auto height = [&](std::int32_t di, std::int32_t dj) {
        return map.codec.height_m(code_at(Texel{i + di, j + dj}));
    };
    const double here = height(0, 0), across = height(1, 1);
    if (u >= v) {
        const double east = height(1, 0);
        return here + u * (east - here) + v * (across - east);
    }
    const double south = height(0, 1);
    return here + v * (south - here) + u * (across - south);
}

// The code of a coarse post before any stamp; `post` is clamped to the map.
std::uint32_t code_before(const HeightSource& source, const MapGeometry& map, bool mirror, Texel post) {
    Texel t{std::clamp(post.x, 0, map.grid.width - 1), std::clamp(post.z, 0, map.grid.depth - 1)};
    if (mirror) t = {mirrored_index(t.x, source.width()), mirrored_index(t.z, source.depth())};
    return map.codec.code(source.height_m(t), map.precision);
}

}  // namespace

Ground::Ground(std::shared_ptr<const HeightSource> source, const GroundSettings& settings, MapGeometry coarse_map,
               MapGeometry detail_map)
    : source_(std::move(source)),
      settings_(settings),
      coarse_map_(coarse_map),
      detail_map_(detail_map),
      coarse_(source_->width(), source_->depth()) {
    for (std::int32_t z = 0; z < coarse_.depth(); ++z)
        for (std::int32_t x = 0; x < coarse_.width(); ++x) coarse_.set_code({x, z}, original_code({x, z}));
}

Result<std::unique_ptr<Ground>> Ground::create(std::shared_ptr<const HeightSource> source,
                                               const GroundSettings& settings) {
    TILTH_ASSERT(source != nullptr, "a ground needs a height source");
    if (const Result<void> checked = check_settings(settings); !checked) return checked.error();
    if (source->width() < 2 || source->depth() < 2 || source->width() > 16384 || source->depth() > 16384)
        return invalid(
            text("heights: ", source->width(), " x ", source->depth(), " posts; 2..16384 a side are allowed"));

    HeightCodec codec = HeightCodec::for_range(source->min_m(), source->max_m());
    if (settings.quantum_m) {
        codec.quantum_m = *settings.quantum_m;
        if (source->min_m() < codec.min_m() || source->max_m() > codec.max_m())
            return invalid(text("quantum: heights from ", source->min_m(), " to ", source->max_m(),
                                " m do not fit 65536 steps of ", codec.quantum_m, " m; take a larger power of two"));
    }
    MapGeometry coarse{.kind = MapKind::Coarse, .codec = codec, .precision = settings.precision};
    coarse.grid = {.origin = settings.origin,
                   .spacing_m = settings.spacing_m,
                   .width = settings.mirror ? kMirroredPosts : source->width(),
                   .depth = settings.mirror ? kMirroredPosts : source->depth()};
    MapGeometry detail{.kind = MapKind::Detail, .codec = HeightCodec::detail(), .precision = settings.precision};
    detail.grid = {.origin = settings.origin,
                   .spacing_m = settings.spacing_m / settings.texels_per_post,
                   .width = (coarse.grid.width - 1) * settings.texels_per_post + 1,
                   .depth = (coarse.grid.depth - 1) * settings.texels_per_post + 1};
    return std::unique_ptr<Ground>(new Ground(std::move(source), settings, coarse, detail));
}

MapKind Ground::settled_map(const StampRequest& request) const {
    if (request.map != MapChoice::Auto) return request.map == MapChoice::Detail ? MapKind::Detail : MapKind::Coarse;
    const bool resolved_by_coarse = request.radius_m >= kCoarseRadiusPosts * settings_.spacing_m;
    return settings_.detail && !resolved_by_coarse ? MapKind::Detail : MapKind::Coarse;
}

Result<StampRecord> Ground::issue(const StampRequest& request) {
    if (request.shape.value >= shapes_.size())
        return invalid(text("shape: ", request.shape.value, " is not in the shape library of ", shapes_.size()));
    if (!(std::abs(request.centre.x) <= kLargestCentre && std::abs(request.centre.z) <= kLargestCentre))
        return invalid(text("centre: (", request.centre.x, ", ", request.centre.z, ") is not within 1e10 m of zero"));
    if (!(request.radius_m > 0) || !std::isfinite(request.radius_m))
        return invalid(text("radius: ", request.radius_m, " m is not above 0"));
    if (!std::isfinite(request.rotation_rad))
        return invalid(text("rotation: ", request.rotation_rad, " is not finite"));

    if (request.map > MapChoice::Detail) return invalid(text("map: ", static_cast<int>(request.map), " is no map"));
    if (request.rule > StampRule::Smooth) return invalid(text("rule: ", static_cast<int>(request.rule), " is no rule"));
    const MapKind kind = settled_map(request);
    if (kind == MapKind::Detail && !settings_.detail) return invalid("map: this world has no detail map");
    if (kind == MapKind::Coarse && settings_.mirror)
        return invalid("map: a mirrored world takes no coarse stamps; use the detail map");
    const MapGeometry& target = map(kind);

    const double radius_texels = request.radius_m / target.grid.spacing_m;
    if (!(radius_texels < kLargestRadiusTexels))
        return invalid(text("radius: ", request.radius_m, " m is ", radius_texels, " texels of the ",
                            kind == MapKind::Coarse ? "coarse" : "detail", " map; it must be below 8192 (",
                            kLargestRadiusTexels * target.grid.spacing_m, " m)"));

    StampRecord record{.map = kind, .rule = request.rule, .mirror = request.mirror ? std::uint8_t{1} : std::uint8_t{0}};
    record.negative = request.amplitude_m < 0 ? 1 : 0;
    double steps = std::abs(request.amplitude_m) / target.codec.code_quantum_m();
    if (request.rule == StampRule::Smooth) {
        if (!(request.amplitude_m >= 0 && request.amplitude_m <= 1))
            return invalid(text("amplitude: ", request.amplitude_m, " is not in [0, 1], which smooth needs"));
        steps = request.amplitude_m * kWeightOne;
    }
    if (!(steps <= 4294967295.0))
        return invalid(text("amplitude: ", request.amplitude_m, " m is not within the map's range of ",
                            65536 * target.codec.quantum_m, " m"));
    record.amplitude = static_cast<std::uint32_t>(std::floor(steps + 0.5 < 4294967296.0 ? steps + 0.5 : steps));

    const bool uses_level =
        request.rule == StampRule::Min || request.rule == StampRule::Max || request.rule == StampRule::Set;
    if (uses_level) {
        if (!request.level_m && kind == MapKind::Coarse)
            return invalid("level: min, max and set on the coarse map need a level, an absolute height in metres");
        const double level = request.level_m.value_or(0.0);
        if (!(level >= target.codec.min_m() && level <= target.codec.max_m()))
            return invalid(text("level: ", level, " m is not in the map's range of ", target.codec.min_m(), " to ",
                                target.codec.max_m(), " m"));
        record.level = target.codec.code(level, HeightPrecision::bits32);
    } else if (request.level_m && !std::isfinite(*request.level_m)) {
        return invalid(text("level: ", *request.level_m, " is not finite"));
    }

    record.radius = static_cast<std::uint32_t>(std::floor(radius_texels * 262144 + 0.5));
    record.centre_x = std::llround(request.centre.x * kFixedPerMetre);
    record.centre_z = std::llround(request.centre.z * kFixedPerMetre);
    record.shape = request.shape.value;
    record.shape_hash = shapes_.shape(request.shape).hash;
    record.rotation = turns_of(request.rotation_rad);
    record.sequence = next_sequence_++;
    record.key = request.key.value_or(static_cast<std::uint32_t>(SplitMix64{record.sequence}.next() >> 32));
    return record;
}

Result<void> Ground::check(const StampRecord& record) const {
    if (record.shape >= shapes_.size())
        return invalid(text("shape: ", record.shape, " is not in the shape library of ", shapes_.size()));
    if (record.shape_hash != shapes_.shape({record.shape}).hash)
        return invalid(text("shape: '", shapes_.shape({record.shape}).name,
                            "' has other data here than when the record was made"));
    if (record.map > MapKind::Detail) return invalid(text("map: ", static_cast<int>(record.map), " is no map"));
    if (record.map == MapKind::Detail && !settings_.detail) return invalid("map: this world has no detail map");
    if (record.map == MapKind::Coarse && settings_.mirror)
        return invalid("map: a mirrored world takes no coarse stamps");
    if (record.rule > StampRule::Smooth) return invalid(text("rule: ", static_cast<int>(record.rule), " is no rule"));
    if (record.negative > 1) return invalid(text("negative: ", int{record.negative}, " is not 0 or 1"));
    if (record.mirror > 1) return invalid(text("mirror: ", int{record.mirror}, " is not 0 or 1"));
    if (record.reserved != 0) return invalid(text("reserved: ", record.reserved, " is not 0"));
    if (record.rule == StampRule::Smooth && record.amplitude > static_cast<std::uint32_t>(kWeightOne))
        return invalid(text("amplitude: ", record.amplitude, " is above 65536, the most that smooth takes"));
    if (record.radius > kLargestRadius) return invalid(text("radius: ", record.radius, " is above 8192 texels"));
    constexpr auto kFarthest = static_cast<std::int64_t>(kLargestCentre * kFixedPerMetre);
    for (const std::int64_t centre : {record.centre_x, record.centre_z})
        if (centre > kFarthest || centre < -kFarthest)
            return invalid(text("centre: ", centre, " is not within 1e10 m of zero"));
    return {};
}

Result<void> Ground::accept(const StampRecord& record) {
    const Result<void> checked = check(record);
    if (checked) next_sequence_ = std::max(next_sequence_, record.sequence + 1);
    return checked;
}

ApplyResult Ground::apply(const StampRecord& record) {
    const Result<void> checked = check(record);
    TILTH_ASSERT(checked.ok(), checked.error().message);
    const PreparedStamp stamp = prepare(record, map(record.map), shapes_);
    if (record.map == MapKind::Detail) return apply_stamp(stamp, detail_, detail_map_.grid.rect());
    return apply_stamp(stamp, coarse_);
}

std::uint32_t Ground::coarse_code(Texel post) const {
    const GridSpec& grid = coarse_map_.grid;
    const Texel t{std::clamp(post.x, 0, grid.width - 1), std::clamp(post.z, 0, grid.depth - 1)};
    if (!settings_.mirror) return coarse_.code(t);
    return coarse_.code({mirrored_index(t.x, coarse_.width()), mirrored_index(t.z, coarse_.depth())});
}

double Ground::height_m(WorldPos at, MapSelect select) const {
    if (std::isnan(at.x) || std::isnan(at.z)) return std::numeric_limits<double>::quiet_NaN();
    double height = 0;
    if (select != MapSelect::Detail) height += interpolated_m(coarse_map_, at, [&](Texel t) { return coarse_code(t); });
    if (select != MapSelect::Coarse && settings_.detail && !detail_.pages().empty())
        height += interpolated_m(detail_map_, at, [&](Texel t) { return detail_.code(t); });
    return height;
}

double Ground::original_height_m(Texel post) const { return coarse_map_.codec.height_m(original_code(post)); }

std::uint32_t Ground::original_code(Texel post) const {
    return code_before(*source_, coarse_map_, settings_.mirror, post);
}

std::function<std::uint32_t(Texel)> Ground::original_codes() const {
    return [source = source_, map = coarse_map_, mirror = settings_.mirror](Texel post) {
        return code_before(*source, map, mirror, post);
    };
}

std::uint64_t Ground::coarse_hash() const {
    StateHasher coarse;
    coarse.add_u32(coarse_.codes());
    return coarse.digest();
}

StateHash Ground::hash() const {
    StateHasher detail;
    const std::int32_t pages_a_tile = settings_.tile_size / kPageTexels;
    std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Page>> tiles;  // by (z, x)
    for (const auto& [index, codes] : detail_.pages())
        tiles[{floor_divide(index.z, pages_a_tile), floor_divide(index.x, pages_a_tile)}].push_back({index, codes});
    for (auto& [place, pages] : tiles)
        add_tile_to_hash(detail, {place.second, place.first}, settings_.tile_size, std::move(pages));
    return {coarse_hash(), detail.digest()};
}

std::uint64_t Ground::bytes() const {
    return coarse_.codes().size_bytes() + detail_.pages().size() * sizeof(PageCodes);
}

}  // namespace tilth
