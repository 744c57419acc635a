// The detail map on the CPU: codes in sparse 64 x 64 pages, only where somebody stamped.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "tilth/ground/page.h"
#include "tilth/world/height_codec.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Detail codes of a world, or of the part of it that is in memory. Untouched ground is the code 2^31 and costs
/// nothing.
///
/// Pages can be shared (`share`, `pages_in`), for a save in the background say: a shared page is copied before it is
/// written, so what was handed out never changes. Whoever holds a share gives it back on the thread that writes the
/// field.
class DetailField {
public:
    [[nodiscard]] std::uint32_t code(Texel t) const;
    /// The page for writing, made if it is not there (all codes 2^31).
    PageCodes& touch(PageIndex page);
    /// Nullptr where nothing was ever written.
    [[nodiscard]] const PageCodes* find(PageIndex page) const;
    /// A share of a page; nullptr where nothing was ever written.
    [[nodiscard]] std::shared_ptr<const PageCodes> share(PageIndex page) const;
    /// Takes a page over, in place of what was there.
    void put(Page page);
    void erase(PageIndex page) { pages_.erase(page); }
    [[nodiscard]] const std::map<PageIndex, std::shared_ptr<PageCodes>>& pages() const { return pages_; }

    /// Shares of the pages in `rect`, in the order of (x, z).
    [[nodiscard]] std::vector<Page> pages_in(const PageRect& rect) const;

    /// Copies the codes of `rect` row by row to `out`, rows `stride` codes apart.
    void copy(const TexelRect& rect, std::uint32_t* out, std::size_t stride) const;

private:
    std::map<PageIndex, std::shared_ptr<PageCodes>> pages_;
};

/// Whether every code of the page is 2^31, as on untouched ground.
bool is_untouched(const PageCodes& codes);

}  // namespace tilth
