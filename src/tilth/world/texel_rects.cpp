#include "tilth/world/texel_rects.h"

#include <map>
#include <utility>

namespace tilth {
namespace {

constexpr std::size_t kMostExact = 256;
constexpr std::int32_t kBlockBits = 6, kBlock = 1 << kBlockBits;

std::vector<TexelRect> block_bounds(std::span<const TexelRect> rects) {
    std::map<std::pair<std::int32_t, std::int32_t>, TexelRect> blocks;
    for (const TexelRect& rect : rects)
        for (std::int32_t z = rect.min.z >> kBlockBits; z * kBlock < rect.max.z; ++z)
            for (std::int32_t x = rect.min.x >> kBlockBits; x * kBlock < rect.max.x; ++x) {
                const TexelRect block{{x * kBlock, z * kBlock}, {(x + 1) * kBlock, (z + 1) * kBlock}};
                TexelRect& bounds = blocks[{z, x}];
                bounds = bounds_of(bounds, intersection(rect, block));
            }
    std::vector<TexelRect> out;
    for (const auto& [place, bounds] : blocks)
        if (!bounds.empty()) out.push_back(bounds);
    return out;
}

}  // namespace

void subtract(const TexelRect& rect, const TexelRect& hole, std::vector<TexelRect>& out) {
    const TexelRect cut = intersection(rect, hole);
    if (cut.empty()) {
        out.push_back(rect);
        return;
    }
    const auto keep = [&](const TexelRect& piece) {
        if (!piece.empty()) out.push_back(piece);
    };
    keep({rect.min, {rect.max.x, cut.min.z}});
    keep({{rect.min.x, cut.max.z}, rect.max});
    keep({{rect.min.x, cut.min.z}, {cut.min.x, cut.max.z}});
    keep({{cut.max.x, cut.min.z}, {rect.max.x, cut.max.z}});
}

std::vector<TexelRect> disjoint(std::span<const TexelRect> rects) {
    if (rects.size() > kMostExact) return block_bounds(rects);
    std::vector<TexelRect> done;
    for (const TexelRect& rect : rects) {
        if (rect.empty()) continue;
        std::vector<TexelRect> pieces{rect};
        for (const TexelRect& other : done) {
            if (intersection(rect, other).empty()) continue;
            std::vector<TexelRect> rest;
            for (const TexelRect& piece : pieces) subtract(piece, other, rest);
            pieces = std::move(rest);
        }
        done.insert(done.end(), pieces.begin(), pieces.end());
    }
    return done;
}

}  // namespace tilth
