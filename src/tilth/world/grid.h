// Where the posts of a map lie in the world.
#pragma once

#include <cmath>
#include <cstdint>

#include "tilth/world/texel.h"

namespace tilth {

/// A place on the ground plane, metres. Doubles: 1e7 m from the origin still resolves nanometres.
struct WorldPos {
    double x = 0, z = 0;
    friend bool operator==(const WorldPos&, const WorldPos&) = default;
};

/// A position in posts of one map, as a real number: (1.5, 2) lies half-way between posts (1, 2) and (2, 2).
struct PostPos {
    double x = 0, z = 0;
};

/// The posts of a map: post (i, j) lies at origin + spacing * (i, j), 0 <= i < width, 0 <= j < depth.
struct GridSpec {
    WorldPos origin;         ///< of post (0, 0), metres
    double spacing_m = 1.0;  ///< between neighbouring posts, > 0
    std::int32_t width = 0;  ///< posts along +x, >= 2
    std::int32_t depth = 0;  ///< posts along +z, >= 2

    friend bool operator==(const GridSpec&, const GridSpec&) = default;

    [[nodiscard]] WorldPos world(Texel t) const { return {origin.x + spacing_m * t.x, origin.z + spacing_m * t.z}; }
    [[nodiscard]] PostPos posts(WorldPos p) const {
        return {(p.x - origin.x) / spacing_m, (p.z - origin.z) / spacing_m};
    }
    [[nodiscard]] constexpr TexelRect rect() const { return {{0, 0}, {width, depth}}; }
};

}  // namespace tilth
