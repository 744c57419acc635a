// A small world and random stamps on it, for tests that compare executors.
#pragma once

#include <memory>
#include <vector>

#include "tilth/ground/ground.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/source/ridged_source.h"

namespace tilth::test {

/// A ridged map of `size` x `size` posts of 1 m with 100 m of relief, and three shapes beside the built-in ones: an
/// image with odd sides, a baked function of both signs, a profile of its own.
inline std::unique_ptr<Ground> small_world(std::int32_t size, HeightPrecision precision) {
    std::unique_ptr<Ground> ground =
        *Ground::create(make_ridged_source({.seed = 3, .size = size, .relief_m = 100}), {.precision = precision});
    SplitMix64 random{11};
    std::vector<std::uint16_t> texels(37 * 23);
    for (std::uint16_t& texel : texels) texel = static_cast<std::uint16_t>(random.next());
    (void)*ground->shapes().add_image("noise", 37, 23, texels);
    (void)*ground->shapes().bake("saddle", 64, [](double x, double z) { return (x * x - z * z) * 0.9; });
    (void)*ground->shapes().add_profile("rim", [](double t) { return (1 - t) * (2 * t - 0.5); });
    return ground;
}

/// Random stamps of every shape and rule; the region reaches 40 m beyond the map, so that many cross its edges.
inline std::vector<StampRecord> random_records(Ground& ground, std::uint64_t seed, std::int64_t count,
                                               double largest_radius_m,
                                               std::vector<StampRule> rules = {StampRule::Add, StampRule::Min,
                                                                               StampRule::Max, StampRule::Set,
                                                                               StampRule::Smooth}) {
    RandomStamps settings{.seed = seed, .count = count, .map = MapChoice::Coarse, .rules = std::move(rules)};
    const double last = ground.coarse().width() - 1.0;
    settings.region = {WorldPos{-40, -40}, WorldPos{last + 40, last + 40}};
    settings.radius_m = {0.3, largest_radius_m};
    settings.amplitude_m = {-3, 3};
    for (std::uint32_t shape = 0; shape < ground.shapes().size(); ++shape) settings.shapes.push_back({shape});
    std::vector<StampRecord> records;
    for (const StampRequest& request : random_stamps(settings, ground)) records.push_back(*ground.issue(request));
    return records;
}

}  // namespace tilth::test
