// Texel rectangles of a map as pixel rectangles of its textures.
#pragma once

#include "tilth/gl/objects.h"
#include "tilth/world/texel.h"

namespace tilth {

/// The texture's row is the map's z.
constexpr gl::Rect gl_rect(const TexelRect& r) { return {r.min.x, r.min.z, r.max.x, r.max.z}; }

/// The same in a texture whose texel (0, 0) is the map's texel `origin`.
constexpr gl::Rect gl_rect(const TexelRect& r, Texel origin) {
    return {r.min.x - origin.x, r.min.z - origin.z, r.max.x - origin.x, r.max.z - origin.z};
}

}  // namespace tilth
