// What judges the backends is itself judged: the truth has no error, and a known shift has the error that follows.
#include "render/support/shown_ground.h"

#include <random>

#include "render/support/relief_world.h"

namespace tilth::test {
namespace {

class ShownGroundGlTest : public GlTest {
protected:
    static std::shared_ptr<const HeightSource> ridged() {
        return make_ridged_source({.seed = 7, .size = 129, .relief_m = 1.5});
    }
};

TEST_F(ShownGroundGlTest, TheSurfaceIsTheGroundsOwn) {
    ReliefWorld world(ridged());
    world.print({6.0, 6.1}, 0.4);
    world.stamp({.shape = {0}, .centre = {6.5, 6.2}, .radius_m = 0.5, .amplitude_m = 0.1});
    world.settle({6, 6});
    const ContractSurface surface(world.truth(), {6.2, 6.3}, 1.5);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(0.1, 12.7);
    double most = 0;
    for (int i = 0; i < 20000; ++i) {
        const bool near = i % 2 == 0;
        const double x = near ? 5 + place(random) / 6 : place(random),
                     z = near ? 5.3 + place(random) / 6 : place(random);
        const double at = surface.height_m(x, z);
        // Two ways to the same place in doubles, 1e-14 of a cell apart, on slopes below 10.
        EXPECT_NEAR(at, world.truth().height_m({x, z}), 1e-12);
        most = std::max(most, std::abs(at - world.truth().height_m({x, z}, MapSelect::Coarse)));
    }
    EXPECT_GT(most, 0.05) << "detail was among it";
    EXPECT_NEAR(world.terrain().height_m({6.01, 6.13}), world.truth().height_m({6.01, 6.13}), 1e-15)
        << "the terrain has the same stamps";
}

TEST_F(ShownGroundGlTest, TheMeshIsOnTheSurfaceAndALiftedOneOffByTheLift) {
    ReliefWorld world(ridged());
    for (int i = 0; i < 6; ++i) world.print({5.0 + 0.4 * i, 6.2 + 0.1 * (i % 2)}, 0.1 * i, i % 2 == 0);
    const Target target(480, 270);
    const ContractSurface surface(world.truth(), {6, 6}, 4);
    DetailMesh mesh(surface);
    for (const Vec3d forward : {Vec3d{1, -0.6, 0.1}, Vec3d{0, -1, 0}, Vec3d{0.7, -0.25, 0.5}}) {
        const View view = world.view({4.6, 6.1}, 1.2, forward);
        mesh.draw(target, view);
        const std::vector<float> truth = target.depths();
        const ShownGround same = compare_ground(view, truth, truth, surface, 3.5);
        print_ground("the mesh itself", same);
        EXPECT_GT(same.pixels, 20000);
        EXPECT_EQ(same.wrong, 0);
        EXPECT_EQ(same.background, 0);
        EXPECT_LT(same.p99_px, 0.002);
        EXPECT_LE(same.p99_roundings, 1);

        // Heights of the lifted mesh are 1 cm too high at every place, whatever is shown there.
        const double lift_m = 0.01;
        DetailMesh lifted(surface, lift_m);
        lifted.draw(target, view);
        const std::vector<float> depth = target.depths();
        const ShownGround off = compare_ground(view, depth, truth, surface, 3.5);
        print_ground("lifted by 1 cm", off);
        const PixelRays rays(view);
        double squares = 0;
        long pixels = 0;
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const std::size_t p = static_cast<std::size_t>(y * view.width + x);
                const glm::dvec3 ray = rays.ray(x, y);
                if (truth[p] >= 1 || rays.along_m(truth[p]) * glm::length(ray) > 3.5 || depth[p] >= 1) continue;
                const double cosine = std::hypot(ray.x, ray.z) / glm::length(ray);
                const double error =
                    lift_m * cosine * rays.pixels_per_radian() / (rays.along_m(depth[p]) * glm::length(ray));
                squares += error * error;
                ++pixels;
            }
        EXPECT_EQ(off.pixels, pixels);
        EXPECT_NEAR(off.rms_px, std::sqrt(squares / static_cast<double>(pixels)), 0.002);
    }
}

// Ground that is missing where the truth has it, and the other way round, is counted apart.
TEST_F(ShownGroundGlTest, BackgroundAndWrongPlacesAreCounted) {
    ReliefWorld world(std::make_shared<FlatSource>(129, 0.0));
    const Target target(160, 90);
    const ContractSurface surface(world.truth(), {6, 6}, 2);
    const View view = world.view({6, 6}, 1, {0, -1, 0}, 160, 90);
    DetailMesh(surface).draw(target, view);
    const std::vector<float> truth = target.depths();
    std::vector<float> depth = truth;
    const PixelRays rays(view);
    const auto depth_at = [&](double along) {
        const double n = view.near_m, f = view.far_m;
        return static_cast<float>((f - n * f / along) / (f - n));
    };
    EXPECT_NEAR(rays.along_m(truth[0]), 1, 1e-5) << "the ground is 1 m below, whichever pixel";
    depth[100] = 1;                // a hole
    depth[5000] = depth_at(1.05);  // 5 cm too deep: more than a texel of 3.3 cm
    depth[5001] = depth_at(1.02);  // 2 cm: less
    const ShownGround found = compare_ground(view, depth, truth, surface, 3);
    EXPECT_EQ(found.background, 1);
    EXPECT_EQ(found.wrong, 1);
    EXPECT_EQ(found.wrong_inside, 1);
    EXPECT_EQ(found.pixels, 160 * 90 - 1);
}

}  // namespace
}  // namespace tilth::test
