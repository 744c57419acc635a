#include "tilth/ground/shape_library.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "tilth/core/hash.h"
#include "tilth/ground/profile_tables.h"

namespace tilth {
namespace {

struct Builtin {
    BuiltinProfile profile;
    const char* name;
    double least_radius_texels;  // below it the sampled volume depends on the phase; derived by a test
};

constexpr Builtin kBuiltins[kBuiltinProfiles] = {
    {BuiltinProfile::Gaussian, "gaussian", 1.75},    {BuiltinProfile::Cone, "cone", 2.0},
    {BuiltinProfile::Paraboloid, "paraboloid", 2.0}, {BuiltinProfile::Cosine, "cosine", 1.5},
    {BuiltinProfile::Crater, "crater", 3.0},         {BuiltinProfile::Disc, "disc", 6.0},
};

constexpr double kLeastImageRadius = 2.0;  // texels: an image is band-limited by its bilinear pixels, like the cone
constexpr std::int32_t kMaxImageSize = 4096;

std::uint64_t hash_of(const Shape& shape) {
    StateHasher hasher;
    hasher.add_i64(shape.is_image ? 1 : 0);
    hasher.add_i64(shape.width);
    hasher.add_i64(shape.height);
    hasher.add_i64(static_cast<std::int64_t>(std::floor(shape.least_radius_texels * 1024)));
    hasher.add_i64(shape.zero_volume ? 1 : 0);
    for (const std::int32_t weight : shape.weights) hasher.add_i64(weight);
    return hasher.digest();
}

// A weight in [-1, 1] as an integer, in 16 bits of magnitude; empty when it is not one.
std::optional<std::int32_t> integer_weight(double weight) {
    if (!(std::abs(weight) <= 1.0)) return std::nullopt;
    return static_cast<std::int32_t>(std::lround(weight * kWeightOne));
}

}  // namespace

ShapeLibrary::ShapeLibrary() {
    for (const Builtin& builtin : kBuiltins) {
        const std::span<const std::int32_t> table = profile_table(builtin.profile);
        Shape shape{.name = builtin.name,
                    .weights = {table.begin(), table.end()},
                    .least_radius_texels = builtin.least_radius_texels,
                    .zero_volume = builtin.profile == BuiltinProfile::Crater};
        keep(std::move(shape));
    }
}

ShapeId ShapeLibrary::keep(Shape shape) {
    const auto [lowest, highest] = std::minmax_element(shape.weights.begin(), shape.weights.end());
    shape.lowest_weight = *lowest;
    shape.highest_weight = *highest;
    shape.hash = hash_of(shape);
    shapes_.push_back(std::move(shape));
    return {size() - 1};
}

Result<ShapeId> ShapeLibrary::add(Shape shape) {
    if (shape.name.empty()) return Error{ErrorCode::InvalidArgument, "name: a shape needs a name"};
    const std::optional<ShapeId> known = find(shape.name);
    if (!known) return keep(std::move(shape));
    if (shapes_[known->value].hash == hash_of(shape)) return *known;
    return Error{ErrorCode::InvalidArgument,
                 text("name: another shape called '", shape.name, "' exists already; give this one another name")};
}

Result<ShapeId> ShapeLibrary::add_exact(Shape shape) {
    if (!(shape.least_radius_texels >= 0.5 && shape.least_radius_texels < 8192))
        return Error{ErrorCode::InvalidArgument,
                     text("least_radius_texels: ", shape.least_radius_texels, " is not in [0.5, 8192)")};
    const bool has_size = shape.is_image ? shape.width >= 1 && shape.height >= 1 && shape.width <= kMaxImageSize &&
                                               shape.height <= kMaxImageSize
                                         : shape.width == 0 && shape.height == 0;
    if (!has_size)
        return Error{ErrorCode::InvalidArgument,
                     text("size: ", shape.width, " x ", shape.height, "; an image has 1..4096 a side, a profile none")};
    const std::size_t weights = shape.is_image
                                    ? static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height)
                                    : static_cast<std::size_t>(kProfileEntries);
    if (shape.weights.size() != weights)
        return Error{ErrorCode::InvalidArgument,
                     text("weights: '", shape.name, "' has ", shape.weights.size(), ", needs ", weights)};
    for (const std::int32_t weight : shape.weights)
        if (weight < -kWeightOne || weight > kWeightOne)
            return Error{ErrorCode::InvalidArgument,
                         text("weights: '", shape.name, "' has ", weight, ", not a value in -65536..65536")};
    return add(std::move(shape));
}

Result<ShapeId> ShapeLibrary::add_profile(std::string name, const std::function<double(double)>& weight,
                                          double least_radius_texels) {
    if (!(least_radius_texels >= 0.5 && least_radius_texels < 8192))
        return Error{ErrorCode::InvalidArgument,
                     text("least_radius_texels: ", least_radius_texels, " is not in [0.5, 8192)")};
    Shape shape{.name = std::move(name), .least_radius_texels = least_radius_texels};
    shape.weights.reserve(kProfileEntries);
    for (int i = 0; i < kProfileEntries; ++i) {
        const double t = i / 1024.0, value = weight(t);
        const std::optional<std::int32_t> entry = integer_weight(value);
        if (!entry)
            return Error{ErrorCode::InvalidArgument, text("weight: profile '", shape.name, "' gives ", value,
                                                          " at t = ", t, ", not a value in [-1, 1]")};
        shape.weights.push_back(*entry);
    }
    return add(std::move(shape));
}

Result<ShapeId> ShapeLibrary::add_image(std::string name, std::int32_t width, std::int32_t height,
                                        std::span<const std::uint16_t> texels) {
    if (width < 1 || height < 1 || width > kMaxImageSize || height > kMaxImageSize)
        return Error{ErrorCode::InvalidArgument,
                     text("size: stamp image '", name, "' is ", width, " x ", height, "; 1..4096 a side are allowed")};
    if (texels.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        return Error{ErrorCode::InvalidArgument, text("texels: stamp image '", name, "' of ", width, " x ", height,
                                                      " has ", texels.size(), " values")};
    Shape shape{.name = std::move(name),
                .is_image = true,
                .width = width,
                .height = height,
                .least_radius_texels = kLeastImageRadius};
    shape.weights.reserve(texels.size());
    for (const std::uint16_t texel : texels) shape.weights.push_back(texel + (texel >> 15));  // 65535 -> 65536
    return add(std::move(shape));
}

Result<ShapeId> ShapeLibrary::bake(std::string name, std::int32_t size,
                                   const std::function<double(double, double)>& weight) {
    if (size < 1 || size > kMaxImageSize)
        return Error{ErrorCode::InvalidArgument, text("size: ", size, " is not in 1..4096")};
    Shape shape{.name = std::move(name),
                .is_image = true,
                .width = size,
                .height = size,
                .least_radius_texels = kLeastImageRadius};
    shape.weights.reserve(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    for (std::int32_t row = 0; row < size; ++row)
        for (std::int32_t column = 0; column < size; ++column) {
            const double x = (2 * column + 1) / static_cast<double>(size) - 1;
            const double z = (2 * row + 1) / static_cast<double>(size) - 1;
            const double value = weight(x, z);
            const std::optional<std::int32_t> entry = integer_weight(value);
            if (!entry)
                return Error{ErrorCode::InvalidArgument, text("weight: function '", shape.name, "' gives ", value,
                                                              " at (", x, ", ", z, "), not a value in [-1, 1]")};
            shape.weights.push_back(*entry);
        }
    return add(std::move(shape));
}

std::optional<ShapeId> ShapeLibrary::find(std::string_view name) const {
    const auto found =
        std::find_if(shapes_.begin(), shapes_.end(), [&](const Shape& shape) { return shape.name == name; });
    if (found == shapes_.end()) return std::nullopt;
    return ShapeId{static_cast<std::uint32_t>(std::distance(shapes_.begin(), found))};
}

Result<ShapeId> ShapeLibrary::named(std::string_view name) const {
    if (const std::optional<ShapeId> found = find(name)) return *found;
    std::string names;
    for (const Shape& shape : shapes_) names += (names.empty() ? "" : ", ") + shape.name;
    return Error{ErrorCode::NotFound, text("shape: no '", name, "' in the library; there are: ", names)};
}

const Shape& ShapeLibrary::shape(ShapeId id) const {
    TILTH_ASSERT(id.value < size(), "a shape id of another library");
    return shapes_[id.value];
}

}  // namespace tilth
