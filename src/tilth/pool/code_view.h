// A rectangle of height codes in memory, whoever owns them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tilth/ground/detail_field.h"
#include "tilth/ground/height_field.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Codes of the texels of `rect`, row by row, rows `stride` codes apart. Does not own them: valid while the field or
/// buffer behind it is. Rectangles and texels are those of the whole map.
struct CodeView {
    const std::uint32_t* codes = nullptr;  ///< of `rect.min`
    std::size_t stride = 0;
    TexelRect rect;

    CodeView() = default;
    CodeView(const std::uint32_t* first, std::size_t row_codes, const TexelRect& covered)
        : codes(first), stride(row_codes), rect(covered) {}
    /// A whole dense map; implicit, so that a field can be passed where codes are read.
    CodeView(const HeightField& field)
        : codes(field.codes().data()), stride(static_cast<std::size_t>(field.width())), rect(field.rect()) {}

    /// The code of `t`, which lies in `rect`, and those behind it in its row.
    [[nodiscard]] const std::uint32_t* at(Texel t) const {
        return codes + static_cast<std::size_t>(t.z - rect.min.z) * stride + static_cast<std::size_t>(t.x - rect.min.x);
    }
    [[nodiscard]] std::uint32_t code(Texel t) const { return *at(t); }
};

/// A window of a sparse field as dense codes; its memory is used again by the next one.
class GatheredCodes {
public:
    /// Valid until the next call.
    CodeView gather(const DetailField& field, const TexelRect& rect);

private:
    std::vector<std::uint32_t> codes_;
};

/// Writes codes into a sparse field. A page that is not there and would hold untouched ground alone is not made.
void scatter(const CodeView& codes, DetailField& field);

}  // namespace tilth
