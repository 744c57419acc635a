// Boot prints of somebody who walks where he likes: left and right in turn, one every stride. Pure; no window, no GL.
#pragma once

#include <optional>
#include <vector>

#include "demo/window/path_brush.h"
#include "tilth/ground/stamp.h"

namespace tilth::demo {

/// A person's boots. Lengths in metres.
struct BootSize {
    double radius_m = 0.17, depth_m = 0.03, stride_m = 0.75, side_m = 0.15;
    double eye_m = 2;  ///< of the walker, above the ground
};

/// On ground whose texels are wider than 1/30 m everything but the walker's eye is as much larger, so that a print is
/// ten texels long everywhere.
BootSize boots_for(double texel_m);

/// Which way a walker's prints lie follows from where he went, not from where he looks.
class FootSteps {
public:
    /// The walker is at `at` now. Returns the prints that are due, on the detail map: each `stride_m` after the one
    /// before, `side_m` left and right of the way in turn, the image mirrored for left feet (it shows a right boot).
    /// The first is due with the first move. A jump, a teleport say, leaves none on its way.
    std::vector<StampRequest> step(WorldPos at, const BootSize& boots, ShapeId boot);
    void stop();

private:
    PathBrush path_;
    std::optional<WorldPos> from_;  ///< of the last step
    bool right_ = false;            ///< the next foot
};

}  // namespace tilth::demo
