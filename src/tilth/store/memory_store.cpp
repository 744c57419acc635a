#include "tilth/store/memory_store.h"

#include <utility>

#include "tilth/ground/detail_field.h"

namespace tilth {

Result<std::vector<TileIndex>> MemoryStore::tiles() {
    const std::lock_guard lock(mutex_);
    std::vector<TileIndex> found;
    found.reserve(tiles_.size());
    for (const auto& [tile, pages] : tiles_) found.push_back(tile);
    return found;
}

Result<std::vector<Page>> MemoryStore::load(TileIndex tile, const PageRect& pages) {
    std::vector<std::pair<PageIndex, std::shared_ptr<const PageCodes>>> held;
    {
        const std::lock_guard lock(mutex_);
        if (const auto found = tiles_.find(tile); found != tiles_.end())
            for (const auto& page : found->second)
                if (pages.contains(page.first)) held.push_back(page);
    }
    std::vector<Page> copies;
    for (const auto& [index, codes] : held) copies.push_back({index, std::make_shared<PageCodes>(*codes)});
    return copies;
}

Result<void> MemoryStore::save(TileIndex tile, std::span<const Page> pages) {
    // Copied before the lock: a reader on another thread waits for the exchange alone.
    std::map<PageIndex, std::shared_ptr<const PageCodes>> copies;
    for (const Page& page : pages)
        if (page.codes != nullptr && !is_untouched(*page.codes))
            copies[page.index] = std::make_shared<const PageCodes>(*page.codes);

    const std::lock_guard lock(mutex_);
    std::map<PageIndex, std::shared_ptr<const PageCodes>>& held = tiles_[tile];
    pages_ = pages_ - held.size() + copies.size();
    std::swap(held, copies);
    return {};
}

std::uint64_t MemoryStore::bytes() const {
    const std::lock_guard lock(mutex_);
    return pages_ * sizeof(PageCodes);
}

}  // namespace tilth
