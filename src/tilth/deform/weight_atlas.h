// The weights of the shapes in use, on the GPU.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "tilth/core/result.h"
#include "tilth/gl/objects.h"
#include "tilth/ground/shape_library.h"

namespace tilth {

/// Profiles and images one behind the other in one R32I texture, 4 096 weights to a row; a shape is uploaded when first
/// asked for, and known by its hash. Nothing exists before that.
class WeightAtlas {
public:
    explicit WeightAtlas(gl::Device& device) : device_(&device) {}

    /// First weight of `shape` in the texture: its column is index % 4096, its row index / 4096. Fails when the texture
    /// would outgrow the driver's limit. `bytes` counts what was uploaded.
    Result<std::uint32_t> place(const Shape& shape, std::uint64_t& bytes);

    /// After the first `place`.
    [[nodiscard]] const gl::Texture2D& texture() const { return *texture_; }

private:
    Result<void> grow(std::int32_t rows, std::uint64_t& bytes);

    gl::Device* device_;
    std::map<std::uint64_t, std::uint32_t> places_;
    std::vector<std::int32_t> weights_;  ///< whole rows; kept to refill a larger texture
    std::uint32_t used_ = 0;
    std::optional<gl::Texture2D> texture_;
};

}  // namespace tilth
