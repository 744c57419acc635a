#include "demo/overlay/paint.h"

#include "tilth/gl/api.h"

namespace tilth::demo {

void paint(gl::Device& device, std::span<const ColouredRect> rects, int height) {
    const gl::Api& api = device.gl();
    api.Enable(GL_SCISSOR_TEST);
    api.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    for (const ColouredRect& painted : rects) {
        const PixelRect& r = painted.rect;
        if (r.x1 <= r.x0 || r.y1 <= r.y0) continue;
        api.Scissor(r.x0, height - r.y1, r.x1 - r.x0, r.y1 - r.y0);  // GL's first row is the bottom one
        api.ClearColor(painted.colour.x, painted.colour.y, painted.colour.z, 1.0f);
        api.Clear(GL_COLOR_BUFFER_BIT);
    }
    api.Disable(GL_SCISSOR_TEST);
}

}  // namespace tilth::demo
