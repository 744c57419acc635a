// Plain vectors for public headers. No operators beyond what the library needs; the renderer uses GLM inside.
#pragma once

namespace tilth {

/// A point or direction, metres or unit-less as the user says; +y up, the ground plane is (x, z).
struct Vec3d {
    double x = 0, y = 0, z = 0;
    friend bool operator==(const Vec3d&, const Vec3d&) = default;
};

/// A colour (linear RGB) or a small direction.
struct Vec3f {
    float x = 0, y = 0, z = 0;
    friend bool operator==(const Vec3f&, const Vec3f&) = default;
};

}  // namespace tilth
