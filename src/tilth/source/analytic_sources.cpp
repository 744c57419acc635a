#include "tilth/source/analytic_sources.h"

#include <algorithm>

#include "tilth/source/portable_exp.h"

namespace tilth {

HillSource::HillSource(std::int32_t size, double peak_m, double sigma_posts)
    : peak_m_(peak_m), sigma_posts_(sigma_posts), middle_posts_((size - 1) * 0.5) {
    factors_.reserve(static_cast<std::size_t>(size));
    for (std::int32_t i = 0; i < size; ++i) {
        const double s = (i - middle_posts_) / sigma_posts_;
        factors_.push_back(portable_exp(-0.5 * s * s));
    }
    // A rounded product of non-negative factors is monotonic in each, so the extremes are those of the factors.
    const auto [low, high] = std::minmax_element(factors_.begin(), factors_.end());
    const double at_rim = peak_m_ * *low * *low, at_top = peak_m_ * *high * *high;
    min_m_ = std::min(at_rim, at_top);
    max_m_ = std::max(at_rim, at_top);
}

double HillSource::height_m(Texel t) const {
    TILTH_EXPECTS((TexelRect{{0, 0}, {width(), depth()}}.contains(t)),
                  text("texel (", t.x, ", ", t.z, ") lies outside ", width(), " x ", depth(), " posts"));
    return peak_m_ * factors_[static_cast<std::size_t>(t.x)] * factors_[static_cast<std::size_t>(t.z)];
}

double HillSource::height_at(double x_posts, double z_posts) const {
    const double sx = (x_posts - middle_posts_) / sigma_posts_, sz = (z_posts - middle_posts_) / sigma_posts_;
    return peak_m_ * portable_exp(-0.5 * (sx * sx + sz * sz));
}

PostSlope HillSource::slope_at(double x_posts, double z_posts) const {
    const double fall = -height_at(x_posts, z_posts) / (sigma_posts_ * sigma_posts_);
    return {fall * (x_posts - middle_posts_), fall * (z_posts - middle_posts_)};
}

}  // namespace tilth
