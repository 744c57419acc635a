#include "tilth/ground/detail_field.h"

#include <algorithm>
#include <utility>

namespace tilth {
namespace {

std::size_t within_page(Texel t) {
    return static_cast<std::size_t>((t.z & (kPageTexels - 1)) * kPageTexels + (t.x & (kPageTexels - 1)));
}

}  // namespace

std::uint32_t DetailField::code(Texel t) const {
    const PageCodes* page = find(page_of(t));
    return page == nullptr ? kMidCode : (*page)[within_page(t)];
}

PageCodes& DetailField::touch(PageIndex page) {
    std::shared_ptr<PageCodes>& codes = pages_[page];
    if (codes == nullptr) {
        codes = std::make_shared<PageCodes>();
        codes->fill(kMidCode);
    } else if (codes.use_count() > 1) {
        codes = std::make_shared<PageCodes>(*codes);
    }
    return *codes;
}

const PageCodes* DetailField::find(PageIndex page) const {
    const auto found = pages_.find(page);
    return found == pages_.end() ? nullptr : found->second.get();
}

std::shared_ptr<const PageCodes> DetailField::share(PageIndex page) const {
    const auto found = pages_.find(page);
    return found == pages_.end() ? nullptr : found->second;
}

void DetailField::put(Page page) { pages_[page.index] = std::move(page.codes); }

std::vector<Page> DetailField::pages_in(const PageRect& rect) const {
    std::vector<Page> found;
    for (std::int32_t x = rect.min.x; x < rect.max.x; ++x)
        for (auto page = pages_.lower_bound({x, rect.min.z}); page != pages_.end(); ++page) {
            if (page->first.x != x || page->first.z >= rect.max.z) break;
            found.push_back({page->first, page->second});
        }
    return found;
}

void DetailField::copy(const TexelRect& rect, std::uint32_t* out, std::size_t stride) const {
    for_each_page(pages_of(rect), [&](PageIndex at) {
        const TexelRect part = intersection(rect, texels_of(at));
        const PageCodes* page = find(at);
        for (std::int32_t z = part.min.z; z < part.max.z; ++z) {
            std::uint32_t* to = out + static_cast<std::size_t>(z - rect.min.z) * stride +
                                static_cast<std::size_t>(part.min.x - rect.min.x);
            if (page == nullptr)
                std::fill_n(to, part.width(), kMidCode);
            else
                std::copy_n(page->data() + within_page({part.min.x, z}), part.width(), to);
        }
    });
}

bool is_untouched(const PageCodes& codes) {
    return std::all_of(codes.begin(), codes.end(), [](std::uint32_t code) { return code == kMidCode; });
}

}  // namespace tilth
