// Heights on the triangles of the contract, against planes through three posts.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ground/support.h"
#include "tilth/source/mirrored_source.h"

namespace tilth {
namespace {

/// A rough ground of 17 posts a side with stamps on its detail map.
std::unique_ptr<Ground> rough_ground(GroundSettings settings) {
    auto ground = test::flat_ground(17, settings);
    std::mt19937 random(23);
    const std::uint32_t kept = settings.precision == HeightPrecision::bits16 ? 0xffff0000u : 0xffffffffu;
    for (std::uint32_t& code : ground->mutable_coarse().codes())
        code = (0x70000000u + (static_cast<std::uint32_t>(random()) >> 3)) & kept;
    for (int i = 0; i < 60 && settings.detail; ++i)
        test::stamp(*ground, {.shape = {static_cast<std::uint32_t>(random() % 6)},
                              .centre = {settings.origin.x + settings.spacing_m * (random() % 1700) / 100,
                                         settings.origin.z + settings.spacing_m * (random() % 1700) / 100},
                              .radius_m = settings.spacing_m * (0.3 + random() % 20 * 0.1),
                              .amplitude_m = 0.3,
                              .map = MapChoice::Detail});
    return ground;
}

/// Height at (x, z), in posts of the map, of the plane through the three corners of the triangle there: Cramer's rule.
template <class CodeAt>
long double on_triangle(const MapGeometry& map, long double x, long double z, const CodeAt& code_at) {
    const int i = std::clamp(static_cast<int>(std::floor(x)), 0, map.grid.width - 2),
              j = std::clamp(static_cast<int>(std::floor(z)), 0, map.grid.depth - 2);
    const int corners[3][2] = {{i, j}, {i + 1, j + 1}, {x - i > z - j ? i + 1 : i, x - i > z - j ? j : j + 1}};
    long double h[3];
    for (int k = 0; k < 3; ++k)
        h[k] = map.codec.middle_m +
               (static_cast<long double>(code_at(Texel{corners[k][0], corners[k][1]})) - 2147483648.0L) *
                   map.codec.quantum_m / 65536;
    const long double ax = corners[1][0] - corners[0][0], az = corners[1][1] - corners[0][1],
                      bx = corners[2][0] - corners[0][0], bz = corners[2][1] - corners[0][1];
    const long double px = x - corners[0][0], pz = z - corners[0][1], area = ax * bz - az * bx;
    return h[0] + (px * bz - pz * bx) / area * (h[1] - h[0]) + (ax * pz - az * px) / area * (h[2] - h[0]);
}

TEST(HeightQuery, IsThePlaneOfTheContractsTriangles) {
    for (const GroundSettings& settings :
         {GroundSettings{}, GroundSettings{.origin = {-700, 40}, .spacing_m = 0.1},
          GroundSettings{.origin = {1e7, -1e7}, .spacing_m = 0.25, .texels_per_post = 4},
          GroundSettings{.texels_per_post = 1, .precision = HeightPrecision::bits16},
          GroundSettings{.detail = false}}) {
        const auto ground = rough_ground(settings);
        const MapGeometry &coarse = ground->map(MapKind::Coarse), &detail = ground->map(MapKind::Detail);
        std::mt19937_64 random(24);
        for (int i = 0; i < 20000; ++i) {
            const WorldPos at{settings.origin.x + settings.spacing_m * 16 * static_cast<double>(random()) * 0x1p-64,
                              settings.origin.z + settings.spacing_m * 16 * static_cast<double>(random()) * 0x1p-64};
            const auto posts = [&](const MapGeometry& map, double p, double origin) {
                return (static_cast<long double>(p) - origin) / map.grid.spacing_m;
            };
            const long double low =
                on_triangle(coarse, posts(coarse, at.x, settings.origin.x), posts(coarse, at.z, settings.origin.z),
                            [&](Texel t) { return ground->coarse().code(t); });
            const long double high = settings.detail ? on_triangle(detail, posts(detail, at.x, settings.origin.x),
                                                                   posts(detail, at.z, settings.origin.z),
                                                                   [&](Texel t) { return ground->detail().code(t); })
                                                     : 0.0L;
            // Doubles: positions err by an ulp of 16 texels, heights (under 64 m) by a few ulps; slopes are below 100 m
            // a texel.
            ASSERT_NEAR(ground->height_m(at, MapSelect::Coarse), static_cast<double>(low), 1e-11);
            ASSERT_NEAR(ground->height_m(at, MapSelect::Detail), static_cast<double>(high), 1e-11);
            ASSERT_NEAR(ground->height_m(at), static_cast<double>(low + high), 1e-11);
        }
    }
}

TEST(HeightQuery, IsExactAtPostsAndContinuesOutside) {
    const auto ground = rough_ground({.spacing_m = 0.5, .texels_per_post = 4});
    const MapGeometry &coarse = ground->map(MapKind::Coarse), &detail = ground->map(MapKind::Detail);
    for (int z = 0; z < 17; ++z)
        for (int x = 0; x < 17; ++x)
            ASSERT_EQ(ground->height_m(coarse.grid.world({x, z}), MapSelect::Coarse),
                      coarse.codec.height_m(ground->coarse().code({x, z})));
    for (int z = 0; z < 65; ++z)
        for (int x = 0; x < 65; ++x)
            ASSERT_EQ(ground->height_m(detail.grid.world({x, z}), MapSelect::Detail),
                      detail.codec.height_m(ground->detail().code({x, z})));
    for (const double s : {0.0, 1.25, 3.1, 8.0}) {
        for (const double out : {-1e-9, -3.0, -1e12}) {
            EXPECT_EQ(ground->height_m({out, s}), ground->height_m({0, s}));
            EXPECT_EQ(ground->height_m({s, out}), ground->height_m({s, 0}));
            EXPECT_EQ(ground->height_m({8 - out, s}), ground->height_m({8, s}));
            EXPECT_EQ(ground->height_m({s, 8 - out}), ground->height_m({s, 8}));
            EXPECT_EQ(ground->height_m({out, out}), ground->height_m({0, 0}));
        }
    }
}

// Which diagonal: with one post raised, the cell's other diagonal shows it differently.
TEST(HeightQuery, CellsAreSplitFromTheirFirstToTheirLastPost) {
    auto ground = test::flat_ground(3, {.detail = false}, 0);
    const auto raise = [&](Texel t, double h) {
        ground->mutable_coarse().set_code(t, ground->map(MapKind::Coarse).codec.code(h, HeightPrecision::bits32));
    };
    raise({1, 0}, 1);
    EXPECT_EQ(ground->height_m({0.5, 0.5}), 0.0);
    EXPECT_EQ(ground->height_m({0.75, 0.25}), 0.5);
    EXPECT_EQ(ground->height_m({0.25, 0.75}), 0.0);
    raise({1, 0}, 0), raise({1, 1}, 1);
    EXPECT_EQ(ground->height_m({0.5, 0.5}), 0.5);
}

TEST(HeightQuery, AMirroredWorldIsTheReflectedSource) {
    const auto ground = test::flat_ground(17, {.mirror = true});
    std::mt19937 random(25);
    for (std::uint32_t& code : ground->mutable_coarse().codes())
        code = 0x70000000u + (static_cast<std::uint32_t>(random()) >> 3);
    const HeightCodec& codec = ground->map(MapKind::Coarse).codec;
    EXPECT_EQ(ground->map(MapKind::Coarse).grid.width, 1 << 20);
    for (int i = 0; i < 2000; ++i) {
        const int x = static_cast<int>(random() % (1 << 20)), z = static_cast<int>(random() % (1 << 20));
        const int sx = 16 - std::abs(x % 32 - 16), sz = 16 - std::abs(z % 32 - 16);
        ASSERT_EQ(ground->height_m({static_cast<double>(x), static_cast<double>(z)}),
                  codec.height_m(ground->coarse().code({sx, sz})));
    }
    EXPECT_EQ(ground->height_m({1e9, 4}), ground->height_m({(1 << 20) - 1.0, 4}));
}

}  // namespace
}  // namespace tilth
