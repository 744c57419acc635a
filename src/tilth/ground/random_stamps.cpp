#include "tilth/ground/random_stamps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tilth/core/checks.h"

namespace tilth {

std::uint64_t SplitMix64::next() {
    std::uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

double SplitMix64::unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

std::vector<StampRequest> random_stamps(const RandomStamps& settings, const Ground& ground) {
    TILTH_EXPECTS(!settings.shapes.empty() && !settings.rules.empty(), "random stamps need shapes and rules");
    SplitMix64 random{settings.seed};
    const auto choose = [&](const auto& from) {
        const auto index = static_cast<std::size_t>(random.unit() * static_cast<double>(from.size()));
        return from[std::min(index, from.size() - 1)];
    };
    const double largest = std::max(std::abs(settings.amplitude_m[0]), std::abs(settings.amplitude_m[1]));
    const GridSpec& coarse = ground.map(MapKind::Coarse).grid;

    std::vector<StampRequest> stamps;
    stamps.reserve(static_cast<std::size_t>(std::max<std::int64_t>(0, settings.count)));
    for (std::int64_t i = 0; i < settings.count; ++i) {
        StampRequest stamp{.map = settings.map};
        stamp.centre.x = random.between(settings.region[0].x, settings.region[1].x);
        stamp.centre.z = random.between(settings.region[0].z, settings.region[1].z);
        stamp.radius_m = random.between(settings.radius_m[0], settings.radius_m[1]);
        stamp.amplitude_m = random.between(settings.amplitude_m[0], settings.amplitude_m[1]);
        stamp.shape = choose(settings.shapes);
        stamp.rule = choose(settings.rules);
        stamp.rotation_rad = random.between(0, 2 * std::numbers::pi);
        stamp.mirror = random.unit() >= 0.5;
        if (stamp.rule == StampRule::Smooth)
            stamp.amplitude_m = largest > 0 ? std::min(1.0, std::abs(stamp.amplitude_m) / largest) : 0;
        if (stamp.rule == StampRule::Min || stamp.rule == StampRule::Max || stamp.rule == StampRule::Set) {
            if (ground.settled_map(stamp) == MapKind::Coarse) {
                const PostPos p = coarse.posts(stamp.centre);
                const auto nearest = [](double post, std::int32_t count) {
                    return static_cast<std::int32_t>(std::clamp(std::floor(post + 0.5), 0.0, count - 1.0));
                };
                stamp.level_m = ground.original_height_m({nearest(p.x, coarse.width), nearest(p.z, coarse.depth)});
            }
        }
        stamps.push_back(stamp);
    }
    return stamps;
}

}  // namespace tilth
