#include "tilth/source/ridged_source.h"

#include <array>
#include <cmath>

namespace tilth {
namespace {

constexpr double kShortestWavelengthPosts = 8.0;  // cells of the finest octave; shorter would alias on the posts
constexpr double kPersistence = 0.42;             // amplitude of an octave over that of the one above; taste
constexpr double kCrestWidth = 1.5;               // a crest's foot lies where |noise| = 1 / kCrestWidth; taste
constexpr double kCrestRounding = 0.03;           // |noise| below which a crest is round, not a fold; taste
constexpr double kWarpWavelengths = 0.12;         // how far the domain is bent, in longest wavelengths; taste

/// Finaliser of splitmix64: every input bit moves every output bit.
std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/// The `n`-th random integer of `seed`.
std::uint64_t random_of(std::uint64_t seed, std::uint64_t n) { return mixed(seed + (n + 1) * 0x9e3779b97f4a7c15u); }

/// In [-1, 1), from the 32 low bits.
double signed_unit(std::uint64_t bits) { return static_cast<double>(bits & 0xffffffffu) / 2147483648.0 - 1.0; }

struct Vec2 {
    double x = 0, z = 0;
};

/// 256 unit vectors; which one stands on a lattice point is hashed.
std::array<Vec2, 256> make_gradients(std::uint64_t seed) {
    std::array<Vec2, 256> gradients;
    std::uint64_t n = 0;
    for (Vec2& g : gradients) {
        double length2 = 0;
        do {  // points in the disc, away from its middle: every direction equally likely
            const std::uint64_t bits = random_of(seed, n++);
            g = {signed_unit(bits), signed_unit(bits >> 32)};
            length2 = g.x * g.x + g.z * g.z;
        } while (length2 > 1.0 || length2 < 0.01);
        const double length = std::sqrt(length2);
        g = {g.x / length, g.z / length};
    }
    return gradients;
}

/// Perlin's gradient noise with the quintic fade, range about [-0.7, 0.7], one lattice cell a wavelength.
/// Remembers the gradients about the last cell: neighbouring posts mostly share it.
class GradientNoise {
public:
    explicit GradientNoise(std::uint64_t seed) : seed_(seed), gradients_(make_gradients(seed)) {}

    double operator()(double x, double z) {
        const double cell_x = std::floor(x), cell_z = std::floor(z);
        if (cell_x != cell_x_ || cell_z != cell_z_) enter(cell_x, cell_z);
        const double u = x - cell_x, v = z - cell_z;
        const double a = corners_[0].x * u + corners_[0].z * v;
        const double b = corners_[1].x * (u - 1) + corners_[1].z * v;
        const double c = corners_[2].x * u + corners_[2].z * (v - 1);
        const double d = corners_[3].x * (u - 1) + corners_[3].z * (v - 1);
        const double s = u * u * u * (u * (u * 6 - 15) + 10), t = v * v * v * (v * (v * 6 - 15) + 10);
        const double low = a + s * (b - a), high = c + s * (d - c);
        return low + t * (high - low);
    }

private:
    void enter(double cell_x, double cell_z) {
        cell_x_ = cell_x;
        cell_z_ = cell_z;
        const std::int64_t i = static_cast<std::int64_t>(cell_x), j = static_cast<std::int64_t>(cell_z);
        corners_ = {gradient(i, j), gradient(i + 1, j), gradient(i, j + 1), gradient(i + 1, j + 1)};
    }
    [[nodiscard]] Vec2 gradient(std::int64_t i, std::int64_t j) const {
        const std::uint64_t at = static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15u;
        return gradients_[mixed((at ^ seed_) + static_cast<std::uint64_t>(j) * 0xd6e8feb86659fd93u) >> 56];
    }

    std::uint64_t seed_;
    std::array<Vec2, 256> gradients_;
    double cell_x_ = 0.5, cell_z_ = 0.5;  // no cell yet
    std::array<Vec2, 4> corners_{};
};

/// One octave: its own lattice, turned and shifted against the others so that no lattice line shows.
struct Octave {
    GradientNoise noise;
    Vec2 x_axis;  // lattice cells per post along x; the z axis is (-x_axis.z, x_axis.x)
    Vec2 origin;  // lattice position of post (0, 0)
    double amplitude;

    double at(double x, double z) {
        return noise(origin.x + x * x_axis.x - z * x_axis.z, origin.z + x * x_axis.z + z * x_axis.x);
    }
};

Octave make_octave(std::uint64_t seed, double wavelength_posts, double amplitude) {
    double c = signed_unit(random_of(seed, 0)), s = signed_unit(random_of(seed, 1));
    if (c * c + s * s < 0.01) c = 1, s = 0;
    const double cells_per_post = 1.0 / (wavelength_posts * std::sqrt(c * c + s * s));
    return {GradientNoise(random_of(seed, 2)),
            {c * cells_per_post, s * cells_per_post},
            {64 * signed_unit(random_of(seed, 3)), 64 * signed_unit(random_of(seed, 4))},
            amplitude};
}

/// Octave after octave, each let in by how high on a crest the one above it is. Smooth everywhere.
double ridged(std::vector<Octave>& octaves, double x, double z) {
    double sum = 0, weight = 1;
    for (Octave& octave : octaves) {
        const double n = octave.at(x, z);
        const double height = 1.0 - kCrestWidth * std::sqrt(n * n + kCrestRounding * kCrestRounding);
        const double crest = height > 0 ? height * height * weight : 0;  // nearly 1 on the crest line, 0 in the valley
        sum += octave.amplitude * crest;
        weight = crest * (2 - crest);
    }
    return sum;
}

}  // namespace

std::unique_ptr<RasterSource> make_ridged_source(const RidgedSettings& settings) {
    TILTH_EXPECTS(settings.size >= 2 && settings.size <= 16384 && settings.relief_m > 0,
                  text("ridged noise of ", settings.size, " posts, relief ", settings.relief_m, " m"));
    const double longest = std::max(settings.size / 2.0, kShortestWavelengthPosts);
    Octave warp_x = make_octave(random_of(settings.seed, 1), longest, 1);
    Octave warp_z = make_octave(random_of(settings.seed, 2), longest, 1);
    std::vector<Octave> octaves;
    double amplitude = 1;
    for (double wavelength = longest; wavelength >= kShortestWavelengthPosts; wavelength *= 0.5) {
        octaves.push_back(make_octave(random_of(settings.seed, 3 + octaves.size()), wavelength, amplitude));
        amplitude *= kPersistence;
    }

    std::vector<float> heights_m;
    heights_m.reserve(static_cast<std::size_t>(settings.size) * static_cast<std::size_t>(settings.size));
    const double bend = kWarpWavelengths * longest;
    for (std::int32_t z = 0; z < settings.size; ++z)
        for (std::int32_t x = 0; x < settings.size; ++x)
            heights_m.push_back(
                static_cast<float>(ridged(octaves, x + bend * warp_x.at(x, z), z + bend * warp_z.at(x, z))));

    const auto [low_at, high_at] = std::minmax_element(heights_m.begin(), heights_m.end());
    const double low = *low_at, range = *high_at - low;
    for (float& h : heights_m) h = static_cast<float>((h - low) / range * settings.relief_m);

    auto source = RasterSource::create(settings.size, settings.size, std::move(heights_m), "ridged noise");
    return std::move(*source);
}

}  // namespace tilth
