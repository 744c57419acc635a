// Pages as worlds have them: what codecs and stores are measured on.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tilth/ground/ground.h"
#include "tilth/ground/page.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/world/height_codec.h"

namespace tilth::bench {

enum class SampleKind {
    Prints,    ///< detail: trails of boot prints, rule min, 17 cm
    Adds,      ///< detail: scattered gaussian mounds and holes, rule add, 0.1 to 1 m
    Craters,   ///< detail: craters of 0.5 to 3 m, rule add
    Dense,     ///< detail: hundreds of stamps of any shape, rule and angle over each other
    Heights,   ///< coarse: ridged mountains as they came, 200 m of relief
    Battered,  ///< coarse: the same under craters
    Uniform,   ///< detail: one code all over
};
const char* name_of(SampleKind kind);

/// A sole and a heel, smooth at the rim: the shape "boot", for `ShapeLibrary::bake`.
inline constexpr std::int32_t kBootTexels = 64;
double boot_weight(double x, double z);

/// A walk to and fro over all of a map.
struct Trail {
    std::int64_t prints = 1000;
    double stride_m = 0.75;
    double radius_m = 0.17;
    double lanes_m = 4;  ///< between going and coming back
};
/// Its boot prints, rule min, 3 cm deep, left and right in turn. The library of `ground` gets the shape "boot" if it
/// lacks it.
std::vector<StampRequest> trail_of_prints(Ground& ground, const Trail& trail);
/// A ground of texels of 1/30 m in tiles of 2 048, as the reference's, over `posts` posts 0.1 m apart.
std::unique_ptr<Ground> flat_ground(std::int32_t posts, HeightPrecision precision = HeightPrecision::bits32);

/// `count` pages, the same in every run and on every machine.
std::vector<Page> sample_pages(SampleKind kind, HeightPrecision precision, std::size_t count);

}  // namespace tilth::bench
