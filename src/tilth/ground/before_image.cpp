#include "tilth/ground/before_image.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "tilth/ground/code_range.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/stamp_range.h"

namespace tilth {
namespace {

/// The stroke's stamps before `position`, as far as they wrote on `page`: `add`s that did not saturate there, or the
/// stroke would have an image of it. The last first, ready to be taken off.
std::vector<PreparedStamp> negations_on(const GroundEdit& edit, PageIndex page, const MapGeometry& map,
                                        const ShapeLibrary& shapes) {
    std::vector<PreparedStamp> negations;
    const TexelRect whole = texels_of(page);
    for (std::size_t i = edit.position; i-- > 0;) {
        const StampRecord& record = edit.stroke->records[i];
        if (record.map != map.kind || record.rule != StampRule::Add) continue;
        if (intersection(reach_of(record, map, shapes), whole).empty()) continue;
        const PreparedStamp negation = prepare(negated(record), map, shapes);
        if (!intersection(negation.rect(), whole).empty()) negations.push_back(negation);
    }
    return negations;
}

/// Codes of a page without some stamps; `codes` nullptr: there is no page.
std::shared_ptr<const PageCodes> without(std::shared_ptr<const PageCodes> codes, PageIndex page,
                                         const std::vector<PreparedStamp>& negations, const TexelRect& map) {
    if (negations.empty() || codes == nullptr) return codes;
    DetailField alone;
    alone.put({page, std::make_shared<PageCodes>(*codes)});
    for (const PreparedStamp& negation : negations) apply_stamp(negation, alone, intersection(texels_of(page), map));
    return alone.share(page);
}

bool is_wanted(const GroundEdit& edit) { return edit.stroke != nullptr && !edit.stroke->forgotten; }

}  // namespace

bool needs_images(const PreparedStamp& stamp, std::uint32_t min, std::uint32_t max) {
    return stamp.rule() != StampRule::Add || range_after(stamp, min, max).may_saturate;
}

void keep_images(const GroundEdit& edit, const PreparedStamp& stamp, const TexelRect& clip, const DetailField& field,
                 const MapGeometry& map, const ShapeLibrary& shapes) {
    const TexelRect rect = intersection(stamp.rect(), clip);
    if (!is_wanted(edit) || rect.empty()) return;
    Stroke& stroke = *edit.stroke;
    for_each_page(pages_of(rect), [&](PageIndex page) {
        if (stroke.images(map.kind).contains(page)) return;
        const CodeRange codes = range_in(field.find(page), page, intersection(rect, texels_of(page)));
        if (!needs_images(stamp, codes.min, codes.max)) return;
        std::shared_ptr<const PageCodes> image =
            without(field.share(page), page, negations_on(edit, page, map, shapes), map.grid.rect());
        if (image != nullptr && is_untouched(*image)) image = nullptr;
        stroke.keep_image(map.kind, page, image);
    });
}

void keep_images(const GroundEdit& edit, const PreparedStamp& stamp, const HeightField& field, const MapGeometry& map,
                 const ShapeLibrary& shapes) {
    const TexelRect rect = intersection(stamp.rect(), field.rect());
    if (!is_wanted(edit) || rect.empty()) return;
    Stroke& stroke = *edit.stroke;
    for_each_page(pages_of(rect), [&](PageIndex page) {
        if (stroke.images(map.kind).contains(page)) return;
        const CodeRange codes = range_in(field, intersection(rect, texels_of(page)));
        if (!needs_images(stamp, codes.min, codes.max)) return;
        stroke.keep_image(map.kind, page,
                          without(std::make_shared<PageCodes>(page_of_field(field, page)), page,
                                  negations_on(edit, page, map, shapes), field.rect()));
    });
}

PageCodes page_of_field(const HeightField& field, PageIndex page) {
    PageCodes codes;
    codes.fill(kMidCode);
    const TexelRect whole = texels_of(page), part = intersection(whole, field.rect());
    for (std::int32_t z = part.min.z; z < part.max.z; ++z)
        std::copy_n(field.row(z) + part.min.x, part.width(),
                    codes.data() + (z - whole.min.z) * kPageTexels + (part.min.x - whole.min.x));
    return codes;
}

void put_page(HeightField& field, PageIndex page, const PageCodes& codes) {
    const TexelRect whole = texels_of(page), part = intersection(whole, field.rect());
    for (std::int32_t z = part.min.z; z < part.max.z; ++z)
        std::copy_n(codes.data() + (z - whole.min.z) * kPageTexels + (part.min.x - whole.min.x), part.width(),
                    field.row(z) + part.min.x);
}

void put_image(DetailField& field, PageIndex page, const std::shared_ptr<const PageCodes>& image) {
    if (image == nullptr)
        field.erase(page);
    else
        field.put({page, std::make_shared<PageCodes>(*image)});
}

TexelRect reach_of(const StampRecord& record, const MapGeometry& map, const ShapeLibrary& shapes) {
    // Doubles, rounded outwards: a turned image covers sqrt(2) radii, sub-texels and rounded steps up to two texels.
    const double radius = std::max(record.radius / 262144.0, shapes.shape({record.shape}).least_radius_texels);
    const double reach = 1.5 * radius + 4;
    const auto side = [&](std::int64_t centre, double origin, std::int32_t count, std::int32_t& min,
                          std::int32_t& max) {
        const double at = (static_cast<double>(centre) / 16777216.0 - origin) / map.grid.spacing_m;
        min = static_cast<std::int32_t>(std::clamp(std::floor(at - reach), 0.0, static_cast<double>(count)));
        max = static_cast<std::int32_t>(std::clamp(std::ceil(at + reach), 0.0, static_cast<double>(count)));
    };
    TexelRect rect;
    side(record.centre_x, map.grid.origin.x, map.grid.width, rect.min.x, rect.max.x);
    side(record.centre_z, map.grid.origin.z, map.grid.depth, rect.min.z, rect.max.z);
    return rect;
}

}  // namespace tilth
