// A whole terrain in the reference's layout (texels of 1/30 m in tiles of 2 048), and places on it in texels.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "support/bench_device.h"
#include "tilth/core/hash.h"
#include "tilth/terrain.h"

namespace tilth::bench {

class BenchTerrain {
public:
    /// `store`: empty for one of its own.
    BenchTerrain(std::shared_ptr<const HeightSource> source, ExecutorKind executor,
                 std::shared_ptr<TileStore> store = nullptr)
        : terrain_(value(Terrain::create(std::move(source), settings(executor, std::move(store)), get_proc()))) {}

    [[nodiscard]] Terrain& operator*() const { return *terrain_; }
    [[nodiscard]] Terrain* operator->() const { return terrain_.get(); }

    [[nodiscard]] std::int32_t tile_texels() const { return terrain_->tile_grid().size; }
    [[nodiscard]] WorldPos place(PostPos texels) const {
        const GridSpec& map = terrain_->ground().map(MapKind::Detail).grid;
        return {map.origin.x + texels.x * map.spacing_m, map.origin.z + texels.z * map.spacing_m};
    }
    void put_viewer(PostPos texels) const {
        const WorldPos at = place(texels);
        terrain_->set_viewers({&at, 1});
    }
    /// Lets all tiles go, and waits until the store has them.
    void leave() const {
        terrain_->set_viewers({});
        const auto is_here = [](const TileReport& tile) { return tile.state != TileState::Absent; };
        do {
            settle();
            const std::vector<TileReport> tiles = terrain_->tiles();
            if (std::none_of(tiles.begin(), tiles.end(), is_here)) return;
        } while (true);
    }
    /// Queues a stamp of `radius_texels` on the detail map.
    StampRecord stamp(PostPos texels, double radius_texels, double amplitude_m) const {
        return value(
            terrain_->stamp({.centre = place(texels),
                             .radius_m = radius_texels * terrain_->ground().map(MapKind::Detail).grid.spacing_m,
                             .amplitude_m = amplitude_m,
                             .map = MapChoice::Detail,
                             .key = 1}));
    }
    void frame() const { check(terrain_->update(1.0 / 60)); }
    /// Frames until everything that was asked for has come; ends with nothing on its way.
    void settle() const {
        frame();
        check(terrain_->drain());
        device_finish();
    }
    /// XXH3-64 of both maps' hashes.
    [[nodiscard]] std::uint64_t hash() const {
        const StateHash state = value(terrain_->hash());
        const std::uint64_t both[] = {state.coarse, state.detail};
        return hash_bytes(std::as_bytes(std::span(both)));
    }

private:
    static TerrainSettings settings(ExecutorKind executor, std::shared_ptr<TileStore> store) {
        TerrainSettings made{.executor = executor};
        made.ground = {.spacing_m = 0.1, .texels_per_post = 3, .tile_size = 2048};
        made.tiles.store = std::move(store);
        return made;
    }
    static void device_finish() { device().gl().Finish(); }

    std::unique_ptr<Terrain> terrain_;
};

}  // namespace tilth::bench
