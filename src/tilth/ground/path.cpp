#include "tilth/ground/path.h"

#include <cmath>

#include "tilth/ground/turn.h"

namespace tilth {
namespace {

constexpr double kMostStamps = 1e6;
constexpr double kSlack = 1e-9;  // of the spacing: 0.3 m at 0.1 m are four stamps, whatever the rounding

// IEEE operations only, here and in direction_angle: records must not depend on a machine's libm.
double length_of(double x, double z) { return std::sqrt(x * x + z * z); }

Error invalid(std::string message) { return {ErrorCode::InvalidArgument, std::move(message)}; }

}  // namespace

Result<std::vector<StampRequest>> stamps_along(const PathRequest& path) {
    if (path.points.empty()) return invalid("points: a path needs at least one point");
    if (!(path.spacing_m > 0) || !std::isfinite(path.spacing_m))
        return invalid(text("spacing: ", path.spacing_m, " m is not above 0"));
    if (!(path.alternate_m >= 0) || !std::isfinite(path.alternate_m))
        return invalid(text("alternate: ", path.alternate_m, " m is not 0 or more"));
    double length_m = 0;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
        if (!std::isfinite(path.points[i].x) || !std::isfinite(path.points[i].z))
            return invalid(text("points: point ", i, " is not finite"));
        if (i > 0)
            length_m += length_of(path.points[i].x - path.points[i - 1].x, path.points[i].z - path.points[i - 1].z);
    }
    if (!(length_m / path.spacing_m < kMostStamps))
        return invalid(
            text("spacing: ", length_m, " m of path at ", path.spacing_m, " m are more than a million stamps"));

    std::vector<StampRequest> stamps;
    const auto place = [&](WorldPos at, double direction_x, double direction_z) {
        StampRequest stamp = path.stamp;
        const bool right = stamps.size() % 2 == 1;
        if (path.alternate_m > 0) {
            // Seen from above with +x right and +z down, left of (dx, dz) is (dz, -dx).
            const double side = right ? -path.alternate_m : path.alternate_m;
            at = {at.x + direction_z * side, at.z - direction_x * side};
            if (right) stamp.mirror = !stamp.mirror;
        }
        stamp.centre = at;
        // (1, 0) -> (cos, -sin) along the path. A mirrored image's x axis points backwards: turned by half a turn more,
        // it points ahead again, and left and right are what has changed sides.
        const double ahead = stamp.mirror ? -1 : 1;
        stamp.rotation_rad += direction_angle(ahead * direction_x, -ahead * direction_z);
        if (stamp.key) *stamp.key += static_cast<std::uint32_t>(stamps.size());
        stamps.push_back(stamp);
    };

    double next_m = 0, walked_m = 0;  // along the path
    for (std::size_t i = 1; i < path.points.size(); ++i) {
        const WorldPos from = path.points[i - 1], to = path.points[i];
        const double segment_m = length_of(to.x - from.x, to.z - from.z);
        if (segment_m == 0) continue;
        const double direction_x = (to.x - from.x) / segment_m, direction_z = (to.z - from.z) / segment_m;
        for (; next_m <= walked_m + segment_m + kSlack * path.spacing_m;
             next_m = static_cast<double>(stamps.size()) * path.spacing_m) {
            const double along_m = next_m - walked_m;
            place({from.x + direction_x * along_m, from.z + direction_z * along_m}, direction_x, direction_z);
        }
        walked_m += segment_m;
    }
    if (stamps.empty()) place(path.points.front(), 1, 0);  // a path of one place
    return stamps;
}

}  // namespace tilth
