// Keeping what undo will put back.
#pragma once

#include <cstddef>

#include "tilth/ground/detail_field.h"
#include "tilth/ground/height_field.h"
#include "tilth/ground/map_geometry.h"
#include "tilth/ground/prepared_stamp.h"
#include "tilth/ground/shape_library.h"
#include "tilth/ground/undo_history.h"

namespace tilth {

/// Whether undoing the stamp takes the codes from before it: any rule but `add`, and an `add` that may leave the range
/// somewhere between codes `min` and `max`.
bool needs_images(const PreparedStamp& stamp, std::uint32_t min, std::uint32_t max);

/// Before a stamp of a stroke is applied to `clip` of the detail map: keeps the pages there that its undo will need,
/// and that the stroke does not have. Earlier stamps of the stroke are taken off the page first. `clip` may be any part
/// of the map that no page straddles; each page sees all stamps of its stroke, in order. Costs a share of each page
/// (which is then copied when it is written), and a look at the codes for `add`.
void keep_images(const GroundEdit& edit, const PreparedStamp& stamp, const TexelRect& clip, const DetailField& field,
                 const MapGeometry& map, const ShapeLibrary& shapes);
/// The same before a stamp on the coarse map: copies of the pages.
void keep_images(const GroundEdit& edit, const PreparedStamp& stamp, const HeightField& field, const MapGeometry& map,
                 const ShapeLibrary& shapes);

/// Copies a page of a dense map; texels outside it are the mid code.
PageCodes page_of_field(const HeightField& field, PageIndex page);
/// Writes a page into a dense map, as far as it lies inside.
void put_page(HeightField& field, PageIndex page, const PageCodes& codes);
/// Puts an image back: copied, so that the stroke keeps its own for another undo; nullptr takes the page away.
void put_image(DetailField& field, PageIndex page, const std::shared_ptr<const PageCodes>& image);

/// Texels of the map beyond which `record` surely changes nothing; a few more than `prepare` finds, for a small part of
/// its cost.
TexelRect reach_of(const StampRecord& record, const MapGeometry& map, const ShapeLibrary& shapes);

}  // namespace tilth
