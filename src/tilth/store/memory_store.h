// A store without a disk: edits live as long as the object.
#pragma once

#include <map>
#include <mutex>

#include "tilth/store/tile_store.h"

namespace tilth {

/// Keeps a copy of every saved tile. Pages that are all zero code are dropped, so an untouched or levelled tile costs
/// an index and no texels. Thread-safe. Memory: 16 KiB a page that is not zero; `bytes` tells.
class MemoryStore final : public TileStore {
public:
    Result<std::vector<TileIndex>> tiles() override;
    Result<std::vector<Page>> load(TileIndex tile, const PageRect& pages) override;
    Result<void> save(TileIndex tile, std::span<const Page> pages) override;

    [[nodiscard]] std::uint64_t bytes() const;

private:
    mutable std::mutex mutex_;
    std::map<TileIndex, std::map<PageIndex, std::shared_ptr<const PageCodes>>> tiles_;
    std::uint64_t pages_ = 0;
};

}  // namespace tilth
