// The textures of detail tiles: made when a tile is first stamped, used again when it is given up.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>

#include "tilth/core/result.h"
#include "tilth/gl/device.h"
#include "tilth/pool/height_planes.h"
#include "tilth/pool/slope_map.h"
#include "tilth/pool/texture_fill.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// Of a tile's textures, by texel: codes and slopes.
constexpr std::uint64_t bytes_a_texel(HeightPrecision precision, SlopeFormat slopes) {
    return (precision == HeightPrecision::bits32 ? 4u : 2u) + (slopes == SlopeFormat::rg8 ? 2u : 4u);
}

struct TilePoolSettings {
    TileGrid grid;
    HeightPrecision precision = HeightPrecision::bits32;
    SlopeFormat slopes = SlopeFormat::rg8;
    /// Sets of textures that exist at once, those waiting to be used again included; 0: as many as are asked for.
    std::int32_t most_tiles = 0;
};

/// A tile's codes and slopes over its stored rectangle, texel (0, 0) = `grid.stored(tile).min`.
struct TileSet {
    HeightPlanes planes;
    SlopeMap slopes;  ///< one level, not padded
};

/// Owns one set of textures for each tile that asked for one: stored_size^2 texels of 4 bytes (`bits16`: 2) and of a
/// slope (2 or 4). Nothing exists before the first `acquire`. A set that was given up is used again once the GPU is
/// done with everything that was asked of it (its fence has passed); until then the next tile waits for it, so that no
/// more sets exist than were in use at once. A set that nobody wants for `kIdleFrames` frames is freed. Thread: the one
/// that owns the context. GL state: the caller holds a `gl::StateGuard`. Never waits.
class TilePool {
public:
    static constexpr int kIdleFrames = 60;

    TilePool(gl::Device& device, const TilePoolSettings& settings) : device_(&device), settings_(settings) {}

    /// Textures for `tile`, which has none: every code 2^31, every slope flat. Nullptr: all of them are in use or still
    /// read by the GPU; ask again next frame. Fails with OutOfMemory (then fewer tiles fit than `most_tiles`; the pool
    /// is as before), InvalidArgument (tiles larger than the context's textures) or Unsupported.
    Result<TileSet*> acquire(TileIndex tile);
    /// `tile` has textures.
    void release(TileIndex tile);
    /// Frees sets that nobody wanted. Once a frame.
    void trim();

    /// Nullptr where the tile has none. Valid until its `release`.
    [[nodiscard]] TileSet* find(TileIndex tile);
    [[nodiscard]] const TileSet* find(TileIndex tile) const;
    [[nodiscard]] std::size_t resident() const { return tiles_.size(); }
    /// Of all textures that exist.
    [[nodiscard]] std::uint64_t bytes() const;
    /// What one tile's textures take.
    [[nodiscard]] std::uint64_t bytes_per_tile() const;
    [[nodiscard]] const TilePoolSettings& settings() const { return settings_; }

private:
    struct Released {
        std::unique_ptr<TileSet> set;
        gl::Fence done;
        int idle_frames = 0;
    };
    /// A set that nothing uses; nullptr where there is none now.
    Result<std::unique_ptr<TileSet>> take(TileIndex tile);
    Result<std::unique_ptr<TileSet>> make(TileIndex tile);

    gl::Device* device_;
    TilePoolSettings settings_;
    std::optional<TextureFill> fill_;
    std::map<TileIndex, std::unique_ptr<TileSet>> tiles_;
    std::deque<Released> released_;  ///< the oldest first
};

}  // namespace tilth
