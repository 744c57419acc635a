// A map repeated by reflection to a million posts a side, without memory.
#pragma once

#include "tilth/source/height_source.h"

namespace tilth {

/// The post of a map of `n` posts (>= 2) that post `p`, any integer, shows when the map is reflected about its first
/// and its last post again and again; neither is doubled, so the period is 2 (n - 1):
///
///     p        -3 -2 -1  0  1  2  3  4  5  6  7        n = 4, period 6
///     shows     3  2  1  0  1  2  3  2  1  0  1
constexpr std::int32_t mirrored_index(std::int64_t p, std::int32_t n) {
    const std::int64_t period = 2 * (std::int64_t{n} - 1);
    const std::int64_t within = ((p % period) + period) % period;
    return static_cast<std::int32_t>(within < n ? within : period - within);
}
static_assert(mirrored_index(-3, 4) == 3 && mirrored_index(0, 4) == 0 && mirrored_index(5, 4) == 1);

/// `inner` reflected to kSide x kSide posts. Continuous, and its range is that of `inner` (whose sides must not
/// exceed kSide, so that every post of it shows).
class MirroredSource final : public HeightSource {
public:
    static constexpr std::int32_t kSide = 1 << 20;

    /// Takes over `inner`, which must not be null.
    explicit MirroredSource(std::unique_ptr<HeightSource> inner) : inner_(std::move(inner)) {
        TILTH_ASSERT(inner_ != nullptr && inner_->width() <= kSide && inner_->depth() <= kSide,
                     "a mirrored world needs a source of at most 2^20 posts a side");
    }

    [[nodiscard]] std::int32_t width() const override { return kSide; }
    [[nodiscard]] std::int32_t depth() const override { return kSide; }
    [[nodiscard]] double min_m() const override { return inner_->min_m(); }
    [[nodiscard]] double max_m() const override { return inner_->max_m(); }
    [[nodiscard]] double height_m(Texel t) const override {
        return inner_->height_m({mirrored_index(t.x, inner_->width()), mirrored_index(t.z, inner_->depth())});
    }

private:
    std::unique_ptr<HeightSource> inner_;
};

}  // namespace tilth
