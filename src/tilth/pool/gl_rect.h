// Texel rectangles of a map as pixel rectangles of its textures.
#pragma once

#include "tilth/gl/objects.h"
#include "tilth/world/texel.h"

namespace tilth {

/// The texture's row is the map's z.
constexpr gl::Rect gl_rect(const TexelRect& r) { return {r.min.x, r.min.z, r.max.x, r.max.z}; }

}  // namespace tilth
