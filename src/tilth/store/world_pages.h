// The pages of both maps in a world's store: which there are, what of them is new.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/map_geometry.h"
#include "tilth/ground/page.h"
#include "tilth/store/blob_store.h"
#include "tilth/world/texel.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// Reads and writes pages as blobs. Knows the hash of every page that went through its hands, so that what did not
/// change is not written again, and which pages were put since the last commit. Threads: one at a time.
class WorldPages {
public:
    /// `coarse`: geometry of the coarse map. `original`: code of its texels before any stamp. `name`: of the world, for
    /// messages.
    WorldPages(BlobStore& blobs, std::string name, std::int32_t tile_size, const MapGeometry& coarse,
               std::function<std::uint32_t(Texel)> original);
    /// Before anything else.
    Result<void> read_keys();

    [[nodiscard]] std::vector<TileIndex> tiles() const;
    [[nodiscard]] TileIndex tile_of(PageIndex page) const {
        return {floor_divide(page.x, pages_a_tile_), floor_divide(page.z, pages_a_tile_)};
    }
    [[nodiscard]] bool has(MapKind map, PageIndex page) const;
    [[nodiscard]] std::vector<PageIndex> keys(MapKind map) const;
    /// Of one tile.
    [[nodiscard]] std::vector<PageIndex> keys(TileIndex tile) const;

    struct Found {
        std::vector<Page> pages;
        std::map<PageIndex, Error> damaged;  ///< errors of which `is_damage` holds; any other one fails the whole
    };
    Result<Found> load(TileIndex tile, const PageRect& pages);
    Result<Found> load_coarse();
    /// One page, without taking note of it. Fails (`is_damage`) where it is damaged.
    Result<Page> read(MapKind map, PageIndex page);

    /// As `TileStore::save`. After an error the tile is *torn*: neither old nor new, until a save goes well.
    Result<void> save(TileIndex tile, std::span<const Page> pages);
    [[nodiscard]] std::optional<TileIndex> torn() const;
    [[nodiscard]] bool is_torn(TileIndex tile) const { return torn_.contains(tile); }
    /// A page that is as before any stamp is erased.
    Result<void> save_coarse(const Page& page);
    /// In place of a damaged one.
    Result<void> replace(MapKind map, const Page& page);
    Result<void> erase(MapKind map, PageIndex page);

    /// Put since the last commit: nobody can say as of which edit.
    [[nodiscard]] bool is_pending(PageIndex page) const { return detail_pending_.put.contains(page); }
    void committed() { coarse_pending_ = detail_pending_ = {}; }
    /// What was put since the last commit that went well may be gone from the disk: whatever is read of it now, the
    /// next save writes it again.
    void commit_failed();

private:
    /// Of the codes that the store has; empty: not known.
    using Hashes = std::map<PageIndex, std::optional<std::uint64_t>>;
    struct Pending {
        std::set<PageIndex> put;       ///< since the last commit
        std::set<PageIndex> doubtful;  ///< of those: not again since a commit failed
    };
    [[nodiscard]] Pending& pending(MapKind map) { return map == MapKind::Coarse ? coarse_pending_ : detail_pending_; }
    [[nodiscard]] Hashes& hashes(MapKind map, PageIndex page) {
        return map == MapKind::Coarse ? coarse_ : detail_[tile_of(page)];
    }
    Result<void> put(MapKind map, const Page& page, std::uint64_t hash);
    Result<Found> load(MapKind map, Hashes& known, const PageRect* pages);
    [[nodiscard]] PageCodes original_page(PageIndex page) const;

    BlobStore& blobs_;
    std::string name_;
    std::int32_t pages_a_tile_;
    MapGeometry coarse_map_;
    std::function<std::uint32_t(Texel)> original_;
    std::map<TileIndex, Hashes> detail_;
    Hashes coarse_;
    std::set<TileIndex> torn_;
    Pending coarse_pending_, detail_pending_;
};

}  // namespace tilth
