// Drivers that need care: named booleans, set in one pure function.
#pragma once

#include <string_view>

namespace tilth::gl {

/// What is known to be wrong or slow with the current driver. Each one is explained where it is set, in quirks.cpp.
struct Quirks {
    bool software_rasterizer = false;             ///< draws run on the CPU: prefer CPU executors, GPU time is CPU time
    bool timer_queries_lie = false;               ///< GL_TIME_ELAPSED and GL_TIMESTAMP do not measure draws
    bool readback_waits = false;                  ///< glReadPixels into a buffer waits for all draws before it
    bool uploads_beat_clears = false;             ///< a whole texture is filled faster by uploads than by glClear
    bool patch_draws_must_be_small = false;       ///< tessellation slows down, and breaks, with the patches of a draw
    bool upload_to_texture_in_use_waits = false;  ///< so upload before the first draw of a frame

    friend bool operator==(const Quirks&, const Quirks&) = default;
};

/// The only place that sets quirks. `vendor` and `renderer` are GL_VENDOR and GL_RENDERER.
Quirks quirks_of(std::string_view vendor, std::string_view renderer);

}  // namespace tilth::gl
