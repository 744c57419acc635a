// Where detail tiles lie when they are not in memory.
#pragma once

#include <span>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/page.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// A host may bring its own. A tile is the unit of saving: it is replaced as a whole, wholly or not at all. Content is
/// the interior of tiles only; aprons are the neighbours' interiors.
/// Threads: `load` and `save` are called on one thread, the disk worker's, one at a time; `tiles` before it starts. A
/// call may take as long as it likes: no frame waits for it. Errors go back to the terrain with their request.
class TileStore {
public:
    TileStore() = default;
    virtual ~TileStore() = default;
    TileStore(const TileStore&) = delete;
    TileStore& operator=(const TileStore&) = delete;

    /// Every tile that was ever saved, also those without a page, in any order.
    virtual Result<std::vector<TileIndex>> tiles() = 0;
    /// The pages of `tile` that lie in `pages`, those that are all zero code (2^31) left out or not. The caller owns
    /// the codes and may change them. A tile that was never saved has no pages and is no error.
    virtual Result<std::vector<Page>> load(TileIndex tile, const PageRect& pages) = 0;
    /// Replaces the content of `tile`: pages that are not named become zero. Must not keep shares of the codes. On an
    /// error the old content stays.
    virtual Result<void> save(TileIndex tile, std::span<const Page> pages) = 0;
};

}  // namespace tilth
