#include "tilth/gl/quirks.h"

namespace tilth::gl {

Quirks quirks_of(std::string_view vendor, std::string_view renderer) {
    const auto renderer_has = [&](std::string_view part) { return renderer.find(part) != std::string_view::npos; };
    Quirks quirks;

    // Mesa's llvmpipe, softpipe and swr; SwiftShader; Microsoft's and Apple's software renderers.
    quirks.software_rasterizer = renderer_has("llvmpipe") || renderer_has("softpipe") || renderer_has("SWR") ||
                                 renderer_has("SwiftShader") || renderer_has("GDI Generic") ||
                                 renderer_has("Apple Software Renderer") ||
                                 (vendor == "Mesa" && renderer_has("Software Rasterizer"));

    // llvmpipe (Mesa 22.3.6, measured): a draw of 43 to 94 ms reports 0.18 to 36.7 ms, vertex and compute work
    // 0.000 ms, because the query is answered on the thread that bins, not on those that rasterise. The others share
    // that design.
    quirks.timer_queries_lie = quirks.software_rasterizer;

    // llvmpipe (measured): with draws in flight, glReadPixels into a pixel buffer blocks until all are done (153 to
    // 374 ms of heavy draws); a later map is then free.
    quirks.readback_waits = quirks.software_rasterizer;

    // llvmpipe (measured): glTexSubImage2D to a texture that draws in flight sample blocks for the rest of the frame,
    // even for 256 KiB; to another texture it returns at once.
    quirks.upload_to_texture_in_use_waits = quirks.software_rasterizer;

    // llvmpipe (Mesa 22.3.6, measured): glClear of a 2 052 x 2 052 R16 target takes about 5 ms of CPU time, uploading
    // as many constant texels about 1 ms. And a texture that was cleared or drawn to seems to count as written to for
    // frames: each later pass over it then flushes first (a stamp on a four-tile corner cost 1.7 to 2.9 times the one
    // at a tile's centre with clears, 1.3 with uploads).
    quirks.uploads_beat_clears = quirks.software_rasterizer;

    // llvmpipe (Mesa 22.3.6, measured): a tessellated patch on the screen costs the more the more patches its draw has
    // (level 32: ten times, between one draw and a draw a patch), and a draw with more than 65 536 vertices after
    // tessellation comes out as other triangles.
    quirks.patch_draws_must_be_small = quirks.software_rasterizer;
    return quirks;
}

}  // namespace tilth::gl
