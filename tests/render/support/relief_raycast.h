// Where a ray meets relief, in double precision and without any hierarchy: what the tracers of the shaders are held
// against. Positions and heights are texels; whole numbers are texels' centres. A ray is at - shift * z, as in
// shaders/render/parallax/trace.glsl.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace tilth::test {

/// Heights at the texels of a square that repeats for ever.
struct ReliefField {
    int size = 0;
    std::vector<float> heights;

    ReliefField(int side, float height)
        : size(side), heights(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), height) {}

    [[nodiscard]] std::size_t index(int x, int z) const {
        const int wrapped_x = (x % size + size) % size, wrapped_z = (z % size + size) % size;
        return static_cast<std::size_t>(wrapped_z) * static_cast<std::size_t>(size) +
               static_cast<std::size_t>(wrapped_x);
    }
    [[nodiscard]] float& at(int x, int z) { return heights[index(x, z)]; }
    [[nodiscard]] double at(int x, int z) const { return static_cast<double>(heights[index(x, z)]); }
    [[nodiscard]] double highest() const {
        return static_cast<double>(*std::max_element(heights.begin(), heights.end()));
    }
    [[nodiscard]] double lowest() const {
        return static_cast<double>(*std::min_element(heights.begin(), heights.end()));
    }

    /// On cells split along the diagonal from the low to the high corner.
    [[nodiscard]] double split(double x, double z) const {
        const double low_x = std::floor(x), low_z = std::floor(z), u = x - low_x, v = z - low_z;
        const int i = static_cast<int>(low_x), j = static_cast<int>(low_z);
        const double h00 = at(i, j), h11 = at(i + 1, j + 1);
        if (u >= v) return h00 * (1 - u) + at(i + 1, j) * (u - v) + h11 * v;
        return h00 * (1 - v) + at(i, j + 1) * (v - u) + h11 * u;
    }
    [[nodiscard]] double bilinear(double x, double z) const {
        const double low_x = std::floor(x), low_z = std::floor(z), u = x - low_x, v = z - low_z;
        const int i = static_cast<int>(low_x), j = static_cast<int>(low_z);
        return (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) + v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1));
    }
};

/// Floats, as the GPU has them: both sides trace the same ray.
struct ReliefRay {
    float x = 0, z = 0, shift_x = 0, shift_z = 0;

    /// On the ray, `below` texels under the plane.
    [[nodiscard]] std::array<double, 2> on(double below) const {
        return {static_cast<double>(x) + static_cast<double>(shift_x) * below,
                static_cast<double>(z) + static_cast<double>(shift_z) * below};
    }
};

enum class Surface { Split, Bilinear };

/// How far the ray is above the surface, `below` texels under the plane; negative inside the ground.
inline double over_surface(const ReliefField& field, const ReliefRay& ray, double below, Surface surface) {
    const std::array<double, 2> p = ray.on(below);
    return -below - (surface == Surface::Split ? field.split(p[0], p[1]) : field.bilinear(p[0], p[1]));
}

/// Calls `piece(begin, end)` for the stretches of the ray, in texels below the plane, on each of which the split
/// surface is linear (and the bilinear one quadratic), until it returns false: between two crossings of lines x = k, z
/// = k, x - z = k.
template <class Piece>
void for_each_piece(const ReliefRay& ray, double from, double to, const Piece& piece) {
    const std::array<double, 2> start = ray.on(from);
    const double rate_x = static_cast<double>(ray.shift_x), rate_z = static_cast<double>(ray.shift_z);
    const std::array<double, 3> begin{start[0], start[1], start[0] - start[1]}, rate{rate_x, rate_z, rate_x - rate_z};
    std::array<double, 3> line{};
    for (std::size_t i = 0; i < 3; ++i) line[i] = rate[i] > 0 ? std::floor(begin[i]) + 1 : std::ceil(begin[i]) - 1;
    double at = from;
    while (at < to) {
        std::size_t nearest = 0;
        std::array<double, 3> reached{};
        for (std::size_t i = 0; i < 3; ++i) {
            reached[i] = rate[i] != 0 ? from + (line[i] - begin[i]) / rate[i] : std::numeric_limits<double>::infinity();
            if (reached[i] < reached[nearest]) nearest = i;
        }
        const double end = std::min(std::max(reached[nearest], at), to);
        if (end > at && !piece(at, end)) return;
        at = end;
        line[nearest] += rate[nearest] > 0 ? 1 : -1;
    }
}

/// Texels below the plane of the first hit of the ray, searched from `highest` down to `lowest`, which is met at last.
inline double raycast(const ReliefField& field, const ReliefRay& ray, double highest, double lowest, Surface surface) {
    double hit = -lowest;
    if (over_surface(field, ray, -highest, surface) <= 0) return -highest;
    for_each_piece(ray, -highest, -lowest, [&](double begin, double end) {
        const double over = over_surface(field, ray, begin, surface), over_end = over_surface(field, ray, end, surface);
        if (surface == Surface::Split) {
            if (over_end > 0) return true;
            hit = over > 0 ? begin + (end - begin) * over / (over - over_end) : begin;
            return false;
        }
        // Through three points: over + b t + a t^2, t in 0..1.
        const double over_middle = over_surface(field, ray, (begin + end) / 2, surface);
        const double a = 2 * (over + over_end - 2 * over_middle), b = over_end - over - a;
        double t = 2;
        const double root = b * b - 4 * a * over;
        if (root >= 0) {
            const double q = -0.5 * (b + (b >= 0 ? std::sqrt(root) : -std::sqrt(root)));
            for (const double candidate : {a != 0 ? q / a : 2.0, q != 0 ? over / q : 2.0})
                if (candidate >= 0 && candidate <= 1) t = std::min(t, candidate);
        }
        if (t > 1 && over_end > 0) return true;
        hit = begin + std::min(t, 1.0) * (end - begin);
        return false;
    });
    return hit;
}

/// How deep in the ground the ray is at the most between two places on it [texels], split surface.
inline double deepest_between(const ReliefField& field, const ReliefRay& ray, double from, double to) {
    double deepest =
        std::max(-over_surface(field, ray, from, Surface::Split), -over_surface(field, ray, to, Surface::Split));
    for_each_piece(ray, from, to, [&](double, double end) {
        deepest = std::max(deepest, -over_surface(field, ray, end, Surface::Split));
        return true;
    });
    return deepest;
}

constexpr double kReliefDepth = 8.192;  ///< of both fields below: 0.004 of a tile of 2048 texels

inline void rescale(ReliefField& field) {
    const double low = field.lowest(), span = field.highest() - low;
    for (float& h : field.heights)
        h = static_cast<float>(-kReliefDepth + (static_cast<double>(h) - low) / span * kReliefDepth);
}

template <class Profile>
void add_print(ReliefField& field, float x, float z, int radius, const Profile& profile) {
    for (int j = -radius; j <= radius; ++j)
        for (int i = -radius; i <= radius; ++i)
            field.at(static_cast<int>(x) + i, static_cast<int>(z) + j) +=
                profile(std::sqrt(static_cast<float>(i * i + j * j)));
}

/// Sixty smooth bowls of 8 to 24 texels on gentle waves, from -kReliefDepth to 0.
inline ReliefField soft_footprints() {
    ReliefField field(256, 0);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int k = 0; k < 60; ++k) {
        const float r = 8 + 16 * unit(random), depth = 1 + 3 * unit(random), z = 256 * unit(random),
                    x = 256 * unit(random);
        add_print(field, x, z, 30, [&](float d) {
            const float rest = 1 - d * d / r / r;
            return d < r ? -depth * rest * rest : 0.0f;
        });
    }
    const auto turn = [](int steps) { return 2 * std::numbers::pi_v<float> * static_cast<float>(steps) / 256; };
    for (int octave = 0; octave < 2; ++octave)
        for (int z = 0; z < 256; ++z)
            for (int x = 0; x < 256; ++x)
                field.at(x, z) += 0.15f * std::sin(turn(x * (5 + 9 * octave) + z * 3)) +
                                  0.15f * std::cos(turn(z * (7 + 6 * octave) - x * 4));
    rescale(field);
    return field;
}

/// Grooves of a sole, 8 texels wide with upright walls, and 25 posts, from -kReliefDepth to 0.
inline ReliefField sharp_treads() {
    ReliefField field(256, 0);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int z = 0; z < 256; ++z)
        for (int x = 0; x < 256; ++x) field.at(x, z) = (x / 8) % 2 == 0 && (z / 2 + x / 4) % 16 < 10 ? -6.5f : -0.2f;
    for (int k = 0; k < 25; ++k) {
        const float z = 256 * unit(random), x = 256 * unit(random);
        add_print(field, x, z, 4, [](float d) { return d < 3 ? 4.0f : 0.0f; });
    }
    rescale(field);
    return field;
}

}  // namespace tilth::test
