// Holes in a picture of the ground that was cleared to magenta.
#pragma once

#include <vector>

#include "render/support/scene.h"

namespace tilth::test {

inline long magenta_pixels(const std::vector<std::uint8_t>& rgba) {
    long count = 0;
    for (std::size_t i = 0; i < rgba.size(); i += 4) count += is_magenta(&rgba[i]);
    return count;
}

/// Pixels of sky that are not connected (8 neighbours) to the picture's border. Above a height field sky is connected
/// upwards, so each of them is a hole.
inline long sky_within_ground(const std::vector<std::uint8_t>& rgba, int width, int height) {
    const long sky = magenta_pixels(rgba);
    if (sky == 0) return 0;
    std::vector<char> open(static_cast<std::size_t>(width * height));
    std::vector<int> queue;
    long outside = 0;
    const auto visit = [&](int x, int y) {
        const std::size_t at = static_cast<std::size_t>(y * width + x);
        if (x < 0 || y < 0 || x >= width || y >= height || open[at] || !is_magenta(&rgba[at * 4])) return;
        open[at] = 1;
        queue.push_back(y * width + x);
    };
    for (int x = 0; x < width; ++x) visit(x, 0), visit(x, height - 1);
    for (int y = 0; y < height; ++y) visit(0, y), visit(width - 1, y);
    while (!queue.empty()) {
        const int at = queue.back();
        queue.pop_back();
        ++outside;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) visit(at % width + dx, at / width + dy);
    }
    return sky - outside;
}

}  // namespace tilth::test
