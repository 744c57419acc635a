#include "tilth/world/height_codec.h"

#include <cmath>

namespace tilth {

std::uint32_t HeightCodec::code(double height_m, HeightPrecision precision) const {
    const bool both = precision == HeightPrecision::bits32;
    const double step = both ? code_quantum_m() : quantum_m;
    const double top = both ? 4294967295.0 : 65535.0;
    const double middle = both ? 2147483648.0 : 32768.0;
    double steps = std::floor((height_m - middle_m) / step + middle + 0.5);
    steps = steps < 0 ? 0 : (steps > top ? top : steps);
    const auto whole = static_cast<std::uint32_t>(steps);
    return both ? whole : whole << 16;
}

HeightCodec HeightCodec::for_range(double min_m, double max_m) {
    const double span = 4 * (max_m - min_m) + 64;
    double quantum = 1.0;
    while (quantum * 65536 < span) quantum *= 2;
    while (quantum * 32768 >= span) quantum /= 2;
    return {(min_m + max_m) / 2, quantum};
}

}  // namespace tilth
