// What a world's store lost, made again from the original ground and the journal.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/map_geometry.h"
#include "tilth/ground/shape_library.h"
#include "tilth/ground/undo_history.h"
#include "tilth/store/file_system.h"
#include "tilth/store/journal.h"
#include "tilth/store/snapshot.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// Of an error of `WorldRepair`: what was asked for is gone. With any other one (a journal or shape that cannot be read
/// now, too many open files) it may be made later, and must not be given up.
[[nodiscard]] inline bool is_beyond_repair(const Error& error) {
    return error.code == ErrorCode::NotFound || error.code == ErrorCode::FileFormat;
}

/// Makes pages and strokes again as they were after some edit. Possible while the journal reaches back to the first
/// edit; every member fails, saying so, when it does not. Reads the whole journal at the first call, which takes up to
/// 200 bytes an edit for a moment, and keeps every stamp twice (as one in effect and in its stroke: 128 bytes) until
/// `forget`. Shapes come from the world's folder. Threads: one at a time; the journal may be appended to meanwhile.
class WorldRepair {
public:
    struct Place {
        FileSystem* files = nullptr;
        std::string folder;
        std::uint64_t salt = 0;
        MapGeometry coarse, detail;
        TileGrid tiles;
        std::function<std::uint32_t(Texel)> original;  ///< of the coarse map
    };

    WorldRepair(Place place, Journal& journal) : place_(std::move(place)), journal_(journal) {}

    /// `pages` after edit `edits`, without the stamps of `waiting`, which had not been applied to them.
    Result<std::vector<Page>> pages(std::uint64_t edits, MapKind map, const std::set<PageIndex>& pages,
                                    std::span<const WaitingStamp> waiting);
    /// Pages of a map that some stamp in effect after edit `edits` can have written.
    Result<std::set<PageIndex>> written(std::uint64_t edits, MapKind map);
    /// Numbers that the next record issued must be beyond.
    Result<std::uint64_t> last_sequence(std::uint64_t edits);

    /// What could be undone and redone after edit `edits`, had nothing ever been forgotten: the oldest first, as
    /// `UndoHistory` has it. Without images.
    struct Strokes {
        std::vector<std::vector<StampRecord>> done, undone;
    };
    Result<Strokes> strokes(std::uint64_t edits);
    /// Gives `stroke`, whose records are those of `strokes.done[place]`, images of every page that it wrote: from
    /// before it, hence after the strokes below. Pages of tiles for which all of the stroke still waits are left out.
    Result<void> add_images(const Strokes& strokes, std::size_t place, Stroke& stroke,
                            const std::map<TileIndex, std::vector<WaitingStamp>>& waiting);

    /// Whether a stamp of `stroke` can have written to one of `tiles`.
    Result<bool> reaches(std::uint64_t edits, const Stroke& stroke, const std::set<TileIndex>& tiles);

    void forget() { known_.reset(); }

private:
    struct Known {
        std::uint64_t edits = 0;
        ShapeLibrary shapes;
        std::vector<StampRecord> in_effect;
        Strokes strokes;
        std::uint64_t last_sequence = 0;
    };
    Result<void> know(std::uint64_t edits);
    [[nodiscard]] const MapGeometry& map_of(MapKind map) const {
        return map == MapKind::Coarse ? place_.coarse : place_.detail;
    }
    std::vector<Page> rebuilt(MapKind map, const std::set<PageIndex>& pages, std::span<const StampRecord> stamps) const;

    Place place_;
    Journal& journal_;
    std::optional<Known> known_;
};

}  // namespace tilth
