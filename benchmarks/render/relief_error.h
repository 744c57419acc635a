// How far what a backend shows is from the brute-force mesh of every texel (tests/render/support/shown_ground.h).
#pragma once

#include "render/relief_scene.h"
#include "tilth/render/detail_settings.h"

namespace tilth::bench {

struct ReliefError {
    double rms_px = 0, p99_px = 0, wrong_percent = 0;  ///< where relief stands in full, a quarter before its reach
};

/// At three places of the walk, 1 600 x 900; on a cut-out of the reference's ground with the same stamps. In a context
/// of the tests' own; the benchmarks' is current again afterwards. Traced relief writes its depth for this.
ReliefError relief_error(const DetailSettings& settings, Dents dents);

}  // namespace tilth::bench
