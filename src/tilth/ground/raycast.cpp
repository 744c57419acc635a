#include "tilth/ground/raycast.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tilth {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kFurthest = 1e12;  // metres: beyond every map, and finite, so that a vertical ray has an end

/// The places where position(t) = start + slope t crosses an integer, in order of t.
class Crossings {
public:
    Crossings(double start, double slope, double first_t) : start_(start), slope_(slope) {
        if (slope == 0) return;
        const double position = start + slope * first_t;
        line_ = slope > 0 ? std::floor(position) + 1 : std::ceil(position) - 1;
        set();
    }
    [[nodiscard]] double next() const { return next_; }
    void pass(double t) {
        while (next_ <= t) {
            line_ += slope_ > 0 ? 1 : -1;
            set();
        }
    }

private:
    void set() { next_ = (line_ - start_) / slope_; }
    double start_, slope_, line_ = 0, next_ = kNever;
};

}  // namespace

std::optional<double> raycast(const Ground& ground, const Vec3d& from, const Vec3d& direction, double max_m) {
    const double length = std::hypot(direction.x, direction.y, direction.z);
    if (!(length > 0) || !std::isfinite(length) || !(max_m >= 0)) return std::nullopt;
    const Vec3d d{direction.x / length, direction.y / length, direction.z / length};
    // Detail texels subdivide the coarse cells, their diagonals lie on the same lines: the finer grid has all edges.
    const bool fine = !ground.detail().pages().empty();
    const GridSpec& grid = ground.map(fine ? MapKind::Detail : MapKind::Coarse).grid;
    const PostPos start = grid.posts({from.x, from.z});
    const double slope_x = d.x / grid.spacing_m, slope_z = d.z / grid.spacing_m;
    double begin = 0, end = std::min(max_m, kFurthest);
    clip_ray(start.x, slope_x, 0, grid.width - 1.0, begin, end);
    clip_ray(start.z, slope_z, 0, grid.depth - 1.0, begin, end);
    if (!(begin <= end)) return std::nullopt;

    const auto clearance = [&](double t) {
        return from.y + d.y * t - ground.height_m({from.x + d.x * t, from.z + d.z * t});
    };
    double t = begin, above = clearance(t);
    if (above <= 0) return t;
    Crossings columns(start.x, slope_x, begin), rows(start.z, slope_z, begin),
        diagonals(start.x - start.z, slope_x - slope_z, begin);
    while (t < end) {
        const double next = std::min({columns.next(), rows.next(), diagonals.next(), end});
        const double next_above = clearance(next);
        if (next_above <= 0) return t + (next - t) * above / (above - next_above);
        t = next;
        above = next_above;
        columns.pass(t);
        rows.pass(t);
        diagonals.pass(t);
    }
    return std::nullopt;
}

}  // namespace tilth
