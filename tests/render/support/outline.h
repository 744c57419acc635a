// The ground's outline against the sky, and grounds whose outline tells something.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "render/support/brute_force_mesh.h"
#include "tilth/render/detail_view.h"

namespace tilth::test {

/// A smooth hill in the map's middle; posts 1 m apart.
inline Mountains smooth_hill(std::int32_t size, double peak_m = 60, double sigma_m = 90) {
    const HeightCodec codec = HeightCodec::for_range(0, 64);
    HeightField field(size, size);
    const double middle = (size - 1) / 2.0;
    for (std::int32_t z = 0; z < size; ++z)
        for (std::int32_t x = 0; x < size; ++x) {
            const double r2 = (x - middle) * (x - middle) + (z - middle) * (z - middle);
            field.set_code({x, z},
                           codec.code(peak_m * std::exp(-r2 / (2 * sigma_m * sigma_m)), HeightPrecision::bits32));
        }
    return {codec, field};
}

/// Pixels that are ground in one of two pictures alone: the area between the outlines.
inline int outline_difference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
    int differing = 0;
    for (std::size_t p = 0; p < a.size(); p += 4) differing += is_magenta(&a[p]) != is_magenta(&b[p]);
    return differing;
}

/// No detail tiles; curved triangles.
inline DetailView curved(double shape, double edge_px = PhongSettings{}.edge_px) {
    DetailView view;
    view.settings.phong = {.on = true, .shape = shape, .edge_px = edge_px};
    return view;
}

}  // namespace tilth::test
