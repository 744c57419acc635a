#include "tilth/pool/code_view.h"

#include <algorithm>

namespace tilth {

CodeView GatheredCodes::gather(const DetailField& field, const TexelRect& rect) {
    if (rect.empty()) return {};
    const auto stride = static_cast<std::size_t>(rect.width());
    codes_.resize(static_cast<std::size_t>(rect.count()));
    field.copy(rect, codes_.data(), stride);
    return {codes_.data(), stride, rect};
}

void scatter(const CodeView& codes, DetailField& field) {
    for_each_page(pages_of(codes.rect), [&](PageIndex at) {
        const TexelRect whole = texels_of(at), part = intersection(codes.rect, whole);
        const auto untouched = [&](std::int32_t z) {
            const std::uint32_t* row = codes.at({part.min.x, z});
            return std::all_of(row, row + part.width(), [](std::uint32_t code) { return code == kMidCode; });
        };
        if (field.find(at) == nullptr) {
            std::int32_t z = part.min.z;
            while (z < part.max.z && untouched(z)) ++z;
            if (z == part.max.z) return;
        }
        PageCodes& page = field.touch(at);
        for (std::int32_t z = part.min.z; z < part.max.z; ++z)
            std::copy_n(codes.at({part.min.x, z}), part.width(),
                        page.data() + (z - whole.min.z) * kPageTexels + (part.min.x - whole.min.x));
    });
}

}  // namespace tilth
