// The shapes that stamps can have: radial profiles and 16-bit images, by name and number.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/stamp.h"

namespace tilth {

/// Entries of a profile table: weights at t = distance / radius = i / 1024, i = 0..1024.
inline constexpr int kProfileEntries = 1025;

/// The weight of one, in tables and after sampling. Weights lie in -kWeightOne..kWeightOne.
inline constexpr std::int32_t kWeightOne = 65536;

/// The built-in profiles; their `ShapeId` is their number here. Weight w at t = distance / radius, zero from t = 1 on.
enum class BuiltinProfile : std::uint32_t {
    Gaussian,    ///< (exp(-6 t^2) - exp(-6)) / (1 - exp(-6))
    Cone,        ///< 1 - t
    Paraboloid,  ///< 1 - t^2
    Cosine,      ///< (1 + cos(pi t)) / 2
    Crater,      ///< (1 - t^2)^2 (1 - 4 t^2): a bowl with a rim, no net volume
    Disc,        ///< 1
};
inline constexpr std::uint32_t kBuiltinProfiles = 6;

/// One shape. A profile has `kProfileEntries` weights; an image `width * height`, row by row.
struct Shape {
    std::string name;
    bool is_image = false;
    std::int32_t width = 0, height = 0;                  ///< of an image, texels
    std::vector<std::int32_t> weights;                   ///< in 1 / 65 536, 65 536 = full weight
    std::int32_t lowest_weight = 0, highest_weight = 0;  ///< of `weights`
    double least_radius_texels = 0;                      ///< smaller stamps are widened to this, with their volume kept
    bool zero_volume = false;  ///< the sampled stamp's residue is given to the centre texel (crater)
    std::uint64_t hash = 0;    ///< XXH3-64 of kind, size, weights and how it is widened and balanced
};

/// The shapes of one world. Shapes are only ever added; ids stay valid. Built-in profiles are always there.
/// Adding a shape whose name and data are those of one that is there gives the id of that one: a host may add its
/// shapes again after it opened a world that has them. Another shape under a name that is taken is refused. Threads:
/// adding needs exclusive access; reading is free.
class ShapeLibrary {
public:
    ShapeLibrary();

    /// Adds a radial profile baked from `weight(t)`, t in [0, 1], values in [-1, 1]. Evaluated 1 025 times, now.
    /// Fails when the name is empty or another shape's, a value is not finite or out of range, or `least_radius_texels`
    /// is not in [0.5, 8 192).
    Result<ShapeId> add_profile(std::string name, const std::function<double(double t)>& weight,
                                double least_radius_texels = 2.0);

    /// Adds an image of 16-bit texels: 65 535 is weight 1, 0 is weight 0. `texels` has width * height values, column
    /// along +x, row along +z. Sizes 1..4 096.
    Result<ShapeId> add_image(std::string name, std::int32_t width, std::int32_t height,
                              std::span<const std::uint16_t> texels);

    /// Bakes any function of (x, z), both in [-1, 1] over the stamp's square, into a `size` x `size` image; values in
    /// [-1, 1]. Parameters are what the function captures: bake once per set of them.
    Result<ShapeId> bake(std::string name, std::int32_t size, const std::function<double(double x, double z)>& weight);

    /// Adds a shape as it was in another library: name, kind, size, weights, least radius and balance are taken as they
    /// are; the rest is computed. Fails with the field's name on values that no shape has.
    Result<ShapeId> add_exact(Shape shape);

    [[nodiscard]] std::optional<ShapeId> find(std::string_view name) const;
    /// As `find`; fails with NotFound and the names that exist.
    [[nodiscard]] Result<ShapeId> named(std::string_view name) const;
    /// `id` must come from this library.
    [[nodiscard]] const Shape& shape(ShapeId id) const;
    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(shapes_.size()); }

private:
    Result<ShapeId> add(Shape shape);
    ShapeId keep(Shape shape);
    std::deque<Shape> shapes_;  // a reference to a shape stays good when others are added
};

}  // namespace tilth
