// An exponential that gives the same bits on every machine.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace tilth {

/// exp(x) for x <= 0, within 1e-15 relative; 0 below -708, where doubles would turn subnormal.
///
/// Original heights are part of the state hash, and libm's exp may differ in the last bit from one system to the next.
/// So: x = k ln 2 + r with |r| <= ln 2 / 2, exp(r) by its Taylor series (the 14th term is below 1e-17), times 2^k.
/// Only + - * and floor of IEEE doubles, in a fixed order.
inline double portable_exp(double x) {
    if (x < -708.0) return 0.0;
    constexpr double kLn2High = 0x1.62e42feep-1;       // 32 bits, so that k * kLn2High is exact
    constexpr double kLn2Low = 0x1.a39ef35793c76p-33;  // the rest of ln 2
    constexpr double kInverseLn2 = 0x1.71547652b82fep+0;
    const double k = std::floor(x * kInverseLn2 + 0.5);
    const double r = (x - k * kLn2High) - k * kLn2Low;
    double sum = 1.0;
    for (int n = 13; n >= 1; --n) sum = 1.0 + r * sum / n;
    return sum * std::bit_cast<double>(static_cast<std::uint64_t>(1023 + static_cast<std::int64_t>(k)) << 52);
}

}  // namespace tilth
