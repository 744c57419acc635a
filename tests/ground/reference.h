// The definition of a stamp written down a second time, straight and slow, with integers that are wide enough: what the
// executors must do, for tests. Shares no arithmetic with shaders/shared/; takes only the integer sine and cosine, the
// shapes' weights and the record.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tilth/ground/map_geometry.h"
#include "tilth/ground/shape_library.h"
#include "tilth/ground/stamp.h"
#include "tilth/ground/turn.h"

namespace tilth::reference {

__extension__ using Int128 = __int128;
using Int64 = std::int64_t;

inline Int64 floor_of_quotient(Int128 a, Int128 b) {  // b > 0
    Int128 q = a / b;
    if (q * b > a) --q;
    return static_cast<Int64>(q);
}
inline Int64 nearest_away(Int128 a, Int128 b) {  // b > 0; halves away from zero
    return a < 0 ? -floor_of_quotient(2 * -a + b, 2 * b) : floor_of_quotient(2 * a + b, 2 * b);
}

/// floor(sqrt(n)) by bisection.
inline Int64 integer_root(Int64 n) {
    Int64 low = 0, high = Int64{1} << 31;
    while (high - low > 1) {
        const Int64 middle = (low + high) / 2;
        (middle * middle <= n ? low : high) = middle;
    }
    return low;
}

/// Uniform bits from key and texel: Wellons' lowbias32, twice.
inline std::uint32_t low_bias(std::uint64_t h) {
    h &= 0xffffffffu;
    h = ((h ^ (h >> 16)) * 2146121005u) & 0xffffffffu;
    h = ((h ^ (h >> 15)) * 2221713035u) & 0xffffffffu;
    return static_cast<std::uint32_t>(h ^ (h >> 16));
}

class Stamp {
public:
    Stamp(const StampRecord& record, const MapGeometry& map, const ShapeLibrary& shapes)
        : record_(record),
          map_(map),
          shape_(shapes.shape({record.shape})),
          radius_(std::max<Int64>(record.radius, 1)),  // 2^-18 texel until widened
          amplitude_(record.amplitude),
          bits16_(map.precision == HeightPrecision::bits16) {
        const auto least = static_cast<Int64>(std::floor(shape_.least_radius_texels * 1024)) * 256;
        if (radius_ < least) {
            if (record.rule == StampRule::Add)
                amplitude_ = nearest_away(Int128{amplitude_} * radius_ * radius_, Int128{least} * least);
            radius_ = least;
        }
        radius_ = floor_of_quotient(radius_ + 128, 256);
        centre_x_ = sub_texels(record.centre_x, map.grid.origin.x);
        centre_z_ = sub_texels(record.centre_z, map.grid.origin.z);
        texel_x_ = floor_of_quotient(centre_x_ + 512, 1024);
        texel_z_ = floor_of_quotient(centre_z_ + 512, 1024);
        if (shape_.is_image) set_image();
        if (shape_.zero_volume && record.rule == StampRule::Add && radius_ <= 256 * 1024) {
            const Int64 reach = radius_ / 1024 + 2;
            for (Int64 z = texel_z_ - reach; z <= texel_z_ + reach; ++z)
                for (Int64 x = texel_x_ - reach; x <= texel_x_ + reach; ++x) residue_ -= change(x, z);
        }
    }

    /// True if the centre's rounding could go either way in another wide-enough arithmetic.
    [[nodiscard]] bool doubtful() const { return doubtful_; }
    [[nodiscard]] Int64 radius() const { return radius_; }
    [[nodiscard]] Int64 amplitude() const { return amplitude_; }

    /// Weight at a texel, -65536..65536.
    [[nodiscard]] Int64 weight(Int64 x, Int64 z) const {
        if (shape_.is_image) return image_weight(x, z);
        const Int64 dx = x * 1024 - centre_x_, dz = z * 1024 - centre_z_;
        if (std::abs(dx) > radius_ || std::abs(dz) > radius_) return 0;
        const Int64 distance = integer_root(dx * dx + dz * dz);
        if (distance >= radius_) return 0;
        // t with 31 fraction bits, by the reciprocal of the radius shifted to 32 bits.
        Int64 scale = 1;
        while (radius_ * scale < (Int64{1} << 31)) scale *= 2;
        const Int128 reciprocal = ((Int128{1} << 63) - 1) / (radius_ * scale);
        const auto position = static_cast<Int64>(Int128{distance} * scale * reciprocal >> 32);
        const Int64 entry = position / (1 << 21), fraction = position % (1 << 21) / 128;
        return between(shape_.weights[static_cast<std::size_t>(entry)],
                       shape_.weights[static_cast<std::size_t>(entry + 1)], fraction);
    }

    /// What `add` changes, without the residue, in codes, were there no range.
    [[nodiscard]] Int64 change(Int64 x, Int64 z) const {
        const Int64 w = weight(x, z);
        const Int64 magnitude = whole(scaled(amplitude_, std::abs(w)), x, z);
        return (record_.negative != 0) != (w < 0) ? -magnitude : magnitude;
    }

    /// Applies the stamp to a dense map, one texel after the other; returns how many texels saturated.
    Int64 apply(std::vector<std::uint32_t>& codes, Int64 width, Int64 depth) const {
        const std::vector<std::uint32_t> before =
            record_.rule == StampRule::Smooth ? codes : std::vector<std::uint32_t>{};
        const Int64 reach = (shape_.is_image ? radius_ * 3 / 2 : radius_) / 1024 + 3;
        Int64 saturated = 0;
        for (Int64 z = std::max<Int64>(0, texel_z_ - reach); z <= std::min(depth - 1, texel_z_ + reach); ++z)
            for (Int64 x = std::max<Int64>(0, texel_x_ - reach); x <= std::min(width - 1, texel_x_ + reach); ++x) {
                std::uint32_t& code = codes[static_cast<std::size_t>(z * width + x)];
                bool stopped = false;
                code = static_cast<std::uint32_t>(result(code, x, z, before, width, depth, stopped));
                saturated += stopped ? 1 : 0;
            }
        return saturated;
    }

private:
    [[nodiscard]] Int64 sub_texels(Int64 fixed, double origin) {
        const long double exact = (static_cast<long double>(fixed) / 16777216.0L - static_cast<long double>(origin)) /
                                      map_.grid.spacing_m * 1024 +
                                  0.5L;
        const long double whole_part = std::floor(exact), part = exact - whole_part;
        // On spacings that are powers of two every operation is exact, so a tie is decided.
        int exponent = 0;
        const bool exact_spacing = std::frexp(map_.grid.spacing_m, &exponent) == 0.5;
        if (!exact_spacing && (part < 1e-6L || part > 1 - 1e-6L)) doubtful_ = true;
        return static_cast<Int64>(whole_part);
    }

    void set_image() {
        const SineCosine turn = sine_cosine(record_.rotation);
        const auto bits_of = [](Int64 size) {
            Int64 bits = 30;
            for (Int64 n = 1; n < size; n *= 2) --bits;
            return bits;
        };
        u_bits_ = bits_of(shape_.width);
        v_bits_ = bits_of(shape_.height);
        const auto step = [&](Int64 size, Int64 bits, Int64 direction) {
            return nearest_away(Int128{direction} * size * 512 * (Int64{1} << bits), Int128{radius_} << 30);
        };
        const Int64 flip = record_.mirror != 0 ? -1 : 1;
        u_per_x_ = step(shape_.width, u_bits_, flip * turn.cosine);
        u_per_z_ = step(shape_.width, u_bits_, -flip * turn.sine);
        v_per_x_ = step(shape_.height, v_bits_, turn.sine);
        v_per_z_ = step(shape_.height, v_bits_, turn.cosine);
        const Int64 offset_x = centre_x_ - texel_x_ * 1024, offset_z = centre_z_ - texel_z_ * 1024;
        u_centre_ = Int64{shape_.width - 1} * (Int64{1} << u_bits_) / 2 -
                    nearest_away(offset_x * u_per_x_ + offset_z * u_per_z_, 1024);
        v_centre_ = Int64{shape_.height - 1} * (Int64{1} << v_bits_) / 2 -
                    nearest_away(offset_x * v_per_x_ + offset_z * v_per_z_, 1024);
    }

    [[nodiscard]] Int64 image_weight(Int64 x, Int64 z) const {
        const Int64 one = Int64{1} << u_bits_, one_v = Int64{1} << v_bits_, dx = x - texel_x_, dz = z - texel_z_;
        const Int64 u = u_centre_ + dx * u_per_x_ + dz * u_per_z_, v = v_centre_ + dx * v_per_x_ + dz * v_per_z_;
        if (2 * u < -one || 2 * u >= (2 * Int64{shape_.width} - 1) * one) return 0;
        if (2 * v < -one_v || 2 * v >= (2 * Int64{shape_.height} - 1) * one_v) return 0;
        const Int64 column = floor_of_quotient(u, one), row = floor_of_quotient(v, one_v);
        const Int64 across = (u - column * one) * 16384 / one, down = (v - row * one_v) * 16384 / one_v;
        const auto pixel = [&](Int64 c, Int64 r) -> Int64 {
            c = std::clamp<Int64>(c, 0, shape_.width - 1);
            r = std::clamp<Int64>(r, 0, shape_.height - 1);
            return shape_.weights[static_cast<std::size_t>(r * shape_.width + c)];
        };
        return between(between(pixel(column, row), pixel(column + 1, row), across),
                       between(pixel(column, row + 1), pixel(column + 1, row + 1), across), down);
    }

    [[nodiscard]] static Int64 between(Int64 a, Int64 b, Int64 fraction) {
        return a + floor_of_quotient(2 * (b - a) * fraction + 16384, 32768);
    }
    [[nodiscard]] static Int64 scaled(Int64 amplitude, Int64 weight) { return (amplitude * weight + 32768) / 65536; }

    /// A magnitude as the map keeps it: as it is, or rounded up with the probability of what is cut off.
    [[nodiscard]] Int64 whole(Int64 magnitude, Int64 x, Int64 z) const {
        if (!bits16_) return magnitude;
        const std::uint32_t dither =
            low_bias(low_bias(record_.key ^ (static_cast<std::uint64_t>(x) * 2654435761u & 0xffffffffu)) ^
                     (static_cast<std::uint64_t>(z) * 2246822519u & 0xffffffffu));
        return std::min<Int64>((magnitude + dither % 65536) / 65536, 65535) * 65536;
    }

    [[nodiscard]] Int64 result(Int64 code, Int64 x, Int64 z, const std::vector<std::uint32_t>& before, Int64 width,
                               Int64 depth, bool& stopped) const {
        const Int64 top = bits16_ ? 0xffff0000 : 0xffffffff, w = weight(x, z);
        const auto limited = [&](Int64 value, Int64 most) {
            stopped = stopped || value < 0 || value > most;
            return std::clamp<Int64>(value, 0, most);
        };
        const Int64 sign = record_.negative != 0 ? -1 : 1;
        if (record_.rule == StampRule::Add) {
            code = limited(code + change(x, z), top);
            if (x == texel_x_ && z == texel_z_ && residue_ != 0) code = limited(code + residue_, top);
            return code;
        }
        if (w <= 0) return code;
        const auto kept = [&](Int64 value) {  // to the map's quantum, nearest
            return bits16_ ? std::min<Int64>((value + 32768) / 65536, 65535) * 65536 : value;
        };
        const auto moved = [&](Int64 target, Int64 by) {
            return target < code ? code - whole(scaled(code - target, by), x, z)
                                 : code + whole(scaled(target - code, by), x, z);
        };
        const Int64 level = record_.level;
        switch (record_.rule) {
            case StampRule::Min:
                return std::min(code, kept(limited(level + sign * scaled(amplitude_, w), 0xffffffff)));
            case StampRule::Max:
                return std::max(code, kept(limited(level + sign * scaled(amplitude_, w), 0xffffffff)));
            case StampRule::Set:
                return moved(kept(limited(level + sign * amplitude_, 0xffffffff)), w);
            default:
                break;
        }
        Int64 sum = 0;
        for (Int64 dz = -1; dz <= 1; ++dz)
            for (Int64 dx = -1; dx <= 1; ++dx)
                if (dx != 0 || dz != 0)
                    sum += before[static_cast<std::size_t>(std::clamp<Int64>(z + dz, 0, depth - 1) * width +
                                                           std::clamp<Int64>(x + dx, 0, width - 1))];
        const Int64 mean = bits16_ ? (sum + 4 * 65536) / (8 * 65536) * 65536 : (sum + 4) / 8;
        return moved(mean, scaled(amplitude_, w));
    }

    const StampRecord& record_;
    const MapGeometry& map_;
    const Shape& shape_;
    Int64 radius_, amplitude_;
    bool bits16_, doubtful_ = false;
    Int64 centre_x_ = 0, centre_z_ = 0, texel_x_ = 0, texel_z_ = 0, residue_ = 0;
    Int64 u_bits_ = 0, v_bits_ = 0, u_centre_ = 0, v_centre_ = 0, u_per_x_ = 0, u_per_z_ = 0, v_per_x_ = 0,
          v_per_z_ = 0;
};

}  // namespace tilth::reference
