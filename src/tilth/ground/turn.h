// Rotation as integers: turns / 2^32 in, a sine and cosine with 30 fraction bits out, the same on every machine.
#pragma once

#include <cstdint>

namespace tilth {

struct SineCosine {
    std::int32_t sine = 0, cosine = 0;  ///< 2^30 = 1
};

/// Sine and cosine of `turns` / 2^32 of a full turn, error below 2^-28; exact at multiples of a quarter turn.
/// Reduced to the nearest quarter turn, then Taylor's series to the ninth and tenth power in integers.
SineCosine sine_cosine(std::uint32_t turns);

/// An angle in radians as turns / 2^32, nearest; any finite angle.
std::uint32_t turns_of(double radians);

/// Angle of the direction (x, y), radians in [-pi, pi], error below 1e-14: atan2 by + - * / and sqrt of IEEE doubles
/// alone, so that it gives the same bits on every machine. 0 for (0, 0).
double direction_angle(double x, double y);

}  // namespace tilth
