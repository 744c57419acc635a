#include "tilth/ground/height_field.h"

namespace tilth {

HeightField::HeightField(std::int32_t width, std::int32_t depth, std::uint32_t code)
    : width_(width), depth_(depth), codes_(static_cast<std::size_t>(width) * static_cast<std::size_t>(depth), code) {}

}  // namespace tilth
