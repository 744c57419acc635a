// Sets of pages as few rectangles. Pure.
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "tilth/ground/page.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Adds the pages that meet `rect`.
void add_pages(std::set<PageIndex>& pages, const TexelRect& rect);

/// Disjoint rectangles that cover the pages of the set, clipped to `clip`: runs along z, joined along x where they
/// agree.
std::vector<TexelRect> rects_of(const std::set<PageIndex>& pages, const TexelRect& clip);

/// Takes a run of neighbouring pages along z off the set, at most `most` of them, and gives its rectangle clipped to
/// `clip`; empty where that leaves nothing. The set is not empty.
TexelRect take_run(std::set<PageIndex>& pages, std::int32_t most, const TexelRect& clip);

}  // namespace tilth
