// The tile cache's textures over GL: pool, rings, deformer and slopes behind one interface.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tilth/cache/tile_textures.h"
#include "tilth/core/result.h"
#include "tilth/deform/code_bounds.h"
#include "tilth/deform/deformer.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/gl/device.h"
#include "tilth/gl/frame_stats.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/texture_copy.h"
#include "tilth/pool/code_view.h"
#include "tilth/pool/tile_pool.h"
#include "tilth/transfer/read_back_ring.h"
#include "tilth/transfer/upload_ring.h"

namespace tilth {

struct GpuTilesSettings {
    TilePoolSettings pool;
    SlopeSettings slopes;
    /// Of one upload and of one read-back, each way with `slots` of them. A `fill` takes 4 (`bits16`: 2) bytes a texel
    /// for the codes and, with executor cpu, 2 or 4 for the slopes; one that needs more than a slot goes without the
    /// ring and counts as a fallback. Read-backs of any size are cut into slots.
    std::size_t slot_bytes = 512u << 10;
    int slots = 8;
};

/// `TileTextures` with GL. With a deformer it is executor gpu: stamps and slopes are passes. Without one it is executor
/// cpu: `stamp`, `exchange` and the read-backs must not be called; slopes are computed from the field and uploaded with
/// the codes.
///
/// No texture, no pixel buffer and no program exists before it is needed; nothing waits for the GPU but what says so.
/// What a driver refuses goes to the log, once until it works again: without memory `acquire` gives nothing, without
/// the rings or the slope shader uploads and slopes go the slower way and count as fallbacks.
/// Thread: the one that owns the context. GL state: the caller holds a `gl::StateGuard`. `device`, `shaders` and
/// `deformer` outlive it.
class GpuTiles final : public TileTextures {
public:
    /// `deformer` may be shared with other maps: whoever owns it collects its counts of saturated texels and reloads
    /// its shaders.
    static Result<std::unique_ptr<GpuTiles>> create(gl::Device& device, gl::ShaderLibrary& shaders, Deformer* deformer,
                                                    const GpuTilesSettings& settings);

    /// Where the work is counted from now on: `deform`, `derive` (with their times) and `transfer`. Nullptr: nowhere.
    void set_stats(gl::FrameStats* stats) { stats_ = stats != nullptr ? stats : &unwanted_; }

    /// Once a frame: textures that nobody wanted for a while are freed.
    void begin_frame() { pool_.trim(); }

    bool acquire(TileIndex tile) override;
    void release(TileIndex tile) override;
    bool fill(TileIndex tile, const TexelRect& rect, const DetailField& field, bool paging) override;
    Result<void> stamp(std::span<const PreparedStamp> stamps, std::span<const TileIndex> tiles,
                       std::size_t& applied) override;
    [[nodiscard]] std::size_t first_that_may_saturate(std::span<const PreparedStamp> stamps,
                                                      std::span<const TileIndex> tiles) const override;
    [[nodiscard]] CodeRange bounds(TileIndex index, const TexelRect& rect) const override {
        return tile(index).bounds.query(rect);
    }
    void exchange(TileIndex from, TileIndex to, const TexelRect& rect) override;
    bool begin_read_back(TileIndex tile, std::span<const TexelRect> rects) override;
    /// Slices that found no slot in `begin_read_back` are begun here: their codes are those of that moment.
    ReadBackState poll_read_back(TileIndex tile, DetailField& field) override;
    void read_back_now(TileIndex tile, std::span<const TexelRect> rects, DetailField& field) override;
    void finish() override;

    /// For the renderer; nullptr where the tile has no textures.
    [[nodiscard]] const gl::Texture2D* slopes_of(TileIndex tile) const;
    [[nodiscard]] const TileSet* set_of(TileIndex tile) const { return pool_.find(tile); }

    /// For whoever derives more from the textures: while it is on, texels of the map whose codes may have changed in a
    /// tile's textures are noted (tiles that got or lost theirs: all of them), and `take_changes` hands them out.
    void note_changes(bool on);
    [[nodiscard]] std::vector<TexelRect> take_changes();
    [[nodiscard]] bool has_deformer() const { return deformer_ != nullptr; }
    /// Codes of `rect`, a part of the tile's stored rectangle, row by row. Waits: tests and dumps.
    [[nodiscard]] std::vector<std::uint32_t> codes(TileIndex tile, const TexelRect& rect) const;
    /// Whether the tile's ground may lie so high or low at `rect` that `stamp` would saturate.
    [[nodiscard]] bool may_saturate(TileIndex tile, const PreparedStamp& stamp) const;

    [[nodiscard]] const TilePool& pool() const { return pool_; }
    /// Textures of tiles, those waiting to be used again included; what is not touched has none.
    [[nodiscard]] std::uint64_t tile_bytes() const { return pool_.bytes(); }
    /// Pixel buffers of the rings and the slopes' scratch texture.
    [[nodiscard]] std::uint64_t working_bytes() const;
    /// Reads the slope shader again; on failure the last good one stays in use.
    Result<void> reload(gl::ShaderLibrary& shaders);

private:
    /// Part of a read-back that fits a slot: all rectangles of the high plane, then those of the low one.
    using Slice = std::vector<TexelRect>;
    struct ReadBack {
        std::vector<Slice> waiting;  ///< the next one last
        std::vector<std::pair<std::uint64_t, Slice>> in_flight;
        TexelRect stamped_since;  ///< bounds of what came after `begin_read_back`: those codes may be older
    };
    struct Tile {
        TileSet* set = nullptr;
        CodeBounds bounds;
        std::optional<ReadBack> reading;
    };

    GpuTiles(gl::Device& device, gl::ShaderLibrary& shaders, Deformer* deformer, gl::TextureCopy copy,
             const GpuTilesSettings& settings);
    /// Nullptr with executor cpu, and where the shader does not compile.
    SlopePass* slope_pass();
    /// Says it once, until `refused_` is reset.
    void report(const Error& error);
    Tile& tile(TileIndex index);
    [[nodiscard]] const Tile& tile(TileIndex index) const;
    [[nodiscard]] std::size_t code_bytes() const { return settings_.pool.precision == HeightPrecision::bits32 ? 4 : 2; }

    /// With `slopes` those that read the part as well, computed from the field.
    bool fill_through_ring(Tile& tile, const TexelRect& part, const DetailField& field, bool slopes);
    void fill_at_once(Tile& tile, const TexelRect& part, const DetailField& field, bool slopes);
    void note(const TexelRect& rect);
    void note_codes(Tile& tile, const TexelRect& part, const DetailField& field);
    /// What slopes of `stale` read of the tile.
    [[nodiscard]] TexelRect read_by(const TexelRect& stale, const TileSet& set) const;

    [[nodiscard]] std::vector<Slice> slices(std::span<const TexelRect> rects, const TexelRect& held) const;
    bool begin_slice(Tile& tile);
    void take(const Slice& slice, std::span<const std::byte> bytes, Tile& tile, DetailField& field);
    void narrow(Tile& tile, const CodeView& codes);

    gl::Device* device_;
    gl::ShaderLibrary* shaders_;
    Deformer* deformer_;
    gl::TextureCopy copy_;
    GpuTilesSettings settings_;
    TilePool pool_;
    std::optional<SlopePass> slope_pass_;  ///< executor gpu, from the first slopes on
    std::optional<UploadRing> up_;
    std::optional<ReadBackRing> down_;
    std::map<TileIndex, Tile> tiles_;
    GatheredCodes gathered_;
    std::vector<std::uint32_t> arrived_;
    std::vector<TexelRect> changes_;
    std::size_t most_changes_ = 0;  ///< then they are joined
    bool notes_changes_ = false;
    bool refused_ = false;  ///< what the driver refused is in the log
    gl::FrameStats unwanted_;
    gl::FrameStats* stats_ = &unwanted_;
};

}  // namespace tilth
