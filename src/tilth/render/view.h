// What a frame is seen with: camera, viewport, light and look. Plain data, no GL.
#pragma once

#include <cstdint>
#include <optional>

#include "tilth/core/vec.h"
#include "tilth/world/grid.h"

namespace tilth {

/// How depth is written.
enum class DepthConvention : std::uint8_t {
    Standard,  ///< 0 near, 1 far, glDepthFunc(GL_LESS)
    Reversed,  ///< 1 near, 0 far (infinite far plane allowed), GL_GREATER; needs ARB_clip_control for its precision
};

/// A perspective camera and its viewport. Directions need not be normalised.
struct View {
    Vec3d eye;                              ///< metres, world space
    Vec3d forward{0, 0, -1};                ///< view direction, not zero
    Vec3d up{0, 1, 0};                      ///< if parallel to `forward`, another axis is taken
    double fov_y_rad = 1.0471975511965976;  ///< vertical field of view, clamped to [0.001, 3.1]
    std::int32_t width = 0, height = 0;     ///< viewport in pixels, to be set; 0 x 0 draws nothing
    double near_m = 0.1;                    ///< > 0
    double far_m = 20000;                   ///< > near
    DepthConvention depth = DepthConvention::Standard;
};

/// The direction from one point to another, for `View::forward`; not normalised.
constexpr Vec3d towards(const Vec3d& from, const Vec3d& to) { return {to.x - from.x, to.y - from.y, to.z - from.z}; }

/// Light, fog and tint. Colours are linear RGB.
struct Shading {
    Vec3f to_light{0.5f, 0.62f, 0.6f};  ///< direction towards the light, normalised when used
    float ambient = 0.42f, diffuse = 0.82f, specular = 0.05f;
    float specular_exponent = 24.0f;
    Vec3f fog_colour{0.6f, 0.6f, 0.6f};        ///< usually the clear colour
    double fog_density = 0.0;                  ///< per metre; exp(-(density d)^2)
    Vec3f low_colour{0.36f, 0.46f, 0.22f};     ///< flat ground at the bottom of `tint_range`
    Vec3f high_colour{0.72f, 0.68f, 0.60f};    ///< flat ground at its top
    Vec3f steep_colour{0.53f, 0.48f, 0.42f};   ///< ground steeper than about 45 degrees
    double tint_low_m = 0, tint_high_m = 100;  ///< heights between which low turns to high, metres; at least 1 m apart
};

/// The brush cursor: a ring draped on the ground.
struct BrushCursor {
    WorldPos centre;
    double radius_m = 1.0;
    Vec3f colour{1.0f, 0.85f, 0.1f};
};

/// The geometry clipmap: levels of n x n vertices, nested round the viewer, spacing doubling outwards.
struct ClipmapSettings {
    std::int32_t n = 255;  ///< vertices a side, 2^k - 1, 15..1023; triangles grow as n^2, error falls as n^-1.1..-1.8
    std::int32_t levels = 5;  ///< 1..16; level l has spacing 2^l posts
    double blend = 0.1;  ///< share of n over which a level morphs into the next coarser, 0.02..0.25; see check_clipmap
    /// Ground whose next finer level would move a vertex by more than this on the screen is drawn one level finer, four
    /// times the triangles there; 0..1e6 pixels, 0 refines all levels but the finest, 1e6 none. Smooth ground costs
    /// nothing.
    double refine_above_px = 1.0;
};

}  // namespace tilth
