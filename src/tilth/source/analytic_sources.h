// Worlds whose right answers are known in closed form: for tests, benchmarks and pictures that explain something.
#pragma once

#include <vector>

#include "tilth/source/height_source.h"

namespace tilth {

/// The same height everywhere. No memory.
class FlatSource final : public HeightSource {
public:
    /// `size` posts along each side, >= 2; `height_m` finite.
    FlatSource(std::int32_t size, double height_m) : size_(size), height_m_(height_m) {}

    [[nodiscard]] std::int32_t width() const override { return size_; }
    [[nodiscard]] std::int32_t depth() const override { return size_; }
    [[nodiscard]] double min_m() const override { return height_m_; }
    [[nodiscard]] double max_m() const override { return height_m_; }
    [[nodiscard]] double height_m(Texel) const override { return height_m_; }

private:
    std::int32_t size_;
    double height_m_;
};

/// A rise in metres per post, along each axis.
struct PostSlope {
    double x = 0, z = 0;
};

/// One Gaussian hill (or pit, if the peak is negative) about the map's middle m = (size - 1) / 2:
///
///     height(x, z) = peak_m * exp(-((x - m)^2 + (z - m)^2) / (2 sigma^2)),   x, z, sigma in posts
///
/// The same bits on every machine: the exponential is `portable_exp`, and the two axes are factors from a table.
/// Memory: 8 bytes a post of one side.
class HillSource final : public HeightSource {
public:
    /// `size` posts along each side, >= 2; `peak_m` finite; `sigma_posts` finite and > 0.
    HillSource(std::int32_t size, double peak_m, double sigma_posts);

    [[nodiscard]] std::int32_t width() const override { return static_cast<std::int32_t>(factors_.size()); }
    [[nodiscard]] std::int32_t depth() const override { return width(); }
    [[nodiscard]] double min_m() const override { return min_m_; }
    [[nodiscard]] double max_m() const override { return max_m_; }
    [[nodiscard]] double height_m(Texel t) const override;

    /// Height and slope of the formula at any place, in posts, for the test that holds something against it.
    [[nodiscard]] double height_at(double x_posts, double z_posts) const;
    [[nodiscard]] PostSlope slope_at(double x_posts, double z_posts) const;

private:
    double peak_m_, sigma_posts_, middle_posts_;
    std::vector<double> factors_;  // exp of one axis, at each post
    double min_m_, max_m_;
};

}  // namespace tilth
