// Paints coloured rectangles into the bound framebuffer, by clears within scissors: no shader, no buffer.
#pragma once

#include <span>

#include "demo/overlay/residency_map.h"
#include "tilth/gl/device.h"

namespace tilth::demo {

/// `rects` lie in a picture of `height` rows that starts at the framebuffer's origin; parts outside are cut off. Leaves
/// the scissor test off and the clear colour changed. Thread: the one that owns the context.
void paint(gl::Device& device, std::span<const ColouredRect> rects, int height);

}  // namespace tilth::demo
