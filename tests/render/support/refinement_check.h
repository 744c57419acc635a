// Holds a captured refinement against what it ought to be. All names and areas are integers, all heights doubles.
#pragma once

#include <map>
#include <set>

#include "render/support/refinement_mesh.h"

namespace tilth::test {

/// What was wrong, counted; all 0 for a right refinement.
struct RefinementFindings {
    std::uint64_t miscounted = 0;       ///< triangles that GL wrote or counted, against f^2, fans, one
    std::uint64_t nameless = 0;         ///< points off the lattice of the last factor
    std::uint64_t turned = 0;           ///< triangles wound against their parent, or without area
    std::uint64_t untiled = 0;          ///< parents whose triangles leave a gap, overlap or stand out
    std::uint64_t unequal_bits = 0;     ///< a point of two triangles that is not the same to the bit
    std::uint64_t open_edges = 0;       ///< edges of one triangle alone, inside the mesh: cracks
    std::uint64_t changed_corners = 0;  ///< corners, and triangles that pass through, that are not what came in
    std::uint64_t unlike_plain = 0;     ///< unmarked corners that are not those of the program without relief
    std::uint64_t off_surface = 0;      ///< points off coarse + share * detail by more than float's error
    double worst_of_tolerance = 0;      ///< largest distance to it, in tolerances

    std::uint64_t edges = 0, points = 0, primitives = 0, parents = 0;  ///< looked at
    std::set<int> cases;  ///< marks, marks across the edges, winding, first corner: 8 * 8 * 2 * 3

    RefinementFindings& operator+=(const RefinementFindings& o) {
        miscounted += o.miscounted, nameless += o.nameless, turned += o.turned, untiled += o.untiled;
        unequal_bits += o.unequal_bits, open_edges += o.open_edges, changed_corners += o.changed_corners;
        unlike_plain += o.unlike_plain, off_surface += o.off_surface;
        worst_of_tolerance = std::max(worst_of_tolerance, o.worst_of_tolerance);
        edges += o.edges, points += o.points, primitives += o.primitives, parents += o.parents;
        cases.insert(o.cases.begin(), o.cases.end());
        return *this;
    }
};

/// Triangles of a parent whose corners allow these factors.
inline std::uint64_t triangles_of(std::array<std::int32_t, 3> factors) {
    std::sort(factors.begin(), factors.end());
    const auto f = static_cast<std::uint64_t>(factors[0]), g = static_cast<std::uint64_t>(factors[1]);
    return g == 1 ? 1 : f * f - f + g;
}

/// The corners of every triangle that `mesh` draws, in order.
inline std::vector<std::array<Texel, 3>> parents_of(const RefinementMesh& mesh) {
    std::vector<std::array<Texel, 3>> parents;
    for (std::size_t block = 0; block < mesh.blocks.size(); ++block)
        for (const auto& [a, b, c] : mesh.corners)
            parents.push_back({mesh.post(block, a), mesh.post(block, b), mesh.post(block, c)});
    return parents;
}

namespace refinement {

inline std::int64_t cross(Texel a, Texel b, Texel c) {
    return std::int64_t{b.x - a.x} * (c.z - a.z) - std::int64_t{b.z - a.z} * (c.x - a.x);
}
inline std::uint64_t key(Texel t) {
    return (static_cast<std::uint64_t>(t.z + 32768) << 16) | static_cast<std::uint64_t>(t.x + 32768);
}
inline std::uint64_t edge_key(Texel a, Texel b) {
    const std::uint64_t p = key(a), q = key(b);
    return (std::min(p, q) << 32) | std::max(p, q);
}

/// The marks of a triangle, of the corners across its edges, its winding and first corner, as one number.
inline void note_cases(const std::vector<std::array<Texel, 3>>& parents, const auto& is_marked, std::set<int>& cases) {
    std::map<std::uint64_t, std::vector<Texel>> across;
    for (const auto& p : parents)
        for (std::size_t i = 0; i < 3; ++i) across[edge_key(p[i], p[(i + 1) % 3])].push_back(p[(i + 2) % 3]);
    for (const auto& p : parents) {
        std::array<std::size_t, 3> order{0, 1, 2};
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(p[a]) < key(p[b]); });
        int name = cross(p[0], p[1], p[2]) > 0 ? 1 : 0;
        name = name * 3 + static_cast<int>(order[0]);
        bool inner = true;
        for (std::size_t i = 0; i < 3; ++i) {
            const Texel a = p[order[i]], b = p[order[(i + 1) % 3]], own = p[order[(i + 2) % 3]];
            const std::vector<Texel>& both = across[edge_key(a, b)];
            inner = inner && both.size() == 2;
            if (!inner) break;
            name = name * 4 + (is_marked(a) ? 2 : 0) + (is_marked(both[0] == own ? both[1] : both[0]) ? 1 : 0);
        }
        if (inner) cases.insert(name);
    }
}

}  // namespace refinement

/// Draws and looks. Every edge of the mesh belongs to two of its triangles or to the rim of the square that they fill.
inline RefinementFindings check_refinement(RefinementScene& scene, const RefinementSetting& s,
                                           const RefinementMesh& mesh) {
    using namespace refinement;
    using Stages = RefinementScene::Stages;
    RefinementFindings found;
    const std::vector<std::array<Texel, 3>> parents = parents_of(mesh);
    const auto input = scene.capture(Stages::Input, s, mesh, parents.size());
    const auto plain = scene.capture(Stages::Plain, s, mesh, parents.size());
    if (input.size() != parents.size() || plain.size() != parents.size()) {
        found.miscounted = 1;
        return found;
    }
    struct Post {
        std::int32_t factor = 0;
        bool marked = false;
        double base_m = 0;
    };
    std::map<std::uint64_t, Post> posts;
    Texel low = parents[0][0], high = low;
    for (const auto& parent : parents)
        for (const Texel& post : parent) {
            low = {std::min(low.x, post.x), std::min(low.z, post.z)};
            high = {std::max(high.x, post.x), std::max(high.z, post.z)};
            if (!posts.contains(key(post)))
                posts[key(post)] = {scene.factor(post, s), scene.marked(post, s), scene.base_m(post, s)};
        }
    std::uint64_t expected = 0;
    std::vector<std::uint64_t> counts;
    for (const auto& p : parents) {
        counts.push_back(triangles_of({posts[key(p[0])].factor, posts[key(p[1])].factor, posts[key(p[2])].factor}));
        expected += counts.back();
    }
    const auto out = scene.capture(Stages::Refined, s, mesh, expected + 1000, &found.primitives);
    found.parents = parents.size();
    if (out.size() != expected || found.primitives != expected) {
        found.miscounted = 1 + (expected > out.size() ? expected - out.size() : out.size() - expected);
        return found;
    }
    note_cases(
        parents, [&](Texel post) { return posts[key(post)].marked; }, found.cases);

    // Names: units of 1 / last factor of a post, from the first post of the mesh.
    const std::int32_t last = s.chain.back();
    const auto name_of = [&](Texel post) { return Texel{(post.x - low.x) * last, (post.z - low.z) * last}; };
    const Texel extent = name_of(high);
    std::vector<CapturedVertex> by_name(static_cast<std::size_t>(extent.x + 1) *
                                        static_cast<std::size_t>(extent.z + 1));
    std::vector<bool> seen(by_name.size());
    std::vector<std::uint64_t> rims;
    std::size_t next = 0;
    for (std::size_t i = 0; i < parents.size(); ++i) {
        const auto& parent = parents[i];
        const std::array<Texel, 3> corner{name_of(parent[0]), name_of(parent[1]), name_of(parent[2])};
        const std::int64_t area = cross(corner[0], corner[1], corner[2]);
        std::int64_t covered = 0;
        std::vector<std::uint64_t> inner;
        bool contained = true;
        if (counts[i] == 1 && out[next] != input[i]) ++found.changed_corners;
        for (std::size_t t = next; t < next + counts[i]; ++t) {
            std::array<Texel, 3> names;
            for (std::size_t v = 0; v < 3; ++v) {
                const CapturedVertex& vertex = out[t][v];
                const auto units = [&](float m, float fraction_m, std::int32_t base, std::int32_t from) {
                    return ((double{m} + double{fraction_m}) / double{s.spacing_m} + base - from) * last;
                };
                const double x = units(vertex.position_m[0], s.fraction_m[0], s.base_post.x, low.x);
                const double z = units(vertex.position_m[2], s.fraction_m[1], s.base_post.z, low.z);
                const Texel name{static_cast<std::int32_t>(std::lround(std::clamp(x, 0.0, double(extent.x)))),
                                 static_cast<std::int32_t>(std::lround(std::clamp(z, 0.0, double(extent.z))))};
                names[v] = name;
                // Position: two roundings of up to 100 m, of a post that is 0.1 m and more.
                if (!(std::max(std::abs(x - name.x), std::abs(z - name.z)) < 2e-3)) ++found.nameless;

                const std::size_t at = static_cast<std::size_t>(name.z) * static_cast<std::size_t>(extent.x + 1) +
                                       static_cast<std::size_t>(name.x);
                if (!seen[at]) {
                    by_name[at] = vertex;
                    ++found.points;
                } else if (!(by_name[at] == vertex)) {
                    ++found.unequal_bits;
                }
                seen[at] = true;

                std::array<double, 3> weight{};
                double base_m = 0, magnitude_m = double{s.eye_above_m} + 20;
                for (std::size_t c = 0; c < 3; ++c) {
                    weight[c] = double(cross(name, corner[(c + 1) % 3], corner[(c + 2) % 3])) / double(area);
                    contained = contained && weight[c] >= 0;
                    base_m += weight[c] * posts[key(parent[c])].base_m;
                    if (weight[c] == 1 && !(vertex == input[i][c])) ++found.changed_corners;
                    if (weight[c] == 1 && !posts[key(parent[c])].marked && !(vertex == plain[i][c]))
                        ++found.unlike_plain;
                }
                bool displaced = true;
                for (std::size_t c = 0; c < 3; ++c)
                    if (weight[c] == 1) displaced = posts[key(parent[c])].marked;
                const Texel n{name.x + (low.x - s.base_post.x) * last, name.z + (low.z - s.base_post.z) * last};
                const double relief_m = displaced ? scene.detail_at_m(n.x, n.z, last, s) : 0;
                const double distance = std::hypot(double{vertex.position_m[0]}, base_m, double{vertex.position_m[2]});
                const double y = base_m + scene.share(distance, s) * relief_m;
                // A dozen roundings of heights of this size; the fade's argument loses what the distance loses.
                const double tolerance =
                    std::ldexp(1.0, -24) *
                    (12 * magnitude_m + 8 * std::abs(relief_m) * (1 + distance / (s.fade_to_m - s.fade_from_m)));
                const double off = std::abs(double{vertex.position_m[1]} - y) / tolerance;
                found.worst_of_tolerance = std::max(found.worst_of_tolerance, off);
                if (!(off <= 1)) ++found.off_surface;
            }
            const std::int64_t part = cross(names[0], names[1], names[2]);
            if ((part > 0) != (area > 0) || part == 0) ++found.turned;
            covered += std::abs(part);
            for (std::size_t v = 0; v < 3; ++v) inner.push_back(edge_key(names[v], names[(v + 1) % 3]));
        }
        next += counts[i];
        // Triangles within the parent that cover its area and meet edge to edge fill it.
        std::sort(inner.begin(), inner.end());
        bool tiled = contained && covered == std::abs(area);
        for (std::size_t e = 0; e < inner.size();) {
            std::size_t end = e;
            while (end < inner.size() && inner[end] == inner[e]) ++end;
            if (end - e > 2) tiled = false;
            if (end - e == 1) rims.push_back(inner[e]);
            e = end;
        }
        if (!tiled) ++found.untiled;
    }
    // What is the edge of one triangle within its parent is on the parent's side, and the edge of a triangle next door.
    std::sort(rims.begin(), rims.end());
    for (std::size_t e = 0; e < rims.size();) {
        std::size_t end = e;
        while (end < rims.size() && rims[end] == rims[e]) ++end;
        const auto end_of = [&](std::uint64_t k) {
            return Texel{static_cast<std::int32_t>(k & 0xffff) - 32768,
                         static_cast<std::int32_t>((k >> 16) & 0xffff) - 32768};
        };
        const Texel a = end_of(rims[e] >> 32), b = end_of(rims[e] & 0xffff'ffffu);
        const bool on_rim =
            (a.x == b.x && (a.x == 0 || a.x == extent.x)) || (a.z == b.z && (a.z == 0 || a.z == extent.z));
        if (end - e != (on_rim ? 1u : 2u)) ++found.open_edges;
        ++found.edges;
        e = end;
    }
    return found;
}

}  // namespace tilth::test
