// Cameras: orthonormal whatever the direction, exact far from the origin, refused with a name; culling hides nothing.
#include "tilth/render/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tilth {
namespace {

const GridSpec kGrid{{0, 0}, 1.0, 1025, 1025};
const HeightCodec kCodec{100, 1.0 / 64};

double dot(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Camera camera_of(const View& view, const GridSpec& grid = kGrid, const HeightCodec& codec = kCodec) {
    Result<Camera> camera = make_camera(view, grid, codec);
    EXPECT_TRUE(camera) << (camera ? "" : camera.error().message);
    return camera ? *camera : Camera{};
}

TEST(Camera, IsOrthonormalInEveryDirection) {
    const Vec3d directions[] = {{0, -1, 0},      {0, 1, 0},     {0, 0, -1},           {0, 0, 1},
                                {1, 0, 0},       {1e-9, -1, 0}, {1e-200, -1e-199, 0}, {3e150, 4e150, -5e150},
                                {0.3, -0.2, 0.8}};
    const Vec3d ups[] = {{0, 1, 0}, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 5, 1e-12}};
    for (const Vec3d& forward : directions) {
        for (const Vec3d& up : ups) {
            const Camera c = camera_of({.eye = {5, 5, 5}, .forward = forward, .up = up, .width = 16, .height = 9});
            EXPECT_NEAR(dot(c.forward, c.forward), 1, 1e-12);
            EXPECT_NEAR(dot(c.right, c.right), 1, 1e-12);
            EXPECT_NEAR(dot(c.up, c.up), 1, 1e-12);
            EXPECT_NEAR(dot(c.forward, c.right), 0, 1e-12);
            EXPECT_NEAR(dot(c.forward, c.up), 0, 1e-12);
            EXPECT_NEAR(dot(c.right, c.up), 0, 1e-12);
            const Vec3d cross{c.right.y * c.up.z - c.right.z * c.up.y, c.right.z * c.up.x - c.right.x * c.up.z,
                              c.right.x * c.up.y - c.right.y * c.up.x};
            EXPECT_NEAR(dot(cross, c.forward), -1, 1e-12) << "right-handed";
        }
    }
    // Seen from above, a map has north (-z) on top and east (x) on the right.
    const Camera down = camera_of({.forward = {0, -1, 0}, .width = 1, .height = 1});
    EXPECT_NEAR(down.right.x, 1, 1e-12);
    EXPECT_NEAR(down.up.z, -1, 1e-12);
}

// The picture must not know where the world's origin is: every float is the same, bit for bit.
TEST(Camera, IsTheSameFarFromTheOrigin) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> within(0, 1000);
    for (int i = 0; i < 200; ++i) {
        const View near{.eye = {within(random), within(random), within(random)},
                        .forward = {1, -0.2, 0.4},
                        .width = 160,
                        .height = 90};
        // Eyes are doubles: what 1e7 cannot hold (2^-29 m) is not asked for.
        const auto coarse = [](double v) { return std::floor(v * 16777216) / 16777216; };
        View a = near;
        a.eye = {coarse(near.eye.x), coarse(near.eye.y), coarse(near.eye.z)};
        for (const double far : {1e3, 1e5, 1e7, -1e7}) {
            for (const double spacing : {1.0, 0.1, 30.0}) {
                const GridSpec here{{0, 0}, spacing, 1025, 1025}, there{{far, -far}, spacing, 1025, 1025};
                const HeightCodec high{100 + far, 1.0 / 64};
                View b = a;
                b.eye = {a.eye.x + far, a.eye.y + far, a.eye.z - far};
                const Camera ca = camera_of(a, here), cb = camera_of(b, there, high);
                ASSERT_EQ(ca.base_x, cb.base_x);
                ASSERT_EQ(ca.base_z, cb.base_z);
                ASSERT_EQ(ca.fraction_x_m, cb.fraction_x_m);
                ASSERT_EQ(ca.fraction_z_m, cb.fraction_z_m);
                ASSERT_EQ(ca.eye_code, cb.eye_code);
                ASSERT_EQ(ca.eye_above_code_m, cb.eye_above_code_m);
                ASSERT_EQ(ca.clip_from_relative, cb.clip_from_relative);
            }
        }
    }
}

TEST(Camera, PartsAddUpToTheEye) {
    for (const double y : {-2000.0, 99.123, 100.0, 611.9, 612.1, 5000.0}) {  // the codec spans -412 .. 612 m
        const Camera c = camera_of({.eye = {-3.7, y, 2000.4}, .width = 2, .height = 2}, {{10, 20}, 0.1, 100, 100});
        EXPECT_NEAR(c.base_x * 0.1 + static_cast<double>(c.fraction_x_m), -13.7, 1e-6);
        EXPECT_NEAR(c.base_z * 0.1 + static_cast<double>(c.fraction_z_m), 1980.4, 1e-6);
        EXPECT_TRUE(c.fraction_x_m >= 0 && c.fraction_x_m < 0.1001f);
        EXPECT_NEAR(kCodec.height_m(c.eye_code) + static_cast<double>(c.eye_above_code_m), y, 1e-4);
        if (y > kCodec.min_m() && y < kCodec.max_m()) {
            EXPECT_LT(std::abs(c.eye_above_code_m), 1e-6f);
        }
    }
}

TEST(Camera, RefusesByName) {
    const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
    const auto message = [](View view) {
        const Result<Camera> camera = make_camera(view, kGrid, kCodec);
        return camera ? std::string("accepted") : camera.error().message;
    };
    const View good{.width = 4, .height = 4};
    const auto changed = [&](auto change) {
        View view = good;
        change(view);
        return message(view);
    };
    EXPECT_EQ(message(good), "accepted");
    const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
    EXPECT_TRUE(has(changed([&](View& v) { v.eye.y = nan; }), "view.eye"));
    EXPECT_TRUE(has(changed([&](View& v) { v.forward = {0, 0, 0}; }), "view.forward"));
    EXPECT_TRUE(has(changed([&](View& v) { v.forward.x = infinite; }), "view.forward"));
    EXPECT_TRUE(has(changed([&](View& v) { v.up.z = nan; }), "view.up"));
    EXPECT_TRUE(has(changed([&](View& v) { v.fov_y_rad = nan; }), "fov_y_rad"));
    EXPECT_TRUE(has(changed([&](View& v) { v.near_m = 0; }), "near_m"));
    EXPECT_TRUE(has(changed([&](View& v) { v.near_m = -1; }), "near_m"));
    EXPECT_TRUE(has(changed([&](View& v) { v.far_m = 0.1; }), "far_m"));
    EXPECT_TRUE(has(changed([&](View& v) { v.far_m = nan; }), "far_m"));
    EXPECT_TRUE(has(changed([&](View& v) { v.width = -1; }), "width"));
    EXPECT_EQ(changed([&](View& v) { v.far_m = infinite; }), "accepted");
    for (const double fov : {0.0, -1.0, 3.2, 1e9}) {
        View view = good;
        view.fov_y_rad = fov;
        for (const float m : camera_of(view).clip_from_relative) EXPECT_TRUE(std::isfinite(m)) << fov;
    }
}

TEST(Camera, DrawsNothingWithoutPixelsOrOutOfReach) {
    EXPECT_FALSE(camera_of({.width = 0, .height = 0}).draws);
    EXPECT_FALSE(camera_of({.width = 0, .height = 5}).draws);
    EXPECT_FALSE(camera_of({.eye = {1e300, 0, 0}, .width = 5, .height = 5}).draws);
    EXPECT_TRUE(camera_of({.width = 1, .height = 1}).draws);
    EXPECT_TRUE(camera_of({.width = 16384, .height = 1}).draws);
}

// Any point of any box that projects onto the screen, by the same float matrix as the shader's, keeps its box.
TEST(Camera, CullingNeverHidesAVisiblePoint) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    int seen = 0, culled = 0;
    for (int i = 0; i < 20000; ++i) {
        View view{.eye = {500, 120, 500},
                  .forward = {unit(random), unit(random), unit(random)},
                  .up = {unit(random), unit(random), unit(random)},
                  .fov_y_rad = 0.05 + 1.5 * (1 + unit(random)),
                  .width = 1 + static_cast<std::int32_t>(random() % 2000),
                  .height = 1 + static_cast<std::int32_t>(random() % 2000)};
        if (i % 3 == 0) view.depth = DepthConvention::Reversed;
        if (i % 5 == 0) view.far_m = std::numeric_limits<double>::infinity();
        const Camera c = camera_of(view);
        const double reach = std::pow(10, 2.5 * (1 + unit(random)) - 1), size = reach * (1 + unit(random));
        const Vec3d centre{unit(random) * reach, unit(random) * reach, unit(random) * reach};
        const Vec3d half{size * (1 + unit(random)), size * (1 + unit(random)), size * (1 + unit(random))};
        const RelativeBox box{{centre.x - half.x, centre.y - half.y, centre.z - half.z},
                              {centre.x + half.x, centre.y + half.y, centre.z + half.z}};
        const bool hidden = is_culled(box, c);
        culled += hidden;
        const auto corner = [&] { return std::round(unit(random)); };  // corners, edges, faces, middle
        for (int p = 0; p < 20; ++p) {
            const float x = static_cast<float>(centre.x + corner() * half.x);
            const float y = static_cast<float>(centre.y + corner() * half.y);
            const float z = static_cast<float>(centre.z + corner() * half.z);
            const auto clip = [&](int row) {
                const auto m = [&](int column) {
                    return c.clip_from_relative[static_cast<std::size_t>(column * 4 + row)];
                };
                return m(0) * x + m(1) * y + m(2) * z + m(3);
            };
            const float w = clip(3);
            const float near = view.depth == DepthConvention::Reversed ? 0.0f : -w;
            const bool visible =
                w > 0 && std::abs(clip(0)) <= w && std::abs(clip(1)) <= w && clip(2) >= near && clip(2) <= w;
            seen += visible;
            ASSERT_FALSE(visible && hidden) << i;
        }
    }
    EXPECT_GT(seen, 10000) << "the test looked at something";
    EXPECT_GT(culled, 2000) << "and something was culled";
}

}  // namespace
}  // namespace tilth
