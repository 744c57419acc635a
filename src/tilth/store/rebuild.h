// Pages from nothing but the original ground and the journal: for those that the disk lost.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <vector>

#include "tilth/ground/edit.h"
#include "tilth/ground/map_geometry.h"
#include "tilth/ground/page.h"
#include "tilth/ground/shape_library.h"
#include "tilth/world/texel.h"

namespace tilth {

/// The stamps that are in the ground after `edits`, in order: undone strokes are left out. `edits` are all of a
/// world's, from the first.
std::vector<StampRecord> stamps_in_effect(std::span<const Edit> edits);

/// Codes of `pages` of one map after `stamps` (those of other maps are ignored), in the order of `pages`. `original`:
/// the code of any texel of the map before any stamp; texels of a page outside the map are the mid code.
///
/// What `smooth` reads beyond the pages is computed too, as long as it is needed: one page more on each side, going
/// back from one smooth stamp to the one before. Cost: a look at each stamp, and applying those that reach the pages.
/// Threads: any, as long as nobody adds shapes.
std::vector<Page> rebuild_pages(const std::set<PageIndex>& pages, std::span<const StampRecord> stamps,
                                const MapGeometry& map, const ShapeLibrary& shapes,
                                const std::function<std::uint32_t(Texel)>& original);

}  // namespace tilth
