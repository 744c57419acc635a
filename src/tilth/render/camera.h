// A view, checked and turned into what a draw needs: matrices, planes, and a base post near the eye. Pure, no GL.
#pragma once

#include <array>
#include <cstdint>

#include "tilth/core/result.h"
#include "tilth/core/vec.h"
#include "tilth/render/view.h"
#include "tilth/world/grid.h"
#include "tilth/world/height_codec.h"

namespace tilth {

/// A camera relative to a map. Everything that becomes a float is small near the eye: positions are integers from a
/// base post, heights integers from a code near the eye, and only the rest is a fraction. The eye is first snapped to
/// 2^-20 m (a micrometre) from the map's origin, so that a world at 1e7 m gives the same bits as one at 0.
struct Camera {
    bool draws = false;                   ///< false: no pixels, or the eye is out of all reach; nothing else is set
    Vec3d forward, right, up;             ///< orthonormal
    double eye_x_m = 0, eye_z_m = 0;      ///< from the map's origin
    double eye_y_m = 0;                   ///< from the codec's middle height
    PostPos eye_posts;                    ///< on the map's grid
    std::int32_t base_x = 0, base_z = 0;  ///< the post at or before the eye, may lie outside the map
    float fraction_x_m = 0, fraction_z_m = 0;  ///< from the base post to the eye, 0 to below one spacing
    std::uint32_t eye_code = 0;                ///< the code at or under the eye, or the end of the range next to it
    float eye_above_code_m = 0;
    double pixels_per_radian = 0;                   ///< in the middle of the picture: height / (2 tan(fov / 2))
    std::array<float, 16> clip_from_relative{};     ///< column-major; takes metres from the eye
    std::array<std::array<double, 4>, 6> planes{};  ///< inside: a x + b y + c z + d >= 0, metres from the eye
};

/// Fails with InvalidArgument naming the field: NaN or infinity (only `far_m` may be infinite), a zero direction, near
/// <= 0, far <= near, a negative viewport. The field of view is clamped to [0.001, 3.1].
Result<Camera> make_camera(const View& view, const GridSpec& grid, const HeightCodec& codec);

/// A box in metres from the eye.
struct RelativeBox {
    Vec3d min, max;
};

/// True only if no point of the box can be on the screen. Conservative: a box near a corner of the frustum may pass,
/// and a relative margin of 1e-5 covers the floats of the vertex shader.
bool is_culled(const RelativeBox& box, const Camera& camera);

}  // namespace tilth
