// Rays against every triangle of the surface, one by one.
#include "tilth/ground/raycast.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "ground/support.h"

namespace tilth {
namespace {

constexpr int kPosts = 9, kPerPost = 3, kTexels = (kPosts - 1) * kPerPost + 1;
constexpr double kInf = std::numeric_limits<double>::infinity();

std::unique_ptr<Ground> rough_ground(WorldPos origin, double spacing_m) {
    auto ground = test::flat_ground(kPosts, {.origin = origin, .spacing_m = spacing_m}, 0);
    std::mt19937 random(26);
    for (std::uint32_t& code : ground->mutable_coarse().codes())
        code = 0x78000000u + (static_cast<std::uint32_t>(random()) >> 4);
    for (int i = 0; i < 20; ++i)
        test::stamp(*ground, {.shape = {static_cast<std::uint32_t>(random() % 6)},
                              .centre = {origin.x + spacing_m * 0.01 * (random() % 800),
                                         origin.z + spacing_m * 0.01 * (random() % 800)},
                              .radius_m = spacing_m * 1.5,
                              .amplitude_m = 1,
                              .map = MapChoice::Detail});
    return ground;
}

struct Triangle {
    long double p[3][3];
};

std::vector<Triangle> triangles_of(const Ground& ground) {
    const GridSpec& grid = ground.map(MapKind::Detail).grid;
    std::vector<Triangle> triangles;
    for (int z = 0; z + 1 < kTexels; ++z)
        for (int x = 0; x + 1 < kTexels; ++x)
            for (const int side : {0, 1}) {
                const Texel corners[3] = {{x, z}, {x + 1, z + 1}, side == 0 ? Texel{x + 1, z} : Texel{x, z + 1}};
                Triangle t{};
                for (int k = 0; k < 3; ++k) {
                    const WorldPos at = grid.world(corners[k]);
                    t.p[k][0] = at.x, t.p[k][1] = ground.height_m(at), t.p[k][2] = at.z;
                }
                triangles.push_back(t);
            }
    return triangles;
}

/// Smallest distance to a triangle (Moeller and Trumbore 1997) beyond `after`; edges belong to both sides.
long double nearest(const std::vector<Triangle>& triangles, const Vec3d& from, const Vec3d& direction,
                    long double edge) {
    long double best = kInf;
    const long double length = std::sqrt(static_cast<long double>(direction.x) * direction.x +
                                         static_cast<long double>(direction.y) * direction.y +
                                         static_cast<long double>(direction.z) * direction.z);
    const long double d[3] = {direction.x / length, direction.y / length, direction.z / length};
    const auto cross = [](const long double* a, const long double* b, long double* out) {
        out[0] = a[1] * b[2] - a[2] * b[1], out[1] = a[2] * b[0] - a[0] * b[2], out[2] = a[0] * b[1] - a[1] * b[0];
    };
    const auto dot = [](const long double* a, const long double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    for (const Triangle& t : triangles) {
        long double e1[3], e2[3], s[3], h[3], q[3];
        for (int k = 0; k < 3; ++k) e1[k] = t.p[1][k] - t.p[0][k], e2[k] = t.p[2][k] - t.p[0][k];
        s[0] = from.x - t.p[0][0], s[1] = from.y - t.p[0][1], s[2] = from.z - t.p[0][2];
        cross(d, e2, h);
        const long double a = dot(e1, h);
        if (std::abs(a) < 1e-15L) continue;
        const long double u = dot(s, h) / a;
        cross(s, e1, q);
        const long double v = dot(d, q) / a, distance = dot(e2, q) / a;
        if (u >= -edge && v >= -edge && u + v <= 1 + edge && distance >= 0) best = std::min(best, distance);
    }
    return best;
}

TEST(Raycast, FindsTheFirstTriangle) {
    for (const auto& [origin, spacing] :
         {std::pair{WorldPos{0, 0}, 1.0}, {WorldPos{-500, 1000}, 0.1}, {WorldPos{1e6, 1e6}, 2.0}}) {
        const auto ground = rough_ground(origin, spacing);
        const std::vector<Triangle> triangles = triangles_of(*ground);
        std::mt19937_64 random(27);
        std::uniform_real_distribution<double> unit(0, 1);
        int hits = 0, misses = 0;
        const double side = spacing * (kPosts - 1), scale = std::abs(origin.x) + 20;
        for (int i = 0; i < 2500; ++i) {
            Vec3d from{origin.x + side * unit(random), 0, origin.z + side * unit(random)};
            from.y = ground->height_m({from.x, from.z}) + 3 * unit(random);
            Vec3d direction{(unit(random) - 0.5) * spacing, unit(random) * 0.8 - 0.6, (unit(random) - 0.5) * spacing};
            if (i % 10 == 0) direction.x = 0;
            if (i % 10 == 1) direction.z = 0;
            if (i % 10 == 2) direction.z = direction.x;  // along the diagonals
            if (i % 10 == 3) direction.x = direction.z = 0;
            const std::optional<double> got = raycast(*ground, from, direction, 1000);
            const long double strict = nearest(triangles, from, direction, -1e-9L),
                              loose = nearest(triangles, from, direction, 1e-9L);
            if (std::abs(strict - loose) > 1e-6L || (std::isinf(strict) != std::isinf(loose)))
                continue;  // grazes an edge
            ASSERT_EQ(got.has_value(), !std::isinf(strict)) << "ray " << i;
            if (got) {
                ++hits;
                // Positions are rounded at the size of the coordinates; steep triangles and flat rays magnify that.
                ASSERT_NEAR(*got, static_cast<double>(strict), scale * 1e-11) << "ray " << i;
                const std::optional<double> longer =
                    raycast(*ground, from, {direction.x * 7, direction.y * 7, direction.z * 7}, 1000);
                ASSERT_TRUE(longer);
                ASSERT_NEAR(*longer, *got, scale * 1e-11);  // a distance, whatever the direction's length
                ASSERT_FALSE(raycast(*ground, from, direction, *got * 0.999 - 1e-6)) << "ray " << i;
                ASSERT_TRUE(raycast(*ground, from, direction, *got + 1e-6)) << "ray " << i;
            } else {
                ++misses;
            }
        }
        EXPECT_GT(hits, 500);
        EXPECT_GT(misses, 300);
    }
}

TEST(Raycast, FromUnderTheGroundIsZero) {
    const auto ground = test::flat_ground(9, {}, 10);
    for (const Vec3d& direction : {Vec3d{0, 1, 0}, Vec3d{0, -1, 0}, Vec3d{1, 0.2, 0.3}}) {
        EXPECT_EQ(raycast(*ground, {4.3, 9.9, 4.1}, direction, 100), 0.0);
        EXPECT_EQ(raycast(*ground, {4.3, 10, 4.1}, direction, 100), 0.0);
    }
}

TEST(Raycast, VerticalRays) {
    const auto ground = test::flat_ground(9, {}, 10);
    EXPECT_NEAR(raycast(*ground, {4.3, 15, 4.1}, {0, -1, 0}, 100).value_or(-1), 5, 1e-12);
    EXPECT_NEAR(raycast(*ground, {4, 15, 4}, {0, -2, 0}, 5.001).value_or(-1), 5, 1e-12);
    EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, -1, 0}, 4.999));
    EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, 1, 0}, 100));
    EXPECT_NEAR(raycast(*ground, {4, 15, 4}, {0, -1, 0}, kInf).value_or(-1), 5, 1e-12);
    EXPECT_NEAR(raycast(*ground, {4, 15, 4}, {1e-320, -1, 0}, kInf).value_or(-1), 5, 1e-12);
    EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, 1, 0}, kInf));
    EXPECT_FALSE(raycast(*ground, {-0.001, 15, 4}, {0, -1, 0}, 100));  // beside the map
    EXPECT_NEAR(raycast(*ground, {0, 15, 8}, {0, -1, 0}, 100).value_or(-1), 5, 1e-12);
    EXPECT_NEAR(raycast(*ground, {4, 15, 4}, {0, -1, 0}, 1e9).value_or(-1), 5, 1e-6);
}

TEST(Raycast, LeavingTheMapIsAMissAndEnteringItCounts) {
    const auto ground = test::flat_ground(9, {}, 10);
    EXPECT_FALSE(raycast(*ground, {4, 11, 4}, {1, -0.1, 0}, 1e6));  // would meet the plane at x = 14
    EXPECT_NEAR(raycast(*ground, {4, 11, 4}, {1, -0.5, 0}, 1e6).value_or(-1), std::sqrt(5.0), 1e-9);
    EXPECT_NEAR(raycast(*ground, {-4, 14, 4}, {1, -0.5, 0}, 1e6).value_or(-1), 8 * std::sqrt(1.25), 1e-9);
    EXPECT_FALSE(raycast(*ground, {-4, 14, 4}, {-1, -0.5, 0}, 1e6));
    EXPECT_FALSE(raycast(*ground, {-4, 14, 20}, {1, -0.5, 0}, 1e6));
    EXPECT_NEAR(raycast(*ground, {4, 11, 4}, {1, -0.5, 0}, kInf).value_or(-1), std::sqrt(5.0), 1e-9);
}

TEST(Raycast, BadRaysAreMisses) {
    const auto ground = test::flat_ground(9, {}, 10);
    const double nan = std::nan("");
    for (const double bad : {nan, kInf, -kInf}) {
        EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {bad, -1, 0}, 100));
        EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, bad, 0}, 100));
        EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, -1, bad}, 100));
    }
    EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, 0, 0}, 100));
    EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, -1, 0}, nan));
    EXPECT_FALSE(raycast(*ground, {4, 15, 4}, {0, -1, 0}, -1));
}

}  // namespace
}  // namespace tilth
