// Which tiles a block reads, against counting its texels one by one; and that placements are exact anywhere.
#include "tilth/render/detail_blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tilth {
namespace {

/// Only its address is used: a tile that is there.
const gl::Texture2D* some_texture() {
    alignas(gl::Texture2D) static char memory[sizeof(gl::Texture2D)];
    return reinterpret_cast<const gl::Texture2D*>(memory);
}

Camera camera_at(double x_m, double z_m, double spacing_m) {
    Camera camera;
    camera.eye_x_m = x_m, camera.eye_z_m = z_m;
    camera.base_x = static_cast<std::int32_t>(std::floor(x_m / spacing_m));
    camera.base_z = static_cast<std::int32_t>(std::floor(z_m / spacing_m));
    return camera;
}

TEST(DetailBlocks, ReadTheTilesThatTheirTexelsLieIn) {
    std::mt19937 random(5);
    const auto up_to = [&](std::int32_t n) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(n)); };
    int seen[6] = {};
    for (int round = 0; round < 6000; ++round) {
        const std::int32_t per_post = 1 + up_to(5);
        const GridSpec grid{{0, 0}, 0.5, 257, 193};
        DetailView detail;
        detail.spacing_m = 0.5 / per_post;
        detail.grid = {64 * (1 + up_to(4)), 2, {{0, 0}, {256 * per_post + 1, 192 * per_post + 1}}};
        const TileIndex last = detail.grid.tile_of({detail.grid.map.max.x - 1, detail.grid.map.max.z - 1});
        detail.window.min = {up_to(last.x + 1), up_to(last.z + 1)};
        detail.window.max = {std::min(detail.window.min.x + up_to(2), last.x),
                             std::min(detail.window.min.z + up_to(2), last.z)};
        for (std::int32_t z = 0; z < detail.window.rows(); ++z)
            for (std::int32_t x = 0; x < detail.window.columns(); ++x)
                if (up_to(3) > 0) detail.slopes[static_cast<std::size_t>(z * 2 + x)] = some_texture();
        detail.reach_m = 5 + up_to(60);
        // About the window, so that every answer comes up.
        const std::int32_t tile_posts = detail.grid.size / per_post;
        const Texel first{std::min((detail.window.min.x + up_to(3)) * tile_posts + up_to(tile_posts), 255),
                          std::min((detail.window.min.z + up_to(3)) * tile_posts + up_to(tile_posts), 191)};
        const Texel end{std::min(first.x + 1 + up_to(10), 256), std::min(first.z + 1 + up_to(10), 192)};
        const Camera camera = camera_at(first.x * 0.5 + up_to(60) - 30, first.z * 0.5 + up_to(60) - 30, 0.5);

        bool in_reach = false, all_in_one = true;
        std::optional<TileIndex> one;
        bool any_there = false;
        for (std::int32_t z = first.z; z <= end.z; ++z)
            for (std::int32_t x = first.x; x <= end.x; ++x)
                in_reach |= std::hypot(x * 0.5 - camera.eye_x_m, z * 0.5 - camera.eye_z_m) < detail.reach_m;
        for (std::int32_t z = first.z * per_post - kDetailTapTexels; z <= end.z * per_post + kDetailTapTexels; ++z) {
            for (std::int32_t x = first.x * per_post - kDetailTapTexels; x <= end.x * per_post + kDetailTapTexels;
                 ++x) {
                if (!detail.grid.map.contains({x, z})) continue;
                const TileIndex tile = detail.grid.tile_of({x, z});
                if (!one) one = tile;
                all_in_one &= tile == *one;
                if (detail.window.contains(tile))
                    any_there |= detail.slopes[static_cast<std::size_t>((tile.z - detail.window.min.z) * 2 + tile.x -
                                                                        detail.window.min.x)] != nullptr;
            }
        }
        const DetailSource source = detail_source(detail, first, end, grid, camera);
        ++seen[static_cast<int>(source)];
        if (!in_reach && source != DetailSource::None) {
            // The eye may be nearest to a point between two posts; never farther than half a spacing from one.
            EXPECT_GT(detail.reach_m + 0.5,
                      std::hypot(std::max({first.x * 0.5 - camera.eye_x_m, camera.eye_x_m - end.x * 0.5, 0.0}),
                                 std::max({first.z * 0.5 - camera.eye_z_m, camera.eye_z_m - end.z * 0.5, 0.0})));
            continue;
        }
        if (!in_reach || !any_there) {
            EXPECT_EQ(source, DetailSource::None);
        } else if (!all_in_one) {
            EXPECT_EQ(source, DetailSource::Window);
        } else {
            EXPECT_EQ(static_cast<int>(source), 1 + (one->z - detail.window.min.z) * 2 + one->x - detail.window.min.x);
        }
    }
    for (const int count : seen) EXPECT_GT(count, 5) << "every answer is asked for";
}

// The float is the integer: tiles at texel 2^26 and more, eyes on either side of a tile's corner.
TEST(DetailBlocks, PlacementIsExactFarFromTheOrigin) {
    const GridSpec grid{{0, 0}, 1.0, 257, 257};
    DetailView detail;
    detail.spacing_m = 1.0 / 64;
    detail.grid = {2048, 2, {{0, 0}, {(1 << 26) - 63, (1 << 26) - 63}}};
    for (const std::int32_t tile : {0, 1, 17, 32767}) {
        for (const std::int32_t offset : {-3, 0, 31, 40}) {
            const std::int32_t post = tile * 32 + offset;
            const DetailPlacement at =
                detail_placement(detail, {tile, tile / 2}, grid, camera_at(post + 0.25, tile / 2 * 32 + 0.75, 1.0));
            EXPECT_EQ(at.base_x, static_cast<float>(offset * 64));
            EXPECT_EQ(at.base_z, 0.0f);
            if (tile == 32767) {
                EXPECT_EQ(at.map_edge[2], 2048.0f - 64.0f);
            }
        }
    }
    detail.spacing_m = 0.1 / 3;
    EXPECT_EQ(texels_per_post(detail, {{0, 0}, 0.1, 2, 2}), 3);
}

}  // namespace
}  // namespace tilth
