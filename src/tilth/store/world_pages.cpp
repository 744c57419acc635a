#include "tilth/store/world_pages.h"

#include <memory>
#include <utility>

#include "tilth/ground/detail_field.h"
#include "tilth/store/page_codec.h"
#include "tilth/store/world_blobs.h"

namespace tilth {

WorldPages::WorldPages(BlobStore& blobs, std::string name, std::int32_t tile_size, const MapGeometry& coarse,
                       std::function<std::uint32_t(Texel)> original)
    : blobs_(blobs),
      name_(std::move(name)),
      pages_a_tile_(tile_size / kPageTexels),
      coarse_map_(coarse),
      original_(std::move(original)) {}

Result<void> WorldPages::read_keys() {
    for (const MapKind map : {MapKind::Coarse, MapKind::Detail}) {
        const auto keys = blobs_.keys(key_of_page(map, {}).kind);
        if (!keys) return keys.error();
        for (const BlobKey& key : *keys) {
            const PageIndex page{key.x, key.z};
            hashes(map, page)[page] = std::nullopt;
        }
    }
    return {};
}

std::vector<TileIndex> WorldPages::tiles() const {
    std::vector<TileIndex> found;
    for (const auto& [tile, pages] : detail_)
        if (!pages.empty()) found.push_back(tile);
    return found;
}

bool WorldPages::has(MapKind map, PageIndex page) const {
    if (map == MapKind::Coarse) return coarse_.contains(page);
    const auto tile = detail_.find(tile_of(page));
    return tile != detail_.end() && tile->second.contains(page);
}

std::vector<PageIndex> WorldPages::keys(MapKind map) const {
    std::vector<PageIndex> found;
    const auto add = [&](const Hashes& pages) {
        for (const auto& [page, hash] : pages) found.push_back(page);
    };
    if (map == MapKind::Coarse)
        add(coarse_);
    else
        for (const auto& [tile, pages] : detail_) add(pages);
    return found;
}

std::vector<PageIndex> WorldPages::keys(TileIndex tile) const {
    std::vector<PageIndex> found;
    if (const auto pages = detail_.find(tile); pages != detail_.end())
        for (const auto& [page, hash] : pages->second) found.push_back(page);
    return found;
}

// ---------------------------------------------------------------------------------------------------- reading

Result<Page> WorldPages::read(MapKind map, PageIndex page) {
    const std::string where =
        text(name_, ": ", map == MapKind::Coarse ? "coarse" : "detail", " page (", page.x, ", ", page.z, ")");
    const auto blob = get_blob(blobs_, key_of_page(map, page));
    if (!blob) return blob.error();
    if (!*blob) return Error{ErrorCode::FileFormat, text(where, ": is gone from the store")};
    auto codes = decode_page(**blob, where);
    if (!codes) return codes.error();
    return Page{page, std::move(*codes)};
}

Result<WorldPages::Found> WorldPages::load(MapKind map, Hashes& known, const PageRect* pages) {
    Found found;
    const std::set<PageIndex>& doubtful = pending(map).doubtful;
    for (auto& [index, hash] : known) {
        if (pages != nullptr && !pages->contains(index)) continue;
        auto page = read(map, index);
        if (page) {
            if (!doubtful.contains(index)) hash = hash_of(*page->codes);
            found.pages.push_back(std::move(*page));
        } else {
            if (!is_damage(page.error())) return page.error();
            hash.reset();
            found.damaged.emplace(index, page.error());
        }
    }
    return found;
}

Result<WorldPages::Found> WorldPages::load(TileIndex tile, const PageRect& pages) {
    const auto hashes = detail_.find(tile);
    return hashes == detail_.end() ? Found{} : load(MapKind::Detail, hashes->second, &pages);
}

Result<WorldPages::Found> WorldPages::load_coarse() { return load(MapKind::Coarse, coarse_, nullptr); }

// ---------------------------------------------------------------------------------------------------- writing

Result<void> WorldPages::put(MapKind map, const Page& page, std::uint64_t hash) {
    Hashes& known = hashes(map, page.index);
    // While it is not known whether the store has taken the new one, it must not count as the old one.
    if (const auto found = known.find(page.index); found != known.end()) found->second.reset();
    const Result<void> put = blobs_.put(key_of_page(map, page.index), encode_page(*page.codes, coarse_map_.precision));
    if (!put) return put;
    known[page.index] = hash;
    pending(map).put.insert(page.index);
    pending(map).doubtful.erase(page.index);
    return {};
}

Result<void> WorldPages::erase(MapKind map, PageIndex page) {
    if (!has(map, page)) return {};
    if (const Result<void> erased = blobs_.erase(key_of_page(map, page)); !erased) return erased;
    hashes(map, page).erase(page);
    return {};
}

Result<void> WorldPages::replace(MapKind map, const Page& page) {
    if (map == MapKind::Coarse) {
        coarse_[page.index].reset();
        return save_coarse(page);
    }
    return is_untouched(*page.codes) ? erase(map, page.index) : put(map, page, hash_of(*page.codes));
}

Result<void> WorldPages::save(TileIndex tile, std::span<const Page> pages) {
    torn_.insert(tile);
    Hashes& known = detail_[tile];
    std::set<PageIndex> named;
    for (const Page& page : pages) {
        TILTH_EXPECTS(tile_of(page.index) == tile, "a page of another tile");
        if (page.codes == nullptr || is_untouched(*page.codes)) continue;
        named.insert(page.index);
        const std::uint64_t hash = hash_of(*page.codes);
        const auto stored = known.find(page.index);
        if (stored != known.end() && stored->second == hash) continue;
        if (const Result<void> written = put(MapKind::Detail, page, hash); !written) return written;
    }
    for (const PageIndex page : keys(tile))
        if (!named.contains(page))
            if (const Result<void> erased = erase(MapKind::Detail, page); !erased) return erased;
    torn_.erase(tile);
    return {};
}

void WorldPages::commit_failed() {
    for (const MapKind map : {MapKind::Coarse, MapKind::Detail}) {
        Pending& of_map = pending(map);
        of_map.doubtful = of_map.put;
        for (const PageIndex page : of_map.put)
            if (has(map, page)) hashes(map, page)[page].reset();
    }
}

std::optional<TileIndex> WorldPages::torn() const {
    return torn_.empty() ? std::nullopt : std::optional(*torn_.begin());
}

PageCodes WorldPages::original_page(PageIndex page) const {
    PageCodes codes;
    codes.fill(kMidCode);
    const TexelRect whole = texels_of(page), part = intersection(whole, coarse_map_.grid.rect());
    for (std::int32_t z = part.min.z; z < part.max.z; ++z)
        for (std::int32_t x = part.min.x; x < part.max.x; ++x)
            codes[static_cast<std::size_t>((z - whole.min.z) * kPageTexels + (x - whole.min.x))] = original_({x, z});
    return codes;
}

Result<void> WorldPages::save_coarse(const Page& page) {
    const std::uint64_t hash = hash_of(*page.codes);
    if (const auto stored = coarse_.find(page.index); stored != coarse_.end() && stored->second == hash) return {};
    if (*page.codes == original_page(page.index)) return erase(MapKind::Coarse, page.index);
    return put(MapKind::Coarse, page, hash);
}

}  // namespace tilth
