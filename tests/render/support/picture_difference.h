// How far two RGBA pictures are apart.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace tilth::test {

struct Difference {
    int max = 0;      ///< of any channel, in steps of 1/255
    double mean = 0;  ///< of all channels
};
inline Difference difference_of(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
    Difference d;
    for (std::size_t i = 0; i < a.size(); ++i) {
        d.max = std::max(d.max, std::abs(a[i] - b[i]));
        d.mean += std::abs(a[i] - b[i]) / static_cast<double>(a.size());
    }
    return d;
}

/// Different values of the red channel: a picture of one colour has one.
inline int levels_of_grey(const std::vector<std::uint8_t>& rgba) {
    std::array<bool, 256> seen{};
    for (std::size_t i = 0; i < rgba.size(); i += 4) seen[rgba[i]] = true;
    return static_cast<int>(std::count(seen.begin(), seen.end(), true));
}

}  // namespace tilth::test
