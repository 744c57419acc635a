#include "tilth/derive/relief_rects.h"

#include <algorithm>
#include <utility>

#include "tilth/core/checks.h"
#include "tilth/world/texel_rects.h"
#include "tilth/world/tile_grid.h"

namespace tilth {
TexelRect relief_square(Texel texel, std::int32_t size, std::int32_t step) {
    const auto corner = [&](std::int32_t eye) { return floor_divide(eye - size / 2 + step / 2, step) * step; };
    const Texel min{corner(texel.x), corner(texel.z)};
    return {min, {min.x + size, min.z + size}};
}

std::vector<TexelRect> newly_covered(const TexelRect& before, const TexelRect& now) {
    std::vector<TexelRect> in;
    if (!now.empty()) subtract(now, before, in);
    return in;
}

std::vector<WrappedPart> wrapped_parts(const TexelRect& rect, std::int32_t size) {
    TILTH_ASSERT(rect.width() <= size && rect.depth() <= size, "a rectangle larger than the texture");
    std::vector<WrappedPart> parts;
    for (std::int32_t z = rect.min.z; z < rect.max.z;) {
        const std::int32_t at_z = floor_modulo(z, size), next_z = std::min(rect.max.z, z + size - at_z);
        for (std::int32_t x = rect.min.x; x < rect.max.x;) {
            const std::int32_t at_x = floor_modulo(x, size), next_x = std::min(rect.max.x, x + size - at_x);
            parts.push_back({{{x, z}, {next_x, next_z}}, {at_x, at_z}});
            x = next_x;
        }
        z = next_z;
    }
    return parts;
}

TexelRect stale_nodes(const TexelRect& changed, std::int32_t level) {
    if (changed.empty()) return {};
    // Node i reads texels i * side to (i + 1) * side, both included.
    const std::int32_t side = 2 << level;
    const auto first = [side](std::int32_t texel) { return floor_divide(texel - 1, side); };
    const auto last = [side](std::int32_t texel) { return floor_divide(texel, side); };
    return {{first(changed.min.x), first(changed.min.z)}, {last(changed.max.x - 1) + 1, last(changed.max.z - 1) + 1}};
}

std::vector<TexelRect> wrapped_rects(std::span<const TexelRect> rects, std::int32_t size) {
    std::vector<TexelRect> wrapped;
    for (TexelRect rect : rects) {
        rect.max = {std::min(rect.max.x, rect.min.x + size), std::min(rect.max.z, rect.min.z + size)};
        for (const WrappedPart& part : wrapped_parts(rect, size))
            wrapped.push_back({part.at, {part.at.x + part.map.width(), part.at.z + part.map.depth()}});
    }
    return disjoint(wrapped);
}

std::vector<TexelRect> taken(std::vector<TexelRect>& rest, const TexelRect& of) {
    std::vector<TexelRect> out, left;
    for (const TexelRect& rect : rest) {
        if (const TexelRect both = intersection(rect, of); !both.empty()) out.push_back(both);
        subtract(rect, of, left);
    }
    rest = std::move(left);
    return out;
}

}  // namespace tilth
