#include "tilth/ground/detail_field.h"

namespace tilth {

std::uint32_t DetailField::code(Texel t) const {
    const PageCodes* page = find(page_of(t));
    if (page == nullptr) return kMidCode;
    return (*page)[static_cast<std::size_t>((t.z & (kPageTexels - 1)) * kPageTexels + (t.x & (kPageTexels - 1)))];
}

PageCodes& DetailField::touch(PageIndex page) {
    std::unique_ptr<PageCodes>& codes = pages_[page];
    if (codes == nullptr) {
        codes = std::make_unique<PageCodes>();
        codes->fill(kMidCode);
    }
    return *codes;
}

const PageCodes* DetailField::find(PageIndex page) const {
    const auto found = pages_.find(page);
    return found == pages_.end() ? nullptr : found->second.get();
}

}  // namespace tilth
