// Compares a picture with the one that was accepted by eye, and lays both and their difference side by side.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tilth/io/png.h"

namespace tilth::test {

/// How far two pictures of one size are apart. Steps are those of 8 bits: 1 is 1/255.
struct PictureDistance {
    double mean_steps = 0;     ///< mean absolute difference over all channels of all pixels
    double share_far_off = 0;  ///< share of pixels of which some channel differs by more than kFarOffSteps
};

inline constexpr int kFarOffSteps = 8;

/// What two rasterisers may make of the same triangles: another rounding everywhere, another pixel along an edge.
inline constexpr double kMeanStepsAllowed = 0.5, kShareFarOffAllowed = 0.002;

inline bool alike(const PictureDistance& d) {
    return d.mean_steps <= kMeanStepsAllowed && d.share_far_off <= kShareFarOffAllowed;
}

inline bool same_size(const io::Rgb8Picture& a, const io::Rgb8Picture& b) {
    return a.width == b.width && a.height == b.height && a.pixels.size() == b.pixels.size();
}

/// Both have the same size and at least one pixel.
inline PictureDistance distance_between(const io::Rgb8Picture& a, const io::Rgb8Picture& b) {
    std::uint64_t sum = 0, far_off = 0;
    for (std::size_t i = 0; i < a.pixels.size(); i += 3) {
        int largest = 0;
        for (std::size_t c = i; c < i + 3; ++c) {
            const int steps = std::abs(int(a.pixels[c]) - int(b.pixels[c]));
            sum += std::uint64_t(steps);
            largest = std::max(largest, steps);
        }
        far_off += largest > kFarOffSteps ? 1 : 0;
    }
    return {double(sum) / double(a.pixels.size()), double(far_off) / (double(a.pixels.size()) / 3)};
}

/// Absolute differences, sixteen times as bright so that the eye finds them.
inline io::Rgb8Picture difference_of(const io::Rgb8Picture& a, const io::Rgb8Picture& b) {
    io::Rgb8Picture d{a.width, a.height, std::vector<std::uint8_t>(a.pixels.size())};
    for (std::size_t i = 0; i < d.pixels.size(); ++i)
        d.pixels[i] = std::uint8_t(std::min(255, 16 * std::abs(int(a.pixels[i]) - int(b.pixels[i]))));
    return d;
}

/// Writes NAME.actual.png, NAME.expected.png and NAME.difference.png into `folder`; their paths for a message.
inline std::string leave_side_by_side(const std::filesystem::path& folder, const std::string& name,
                                      const io::Rgb8Picture& actual, const io::Rgb8Picture& expected) {
    std::string paths;
    const auto leave = [&](const char* what, const io::Rgb8Picture& picture) {
        const std::string path = (folder / (name + "." + what + ".png")).string();
        const auto written = io::write_png_rgb8(path, picture.width, picture.height, picture.pixels);
        paths += "\n  " + std::string(what) + ": " + (written ? path : written.error().message);
    };
    leave("actual", actual);
    leave("expected", expected);
    if (same_size(actual, expected)) leave("difference", difference_of(actual, expected));
    return paths;
}

}  // namespace tilth::test
