// Reproducible random stamps, as the scenario step `random` defines them: the same in every build.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tilth/ground/ground.h"

namespace tilth {

/// splitmix64: the state walks by the golden ratio; the output is a bijective mix of it (Steele, Lea, Flood 2014).
struct SplitMix64 {
    std::uint64_t state = 0;
    std::uint64_t next();
    /// (x >> 11) 2^-53, in [0, 1).
    double unit();
    double between(double low, double high) { return low + (high - low) * unit(); }
};

struct RandomStamps {
    std::uint64_t seed = 1;
    std::int64_t count = 0;
    std::array<WorldPos, 2> region;  ///< two corners, metres
    std::array<double, 2> radius_m{1, 1};
    std::array<double, 2> amplitude_m{0, 0};
    MapChoice map = MapChoice::Auto;
    std::vector<ShapeId> shapes;   ///< to choose from, in order; not empty
    std::vector<StampRule> rules;  ///< to choose from, in order; not empty
};

/// The stamps, drawn in the order x, z, radius, amplitude, shape, rule, rotation, mirror for each. `smooth` uses
/// |amplitude| / max |range|; min, max and set on the coarse map take the original height of the post nearest to the
/// centre (clamped to the map) as their level. `ground` settles `Auto` and gives original heights; it is not changed.
std::vector<StampRequest> random_stamps(const RandomStamps& settings, const Ground& ground);

}  // namespace tilth
