// A trail of boot prints as a height field, for pictures.
#pragma once

#include <algorithm>
#include <cmath>

namespace tilth::test {

/// A print about (0, 0), toes along +x, 0.30 m long and 0.11 m wide: sole, heel and tread; 3 cm deep with a low rim.
inline double boot_print_m(double x, double z) {
    const auto pad = [&](double centre, double half_length, double half_width) {
        const double r = std::hypot((x - centre) / half_length, z / half_width);
        return std::clamp((1.15 - r) / 0.3, 0.0, 1.0);
    };
    const double pressed = std::max(pad(0.045, 0.105, 0.055), pad(-0.105, 0.045, 0.040));
    const double tread = 0.006 * (0.5 + 0.5 * std::sin(x * 2 * 3.14159265 / 0.1));
    const double rim = 0.006 * std::exp(-std::pow((std::hypot(x / 0.15, z / 0.075) - 1.15) / 0.15, 2));
    return pressed * (tread - 0.03) + (1 - pressed) * rim;
}

/// Prints every 0.7 m along the line from (x, z) in direction `heading_rad`, left and right foot in turn; 0 elsewhere.
struct Trail {
    double x = 0, z = 0, heading_rad = 0;
    int count = 40;
    double height_m(double px, double pz) const {
        const double c = std::cos(heading_rad), s = std::sin(heading_rad);
        const double along = (px - x) * c + (pz - z) * s, across = (pz - z) * c - (px - x) * s;
        double sum = 0;
        if (std::abs(across) > 0.5) return 0;
        const int near = static_cast<int>(std::floor(along / 0.7));
        for (int i = std::max(near - 1, 0); i <= std::min(near + 1, count - 1); ++i)
            sum += boot_print_m(along - 0.7 * i, across - (i % 2 == 0 ? 0.13 : -0.13));
        return sum;
    }
};

}  // namespace tilth::test
