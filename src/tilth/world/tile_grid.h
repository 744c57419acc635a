// How the detail map is cut into tiles. Pure integers.
#pragma once

#include <compare>
#include <cstdint>

#include "tilth/world/texel.h"

namespace tilth {

/// A tile by its place in the whole detail map: its interior is texels [x * size, (x + 1) * size) on each axis. Every
/// texel of the map lies in exactly one interior.
struct TileIndex {
    std::int32_t x = 0, z = 0;
    friend auto operator<=>(const TileIndex&, const TileIndex&) = default;
};

/// Quotient rounded down, also for negative numbers (C++ and GLSL round towards zero).
constexpr std::int32_t floor_divide(std::int32_t a, std::int32_t b) {
    const std::int32_t quotient = a / b;
    return a % b != 0 && (a % b < 0) != (b < 0) ? quotient - 1 : quotient;
}
/// Remainder in [0, b), also for negative `a`; b > 0.
constexpr std::int32_t floor_modulo(std::int32_t a, std::int32_t b) {
    const std::int32_t remainder = a % b;
    return remainder < 0 ? remainder + b : remainder;
}

/// The tiles of one map.
///
///     +---------------+  stored: interior and apron, (size + 2 apron)^2 texels; what a tile's textures hold
///     |  +---------+  |
///     |  |interior |  |  apron: texels of the neighbours, so that filtering, slopes and stencils across a border are
///     |  +---------+  |         the same as inside. Every tile that holds a texel holds the same code for it.
///     +---------------+
///
/// Indices are those of texels divided: a map has fewer than 2^31 texels a side, so no two tiles share an index and
/// none wraps.
struct TileGrid {
    std::int32_t size = 2048;  ///< texels a side of the interior, a multiple of 64
    std::int32_t apron = 2;    ///< texels on each side, 0..64
    TexelRect map;             ///< texels of the whole map

    [[nodiscard]] constexpr TileIndex tile_of(Texel t) const {
        return {floor_divide(t.x, size), floor_divide(t.z, size)};
    }
    [[nodiscard]] constexpr TexelRect interior(TileIndex t) const {
        return {{t.x * size, t.z * size}, {t.x * size + size, t.z * size + size}};
    }
    /// The part of the interior that the map has: all but the last tiles are whole.
    [[nodiscard]] constexpr TexelRect inside(TileIndex t) const { return intersection(interior(t), map); }
    [[nodiscard]] constexpr TexelRect stored(TileIndex t) const { return expanded(interior(t), apron); }
    /// Texels a side of a tile's textures.
    [[nodiscard]] constexpr std::int32_t stored_size() const { return size + 2 * apron; }
    /// Whether the tile holds a texel of the map.
    [[nodiscard]] constexpr bool exists(TileIndex t) const {
        return t.x >= 0 && t.z >= 0 && t.x <= (map.max.x - 1) / size && t.z <= (map.max.z - 1) / size;
    }
    friend bool operator==(const TileGrid&, const TileGrid&) = default;
};

/// A rectangle of tiles, both corners inclusive. Empty when max < min on either axis.
struct TileWindow {
    TileIndex min, max{-1, -1};

    friend bool operator==(const TileWindow&, const TileWindow&) = default;
    [[nodiscard]] constexpr std::int32_t columns() const { return max.x < min.x ? 0 : max.x - min.x + 1; }
    [[nodiscard]] constexpr std::int32_t rows() const { return max.z < min.z ? 0 : max.z - min.z + 1; }
    [[nodiscard]] constexpr std::int64_t count() const { return std::int64_t{columns()} * rows(); }
    [[nodiscard]] constexpr bool contains(TileIndex t) const {
        return t.x >= min.x && t.x <= max.x && t.z >= min.z && t.z <= max.z;
    }
};

/// Calls `visit(tile)` for each tile of a window, row by row.
template <class Visit>
constexpr void for_each_tile(const TileWindow& window, const Visit& visit) {
    for (std::int32_t z = window.min.z; z <= window.max.z; ++z)
        for (std::int32_t x = window.min.x; x <= window.max.x; ++x) visit(TileIndex{x, z});
}

/// Calls `visit(tile)` for the eight tiles about one, those beyond the map included.
template <class Visit>
constexpr void for_each_neighbour(TileIndex of, const Visit& visit) {
    for_each_tile({{of.x - 1, of.z - 1}, {of.x + 1, of.z + 1}}, [&](TileIndex index) {
        if (index != of) visit(index);
    });
}

/// Tiles of the map whose interior meets `rect`.
constexpr TileWindow tiles_of(const TileGrid& grid, const TexelRect& rect) {
    const TexelRect inside = intersection(rect, grid.map);
    if (inside.empty()) return {};
    return {grid.tile_of(inside.min), grid.tile_of({inside.max.x - 1, inside.max.z - 1})};
}

/// Tiles of the map whose stored rectangle meets `rect`: those that a change of `rect` must reach, aprons included.
constexpr TileWindow tiles_storing(const TileGrid& grid, const TexelRect& rect) {
    const TexelRect inside = intersection(rect, grid.map);
    return inside.empty() ? TileWindow{} : tiles_of(grid, expanded(inside, grid.apron));
}

}  // namespace tilth
