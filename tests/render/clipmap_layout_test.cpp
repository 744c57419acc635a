// The layout is right if every cell of the map is drawn exactly once and the morph is 0 and 1 where levels meet.
#include "tilth/render/clipmap_layout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "tilth/core/shared_glsl.h"

namespace tilth::shared {
#include "shared/clipmap_morph.glsl"
}

namespace tilth {
namespace {

std::int32_t post_of(std::int32_t vertex, std::int32_t level, std::int32_t last) {
    return static_cast<std::int32_t>(std::min(std::int64_t{vertex} << level, std::int64_t{last}));
}

struct Case {
    ClipmapSettings settings;
    PostPos viewer;
    Texel last;
};

/// Where viewers stand: corners, outside, on and next to snapping borders, odd fractions.
std::vector<Case> cases() {
    std::vector<Case> all;
    const double ulp_before = std::nextafter(64.0, 0), ulp_after = std::nextafter(64.0, 100);
    for (const auto& [n, levels] : {std::pair{15, 1}, {15, 4}, {31, 3}, {15, 6}})
        for (const Texel last : {Texel{343, 402}, {256, 256}, {100, 37}, {1, 1}, {1024, 3}})
            for (const PostPos viewer : {PostPos{0, 0},
                                         {-40.3, 12.7},
                                         {171.5, 200.25},
                                         {343, 402},
                                         {64, 64},
                                         {ulp_before, ulp_after},
                                         {63.0, 65.0},
                                         {99.99, 36.5},
                                         {-5000, 3},
                                         {355, 90.6}})
                all.push_back({{.n = n, .levels = levels, .blend = 0.1}, viewer, last});
    return all;
}

std::string name(const Case& c) {
    return text("n ", c.settings.n, ", levels ", c.settings.levels, ", viewer ", c.viewer.x, ", ", c.viewer.z,
                ", last ", c.last.x, ", ", c.last.z);
}

TEST(ClipmapLayout, EveryCellWithinTheCoarsestWindowIsDrawnOnce) {
    for (const Case& c : cases()) {
        const ClipmapLayout layout = clipmap_layout(c.settings, c.viewer, c.last.x, c.last.z);
        std::vector<int> drawn(static_cast<std::size_t>(c.last.x) * static_cast<std::size_t>(c.last.z));
        for (const ClipmapBlock& b : layout.blocks) {
            ASSERT_TRUE(b.width >= 1 && b.width <= kBlockQuads && b.depth >= 1 && b.depth <= kBlockQuads) << name(c);
            ASSERT_TRUE(b.x >= 0 && b.z >= 0) << name(c);
            // No quad is empty: the last vertex but one lies before the last post.
            ASSERT_LT(std::int64_t{b.x + b.width - 1} << b.level, c.last.x) << name(c);
            ASSERT_LT(std::int64_t{b.z + b.depth - 1} << b.level, c.last.z) << name(c);
            for (std::int32_t z = post_of(b.z, b.level, c.last.z); z < post_of(b.z + b.depth, b.level, c.last.z); ++z)
                for (std::int32_t x = post_of(b.x, b.level, c.last.x); x < post_of(b.x + b.width, b.level, c.last.x);
                     ++x)
                    ++drawn[static_cast<std::size_t>(z) * static_cast<std::size_t>(c.last.x) +
                            static_cast<std::size_t>(x)];
        }
        const ClipmapBlock& outer = layout.windows.back();
        const auto inside = [&](std::int64_t p, std::int32_t min, std::int32_t quads) {
            return p >= std::int64_t{min} << outer.level && p < std::int64_t{min + quads} << outer.level;
        };
        for (std::int32_t z = 0; z < c.last.z; ++z)
            for (std::int32_t x = 0; x < c.last.x; ++x)
                ASSERT_EQ(drawn[static_cast<std::size_t>(z) * static_cast<std::size_t>(c.last.x) +
                                static_cast<std::size_t>(x)],
                          inside(x, outer.x, outer.width) && inside(z, outer.z, outer.depth) ? 1 : 0)
                    << name(c) << ", cell " << x << ", " << z;
    }
}

TEST(ClipmapLayout, WindowsAreEvenNestedAndCentred) {
    for (const std::int32_t n : {15, 31, 63, 127, 255, 511, 1023}) {
        for (int step = 0; step < 400; ++step) {
            const PostPos viewer{-50 + step * 0.37, 1e6 - step * 1.13};
            const ClipmapLayout layout = clipmap_layout({.n = n, .levels = 8, .blend = 0.1}, viewer, 1 << 20, 1 << 20);
            for (std::size_t l = 0; l < layout.windows.size(); ++l) {
                const ClipmapBlock& w = layout.windows[l];
                ASSERT_EQ(w.x % 2, 0);
                ASSERT_EQ(w.z % 2, 0);
                const double unit = std::ldexp(1.0, static_cast<int>(l));
                ASSERT_LE(std::abs(w.x + w.width * 0.5 - viewer.x / unit), 1.0) << n << " level " << l;
                ASSERT_LE(std::abs(w.z + w.depth * 0.5 - viewer.z / unit), 1.0) << n << " level " << l;
                if (l == 0) continue;
                const ClipmapBlock& inner = layout.windows[l - 1];
                ASSERT_GT(inner.x / 2, w.x);
                ASSERT_LT((inner.x + inner.width) / 2, w.x + w.width);
            }
        }
    }
}

// Every vertex of a border: alpha is 1 outside and 0 at the hole, computed in float as the shader does.
TEST(ClipmapLayout, MorphIsOneOnOuterBordersAndZeroOnHoles) {
    for (const std::int32_t n : {15, 31, 63, 127, 255, 511, 1023}) {
        for (const double blend : {0.02, 0.1, 0.25}) {
            const float zone = shared::morph_zone_units(n, static_cast<float>(blend));
            ASSERT_GT(zone, 0.25f);
            int partly = 0;
            for (int step = 0; step < 300; ++step) {
                const PostPos viewer{5000 + step * 0.7, 5000 - step * 0.413};
                const ClipmapLayout layout =
                    clipmap_layout({.n = n, .levels = 5, .blend = blend}, viewer, 1 << 20, 1 << 20);
                for (std::size_t l = 0; l + 1 < layout.windows.size(); ++l) {
                    const auto alpha_at = [&](std::size_t level, double x_posts, double z_posts) {
                        const double d = std::max(std::abs(x_posts - viewer.x), std::abs(z_posts - viewer.z));
                        return shared::morph_alpha(static_cast<float>(std::ldexp(d, -static_cast<int>(level))), n,
                                                   zone);
                    };
                    const ClipmapBlock& w = layout.windows[l];
                    const double unit = std::ldexp(1.0, static_cast<int>(l));
                    for (std::int32_t i = 0; i <= w.width; ++i) {
                        for (const double across : {w.z * unit, (w.z + w.depth) * unit}) {
                            ASSERT_EQ(alpha_at(l, (w.x + i) * unit, across), 1.0f) << n << " " << blend << " " << l;
                            ASSERT_EQ(alpha_at(l + 1, (w.x + i) * unit, across), 0.0f) << n << " " << blend << " " << l;
                        }
                        for (const double across : {w.x * unit, (w.x + w.width) * unit}) {
                            ASSERT_EQ(alpha_at(l, across, (w.z + i) * unit), 1.0f) << n << " " << blend << " " << l;
                            ASSERT_EQ(alpha_at(l + 1, across, (w.z + i) * unit), 0.0f) << n << " " << blend << " " << l;
                        }
                        const float alpha = alpha_at(l, (w.x + i) * unit, viewer.z);
                        partly += alpha > 0 && alpha < 1;
                    }
                }
            }
            EXPECT_GT(partly, 0) << "the zone holds vertices: n " << n << ", blend " << blend;
        }
    }
}

// Each odd border vertex with a coarser level outside has exactly one stitch triangle; nothing else has one.
TEST(ClipmapLayout, StitchesCoverTheBordersToCoarserLevels) {
    for (const Case& c : cases()) {
        const ClipmapLayout layout = clipmap_layout(c.settings, c.viewer, c.last.x, c.last.z);
        // Quads as drawn, by level, to find where two levels meet.
        std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> level_of_cell;
        for (const ClipmapBlock& b : layout.blocks)
            for (std::int32_t z = post_of(b.z, b.level, c.last.z); z < post_of(b.z + b.depth, b.level, c.last.z); ++z)
                for (std::int32_t x = post_of(b.x, b.level, c.last.x); x < post_of(b.x + b.width, b.level, c.last.x);
                     ++x)
                    level_of_cell[{x, z}] = b.level;
        const auto level_at = [&](std::int32_t x, std::int32_t z) {
            const auto found = level_of_cell.find({x, z});
            return found == level_of_cell.end() ? -1 : found->second;
        };
        std::set<std::array<std::int32_t, 4>> wanted, found;  // along x or z, the triangle's ends, across: in posts
        const auto want = [&](bool along_x, std::int32_t along, std::int32_t across, std::int32_t a, std::int32_t b) {
            if (a == b || a < 0 || b < 0) return;
            const std::int32_t fine = std::min(a, b), last = along_x ? c.last.x : c.last.z;
            const std::int32_t low = (along >> (fine + 1)) << (fine + 1);
            if (low + (1 << fine) >= last) return;  // the last column has no odd vertex
            wanted.insert({along_x, low, std::min(low + (2 << fine), last), across});
        };
        for (std::int32_t z = 0; z < c.last.z; ++z) {
            for (std::int32_t x = 0; x < c.last.x; ++x) {
                if (x > 0) want(false, z, x, level_at(x - 1, z), level_at(x, z));
                if (z > 0) want(true, x, z, level_at(x, z - 1), level_at(x, z));
            }
        }
        for (const ClipmapBlock& s : layout.stitches) {
            ASSERT_TRUE((s.width == 0) != (s.depth == 0)) << name(c);
            const bool along_x = s.depth == 0;
            const std::int32_t from = along_x ? s.x : s.z, length = along_x ? s.width : s.depth;
            const std::int32_t last = along_x ? c.last.x : c.last.z;
            ASSERT_EQ(from % 2, 0) << name(c);
            ASSERT_LE(length, kBlockQuads);
            for (std::int32_t i = 0; i < length; i += 2) {
                const std::int32_t low = post_of(from + i, s.level, last),
                                   middle = post_of(from + i + 1, s.level, last);
                const std::int32_t high = post_of(from + std::min(i + 2, length), s.level, last);
                if (middle == high) continue;  // no area and no odd vertex: the map ends
                const std::int32_t across = post_of(along_x ? s.z : s.x, s.level, along_x ? c.last.z : c.last.x);
                ASSERT_TRUE(found.insert({along_x, low, high, across}).second) << name(c) << ": twice";
            }
        }
        ASSERT_EQ(found, wanted) << name(c);
    }
}

// V1: on a snapping border and one ulp beside it the layout may differ, but is complete in each (first test); the
// distance at which it snaps is the same for all.
TEST(ClipmapLayout, SnapsEveryTwoUnits) {
    const ClipmapSettings settings{.n = 63, .levels = 3, .blend = 0.1};
    for (int level = 0; level < 3; ++level) {
        std::set<std::int32_t> corners;
        for (double x = 1000; x < 1000 + 80; x += 0.125)
            corners.insert(clipmap_layout(settings, {x, 0}, 4096, 4096).windows[static_cast<std::size_t>(level)].x);
        EXPECT_NEAR(static_cast<double>(corners.size()), 80.0 / (2 << level), 1.0);
    }
    const double border = 1000;  // (1000 - 31) / 2 + 0.5 = 485: a corner just changes
    EXPECT_EQ(clipmap_layout(settings, {border, 0}, 4096, 4096).windows[0].x,
              clipmap_layout(settings, {std::nextafter(border, 2000), 0}, 4096, 4096).windows[0].x);
    EXPECT_EQ(clipmap_layout(settings, {border, 0}, 4096, 4096).windows[0].x - 2,
              clipmap_layout(settings, {std::nextafter(border, 0), 0}, 4096, 4096).windows[0].x);
}

TEST(ClipmapLayout, RefusesSettingsByName) {
    for (const std::int32_t n : {0, 7, 16, 254, 2047}) {
        const Result<void> result = check_clipmap({.n = n});
        ASSERT_FALSE(result);
        EXPECT_NE(result.error().message.find("clipmap.n is "), std::string::npos);
    }
    EXPECT_NE(check_clipmap({.levels = 0}).error().message.find("clipmap.levels"), std::string::npos);
    EXPECT_NE(check_clipmap({.levels = 17}).error().message.find("clipmap.levels"), std::string::npos);
    EXPECT_NE(check_clipmap({.blend = 0.3}).error().message.find("clipmap.blend"), std::string::npos);
    EXPECT_FALSE(check_clipmap({.blend = std::nan("")}));
    EXPECT_TRUE(check_clipmap({}));
}

// On its own grid a post has no coarser neighbours but itself; elsewhere they lie on the next grid, or on the last
// post.
TEST(ClipmapMorph, CoarseNeighbours) {
    for (const int last : {100, 343, 255, 256}) {
        for (int level = 0; level < 5; ++level) {
            for (int p = 0; p <= last; ++p) {
                const int low = shared::coarse_low(p, level, last), high = shared::coarse_high(p, level, last);
                const float t = shared::coarse_weight(p, low, high);
                if (p % (2 << level) == 0 || p == last) {
                    EXPECT_EQ(low, p);
                    EXPECT_EQ(high, p);
                    EXPECT_EQ(t, 0.0f);
                } else {
                    EXPECT_TRUE(low < p && p < high && low % (2 << level) == 0) << p;
                    EXPECT_TRUE(high == low + (2 << level) || high == last) << p;
                    EXPECT_FLOAT_EQ(static_cast<float>(low) + t * static_cast<float>(high - low),
                                    static_cast<float>(p));
                }
            }
        }
    }
}

}  // namespace
}  // namespace tilth
