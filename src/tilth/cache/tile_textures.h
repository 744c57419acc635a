// What the cache asks of the textures: implemented over GL by the facade, by arrays in tests.
#pragma once

#include <cstdint>
#include <span>

#include "tilth/core/result.h"
#include "tilth/ground/code_range.h"
#include "tilth/ground/detail_field.h"
#include "tilth/ground/prepared_stamp.h"
#include "tilth/world/texel.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

enum class ReadBackState : std::uint8_t {
    None,     ///< nothing was begun
    Pending,  ///< its fence has not passed
    Done,     ///< the codes are in the field
    Failed,   ///< the driver refused or lost it: begin again
};

/// Textures of tiles: code planes and slopes over a tile's stored rectangle. All rectangles are texels of the whole
/// detail map. Nothing waits for the GPU but `read_back_now`.
class TileTextures {
public:
    TileTextures() = default;
    virtual ~TileTextures() = default;
    TileTextures(const TileTextures&) = delete;
    TileTextures& operator=(const TileTextures&) = delete;

    /// Gives a tile textures that hold zero codes and flat slopes. False where none is free now (the GPU still reads
    /// the ones that were released, or there is no memory): ask again next frame.
    virtual bool acquire(TileIndex tile) = 0;
    virtual void release(TileIndex tile) = 0;

    /// Copies the codes of `rect`, a part of the tile's stored rectangle, from `field`, and brings the slopes that read
    /// them up to date. `paging`: through the pixel-buffer ring; false where the ring is full now or its buffer cannot
    /// be mapped, and nothing was copied. Otherwise (a stamp of this frame) at once, always true.
    virtual bool fill(TileIndex tile, const TexelRect& rect, const DetailField& field, bool paging) = 0;

    /// Executor gpu. Applies stamps in order to each of `tiles`, their whole stored rectangles, and then their slopes.
    /// `smooth` comes alone, and is followed by `exchange`. Counts saturated texels of the interiors. On an error the
    /// first `applied` stamps are in all tiles, wholly, and of the others none.
    virtual Result<void> stamp(std::span<const PreparedStamp> stamps, std::span<const TileIndex> tiles,
                               std::size_t& applied) = 0;
    /// Executor gpu. Which of the stamps is the first that may leave the range somewhere in the interior of one of
    /// `tiles`, when those before it were applied; their count: none. Cost: that of their bounds, no look at a texel.
    [[nodiscard]] virtual std::size_t first_that_may_saturate(std::span<const PreparedStamp> stamps,
                                                              std::span<const TileIndex> tiles) const = 0;
    /// Executor gpu. Bounds of the codes of `rect`, a part of the tile's interior; never narrower than the truth.
    [[nodiscard]] virtual CodeRange bounds(TileIndex tile, const TexelRect& rect) const = 0;
    /// Executor gpu. Copies codes of `rect` from the tile that owns them to the apron of another, slopes included.
    virtual void exchange(TileIndex from, TileIndex to, const TexelRect& rect) = 0;

    /// Executor gpu. Starts copying codes to the CPU; one read-back a tile at a time. False: the ring is full now.
    virtual bool begin_read_back(TileIndex tile, std::span<const TexelRect> rects) = 0;
    /// Once `Done` the codes of the rectangles have been written to `field`.
    virtual ReadBackState poll_read_back(TileIndex tile, DetailField& field) = 0;
    /// Waits for the GPU: for queries and hashes outside frames.
    virtual void read_back_now(TileIndex tile, std::span<const TexelRect> rects, DetailField& field) = 0;

    /// Waits for the GPU, so that rings and released textures are free again: outside frames.
    virtual void finish() = 0;
};

}  // namespace tilth
