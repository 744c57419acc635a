// How far a captured mesh lies from all texels of the detail: the question of SCIENCE 1.2.
#pragma once

#include "render/support/refinement_check.h"

namespace tilth::test {

/// Metres at size x size texels: overlapping dents of 20 to 120 mm, radius 8 to 24 texels, 400 to a million texels, as
/// science/lod_error.py has them.
inline std::vector<float> stamped_field(std::int32_t size, std::uint64_t seed,
                                        const std::function<double(double)>& profile) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(0, size), radius(8, 24), depth(0.020, 0.120);
    std::vector<double> sum(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    for (int i = 0; i < 400 * size / 1024 * size / 1024; ++i) {
        const double cx = place(random), cz = place(random), r = radius(random), amplitude = depth(random);
        const auto clamped = [&](double at) { return std::clamp(static_cast<std::int32_t>(at), 0, size - 1); };
        for (std::int32_t z = clamped(cz - 4 * r); z <= clamped(cz + 4 * r); ++z)
            for (std::int32_t x = clamped(cx - 4 * r); x <= clamped(cx + 4 * r); ++x)
                sum[static_cast<std::size_t>(z) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x)] -=
                    amplitude * profile(((x - cx) * (x - cx) + (z - cz) * (z - cz)) / (r * r));
    }
    return {sum.begin(), sum.end()};
}

struct MeshError {
    double rms_m = 0, max_m = 0;
};

/// 63 x 63 posts' cells of 16 texels on a plane, split by the last factor; the error at every texel, in double. The
/// plane is taken from the ground's posts.
inline MeshError error_of_mesh(RefinementScene& scene, const std::vector<std::int32_t>& chain) {
    constexpr std::int32_t kTexels = 16, kCells = 63;
    const RefinementSetting s{
        .texels_per_post = kTexels, .chain = chain, .spacing_m = 0.48f, .base_post = {10, 10}, .base_texel = {0, 0}};
    const double base_m = scene.base_m(s.base_post, s);
    const double per_x_m = scene.base_m({11, 10}, s) - base_m, per_z_m = scene.base_m({10, 11}, s) - base_m;
    MeshError error;
    std::size_t texels = 0;
    std::vector<bool> met(static_cast<std::size_t>(kTexels * kCells + 1) * (kTexels * kCells + 1));
    for (std::int32_t block = 0; block < 4; ++block) {
        // Blocks of 32 x 32 cells and, as the last post would be beyond the window, of 31 on the far sides.
        const RefinementMesh mesh{.corners = block_triangles(block == 0 ? 32 : 31),
                                  .blocks = {{10 + 32 * (block % 2), 10 + 32 * (block / 2)}}};
        const auto f = static_cast<std::size_t>(chain.back());
        const auto triangles =
            scene.capture(RefinementScene::Stages::Refined, s, mesh, mesh.corners.size() * f * f + 100);
        EXPECT_EQ(triangles.size(), mesh.corners.size() * f * f);
        for (const auto& triangle : triangles) {
            std::array<Texel, 3> at;
            std::array<double, 3> y{};
            for (std::size_t v = 0; v < 3; ++v) {
                const auto texel = [&](std::size_t axis) {
                    const double m = double{triangle[v].position_m[axis]} + double{s.fraction_m[axis / 2]};
                    return static_cast<std::int32_t>(std::lround(m / double{s.spacing_m} * kTexels));
                };
                at[v] = {texel(0), texel(2)};
                y[v] = double{triangle[v].position_m[1]};
            }
            const auto area = static_cast<double>(refinement::cross(at[0], at[1], at[2]));
            const auto [x0, x1] = std::minmax({at[0].x, at[1].x, at[2].x});
            const auto [z0, z1] = std::minmax({at[0].z, at[1].z, at[2].z});
            for (std::int32_t z = z0; z <= z1; ++z)
                for (std::int32_t x = x0; x <= x1; ++x) {
                    std::array<double, 3> w{};
                    for (std::size_t v = 0; v < 3; ++v)
                        w[v] = static_cast<double>(refinement::cross({x, z}, at[(v + 1) % 3], at[(v + 2) % 3])) / area;
                    const std::size_t index =
                        static_cast<std::size_t>(z) * (kTexels * kCells + 1) + static_cast<std::size_t>(x);
                    if (std::min({w[0], w[1], w[2]}) < 0 || met.at(index)) continue;
                    met[index] = true;
                    const double plane_m = base_m + per_x_m * x / kTexels + per_z_m * z / kTexels;
                    const double shown_m = w[0] * y[0] + w[1] * y[1] + w[2] * y[2] - plane_m;
                    const double off = shown_m - scene.detail_at_m(x, z, kTexels, s);
                    error.rms_m += off * off;
                    error.max_m = std::max(error.max_m, std::abs(off));
                    ++texels;
                }
        }
    }
    EXPECT_GT(texels, met.size() * 95 / 100) << "texels under the mesh";
    error.rms_m = std::sqrt(error.rms_m / static_cast<double>(texels));
    return error;
}

}  // namespace tilth::test
