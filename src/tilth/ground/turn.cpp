#include "tilth/ground/turn.h"

#include <cmath>
#include <initializer_list>
#include <numbers>

namespace tilth {
namespace {

constexpr std::int64_t kOne = std::int64_t{1} << 30;

constexpr std::int64_t times(std::int64_t a, std::int64_t b) { return (a * b + kOne / 2) >> 30; }

}  // namespace

SineCosine sine_cosine(std::uint32_t turns) {
    const std::uint32_t quarter = (turns + (1u << 29)) >> 30;                // 0..4, nearest
    const auto rest = static_cast<std::int32_t>(turns - (quarter << 30));    // -2^29..2^29: an eighth either way
    constexpr std::int64_t kTwoPi = 6746518852;                              // round(2 pi 2^30)
    const std::int64_t x = (rest * kTwoPi + (std::int64_t{1} << 31)) >> 32;  // radians
    const std::int64_t square = times(x, x);
    std::int64_t sine = kOne - square / 72;
    sine = kOne - times(square, sine) / 42;
    sine = kOne - times(square, sine) / 20;
    sine = times(x, kOne - times(square, sine) / 6);
    std::int64_t cosine = kOne - square / 90;
    cosine = kOne - times(square, cosine) / 56;
    cosine = kOne - times(square, cosine) / 30;
    cosine = kOne - times(square, cosine) / 12;
    cosine = kOne - times(square, cosine) / 2;
    const auto s = static_cast<std::int32_t>(sine), c = static_cast<std::int32_t>(cosine);
    switch (quarter & 3u) {
        case 0:
            return {s, c};
        case 1:
            return {c, -s};
        case 2:
            return {-s, -c};
        default:
            return {-c, s};
    }
}

std::uint32_t turns_of(double radians) {
    const double turns = radians / (2 * std::numbers::pi);
    const double part = turns - std::floor(turns);
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(std::floor(part * 4294967296.0 + 0.5)));
}

double direction_angle(double x, double y) {
    const double ax = std::abs(x), ay = std::abs(y);
    const double larger = ax > ay ? ax : ay, smaller = ax > ay ? ay : ax;
    if (larger == 0) return 0;
    // atan t = 2 atan(t / (1 + sqrt(1 + t^2))), three times: t < 0.099, where the series to t^13 leaves 1e-16.
    double t = smaller / larger;
    for (int halving = 0; halving < 3; ++halving) t = t / (1 + std::sqrt(1 + t * t));
    const double square = t * t;
    double series = 1.0 / 13;
    for (const double odd : {11.0, 9.0, 7.0, 5.0, 3.0, 1.0}) series = 1 / odd - square * series;
    double angle = 8 * t * series;
    if (ay > ax) angle = std::numbers::pi / 2 - angle;
    if (x < 0) angle = std::numbers::pi - angle;
    return y < 0 ? -angle : angle;
}

}  // namespace tilth
