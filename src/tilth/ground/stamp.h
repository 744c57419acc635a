// Stamps: what a host asks for, in metres, and the plain integer record that the world keeps of it.
#pragma once

#include <cstdint>
#include <optional>

#include "tilth/world/grid.h"

namespace tilth {

/// The two height maps. Ground = coarse + detail.
enum class MapKind : std::uint8_t { Coarse, Detail };

/// Which map a stamp goes to. `Auto`: coarse from a radius of eight posts on, else detail (where there is one).
enum class MapChoice : std::uint8_t { Auto, Coarse, Detail };

/// What a stamp does to a texel, w being the profile's or image's weight there.
enum class StampRule : std::uint8_t {
    Add,     ///< h + amplitude w
    Min,     ///< the smaller of h and level + amplitude w, where w > 0; idempotent
    Max,     ///< the larger of h and level + amplitude w, where w > 0; idempotent
    Set,     ///< h moves towards level + amplitude by weight w
    Smooth,  ///< h moves towards the mean of its eight neighbours by amplitude w, amplitude in 0..1
};

/// A shape of the `ShapeLibrary`: a radial profile or an image.
struct ShapeId {
    std::uint32_t value = 0;
    friend bool operator==(ShapeId, ShapeId) = default;
};

/// A stamp as a host asks for it. Checked by `Ground::issue`, which refuses bad values with the field's name.
struct StampRequest {
    ShapeId shape;             ///< from the world's `ShapeLibrary`
    WorldPos centre;           ///< metres, world space; finite; off the map it does nothing
    double radius_m = 1.0;     ///< > 0, under 8 192 texels of the map; an image covers a square of twice this
    double amplitude_m = 0.0;  ///< metres (for `Smooth` a fraction 0..1); negative digs
    MapChoice map = MapChoice::Auto;
    StampRule rule = StampRule::Add;
    std::optional<double> level_m =
        std::nullopt;           ///< for min, max, set: absolute on the coarse map (required), offset on detail (0)
    double rotation_rad = 0.0;  ///< maps (1, 0) to (cos, -sin); any finite angle
    bool mirror = false;        ///< flips an image along its x axis before it is turned
    std::optional<std::uint32_t> key =
        std::nullopt;  ///< seed of the 16-bit dither; drawn from the sequence number when absent
};

/// A stamp as the world keeps it: fixed size, integers only, nothing in it depends on what lies under it. It can be
/// logged, sent and replayed, and gives the same bits on every machine.
struct StampRecord {
    std::uint64_t sequence = 0;    ///< position in the world's order, from 1
    std::int64_t centre_x = 0;     ///< 2^-24 m, world space
    std::int64_t centre_z = 0;     ///< 2^-24 m, world space
    std::uint64_t shape_hash = 0;  ///< of the shape's table or image: a replay on other data is noticed
    std::uint32_t shape = 0;       ///< `ShapeId::value`
    std::uint32_t radius = 0;      ///< 2^-18 texel of the map, as asked for (not widened)
    std::uint32_t amplitude = 0;   ///< magnitude in height codes; for `Smooth` in 1/65 536
    std::uint32_t level = 0;       ///< height code
    std::uint32_t rotation = 0;    ///< turns / 2^32
    std::uint32_t key = 0;
    MapKind map = MapKind::Coarse;
    StampRule rule = StampRule::Add;
    std::uint8_t negative = 0;   ///< 1: the amplitude is below zero
    std::uint8_t mirror = 0;     ///< 1: mirrored
    std::uint32_t reserved = 0;  ///< zero

    friend bool operator==(const StampRecord&, const StampRecord&) = default;
};
static_assert(sizeof(StampRecord) == 64);

/// The same stamp with its amplitude's sign turned round. For `Add` the two cancel exactly where nothing saturated.
constexpr StampRecord negated(StampRecord record) {
    record.negative ^= 1;
    return record;
}

}  // namespace tilth
