#include "tilth/ground/code_range.h"

namespace tilth {

CodeRange range_in(const PageCodes* codes, PageIndex page, const TexelRect& part) {
    if (codes == nullptr) return {kMidCode, kMidCode};
    const Texel corner = texels_of(page).min;
    CodeRange range;
    for (std::int32_t z = part.min.z; z < part.max.z; ++z)
        range.include(codes->data() + (z - corner.z) * kPageTexels + (part.min.x - corner.x), part.width());
    return range;
}

CodeRange range_in(const HeightField& field, const TexelRect& rect) {
    CodeRange range;
    for (std::int32_t z = rect.min.z; z < rect.max.z; ++z) range.include(field.row(z) + rect.min.x, rect.width());
    return range;
}

CodeRange range_in(const DetailField& field, const TexelRect& rect) {
    CodeRange range;
    for_each_page(pages_of(rect), [&](PageIndex page) {
        range.include(range_in(field.find(page), page, intersection(rect, texels_of(page))));
    });
    return range;
}

}  // namespace tilth
