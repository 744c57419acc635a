// Heights as 32-bit fixed-point codes: the form in which the ground persists.
#pragma once

#include <cstdint>

namespace tilth {

/// How many bits of the height code are kept.
enum class HeightPrecision : std::uint8_t {
    bits32,  ///< two 16-bit planes: every stamp is exact to 2^-16 of the high plane's quantum
    bits16,  ///< the high plane only: half the memory, faster; stamps are rounded with a hashed dither
};

/// The code of the middle of the range. Detail maps hold it where the ground is untouched.
inline constexpr std::uint32_t kMidCode = 0x8000'0000u;

/// Converts between heights in metres and codes: height = middle_m + (code - 2^31) * code_quantum.
/// Codes are exact integers; the conversion to metres rounds once (double).
struct HeightCodec {
    double middle_m = 0;   ///< height of the code 2^31
    double quantum_m = 0;  ///< of the high 16-bit plane, a power of two; 65 536 of them span the range

    friend bool operator==(const HeightCodec&, const HeightCodec&) = default;

    /// Metres per step of the 32-bit code: the low plane's quantum.
    [[nodiscard]] constexpr double code_quantum_m() const { return quantum_m / 65536.0; }
    [[nodiscard]] constexpr double min_m() const { return middle_m - 32768.0 * quantum_m; }
    [[nodiscard]] constexpr double max_m() const { return middle_m + 32768.0 * quantum_m - code_quantum_m(); }

    [[nodiscard]] constexpr double height_m(std::uint32_t code) const {
        return middle_m + (static_cast<double>(code) - 2147483648.0) * code_quantum_m();
    }

    /// Nearest code; saturates outside the range. `height_m` is finite. With `bits16` the low plane is zero.
    [[nodiscard]] std::uint32_t code(double height_m, HeightPrecision precision) const;

    /// The default for data between `min_m` and `max_m`: the smallest power of two with
    /// 65536 q >= 4 (max - min) + 64 m, the middle of the range at the middle code.
    static HeightCodec for_range(double min_m, double max_m);

    /// Detail maps: 2^-12 m in the high plane, 2^-28 m in both, +-8 m about the coarse ground.
    static constexpr HeightCodec detail() { return {0.0, 1.0 / 4096}; }
};

}  // namespace tilth
