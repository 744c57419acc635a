// Backend "geometry": the triangles of its shader. Edges that two triangles share are the same to the bit, whatever the
// patterns on either side; every pattern fills its triangle; all points lie on the contract's surface; ground without
// detail passes through; the mesh converges to the full resolution as piecewise linear interpolation must.
#include <cstdlib>

#include "render/support/refinement_check.h"
#include "render/support/refinement_convergence.h"
#include "tilth/ground/random_stamps.h"

namespace tilth::test {
namespace {

class GeometryGlTest : public GlTest {};

// How many random drawings; more than what a run of all tests has time for.
std::uint64_t drawings(std::uint64_t usual) {
    const char* text = std::getenv("TILTH_REFINEMENT_DRAWINGS");
    return text == nullptr ? usual : std::strtoull(text, nullptr, 10);
}

/// Rough ground, random detail, random marks at nodes of two texels; what does not depend on the factors.
void roughen(RefinementScene& scene, std::mt19937_64& random) {
    std::uniform_real_distribution<double> ground(-4, 4), detail(-0.5, 0.5);
    scene.set_ground([&](Texel) { return ground(random); });
    scene.set_detail([&](Texel) { return static_cast<float>(detail(random)); });
}

/// Posts two apart, whose nodes are apart too, so that any set of marks can be had; one block, or four that meet.
RefinementMesh random_mesh(std::mt19937_64& random, std::int32_t blocks) {
    RefinementMesh mesh{.level = 1, .corners = shuffled_triangles(random), .blocks = {}};
    for (std::int32_t i = 0; i < blocks; ++i) mesh.blocks.push_back({5 + 32 * (i % 2), 7 + 32 * (i / 2)});
    return mesh;
}

/// An eye and a window somewhere, and marks.
void place(RefinementScene& scene, RefinementSetting& s, std::mt19937_64& random, double marked) {
    std::uniform_real_distribution<float> unit(0, 1);
    s.base_post = {40 + static_cast<std::int32_t>(random() % 60), 40 + static_cast<std::int32_t>(random() % 60)};
    s.spacing_m = 0.1f + 0.9f * unit(random);
    s.fraction_m = {s.spacing_m * unit(random), s.spacing_m * unit(random)};
    s.eye_above_m = 1 + 4 * unit(random);
    // The texels about a post of the mesh, [-n, n), are then whole nodes.
    const auto somewhere = [&] { return static_cast<std::int32_t>(random() % 512) * 2; };
    const std::int32_t odd = s.texels_per_post % 2;
    const auto aligned = [&](std::int32_t base_post, std::int32_t first) {
        // Texel of the mesh's posts: (first + 2 k - base post) * n + base texel, so that less n is even.
        return (((first - base_post) * s.texels_per_post - s.texels_per_post) % 2 + 2) % 2 * odd;
    };
    s.base_texel = {(somewhere() + aligned(s.base_post.x, 10)) & (scene.size() - 1),
                    (somewhere() + aligned(s.base_post.z, 14)) & (scene.size() - 1)};
    // A post's n x n nodes alike: the share of marked posts is then what was asked for.
    const std::uint64_t seed = random();
    const std::int32_t shift_x = (10 - s.base_post.x) * s.texels_per_post + s.base_texel.x - s.texels_per_post;
    const std::int32_t shift_z = (14 - s.base_post.z) * s.texels_per_post + s.base_texel.z - s.texels_per_post;
    scene.set_presence(0, [&](Texel node) {
        const auto cell = [&](std::int32_t texel, std::int32_t shift) {
            return static_cast<std::uint64_t>(((texel - shift) & (scene.size() - 1)) / (2 * s.texels_per_post));
        };
        SplitMix64 own{seed + cell(2 * node.x, shift_x) * 7919 + cell(2 * node.z, shift_z)};
        return own.unit() < marked;
    });
}

struct Chain {
    const char* name;
    std::int32_t texels_per_post;
    std::vector<std::int32_t> factors;
    double edge_px;  ///< 0: one factor
};
const std::vector<Chain>& chains() {
    static const std::vector<Chain> all{
        {"2", 2, {1, 2}, 0},         {"3", 3, {1, 3}, 0},         {"4", 4, {1, 4}, 0},
        {"5", 5, {1, 5}, 0},         {"8", 8, {1, 8}, 0},         {"1 2 4 8", 8, {1, 2, 4, 8}, 9},
        {"1 2 6", 6, {1, 2, 6}, 12}, {"1 2 4", 4, {1, 2, 4}, 14}, {"3 of 6", 6, {1, 3}, 0}};
    return all;
}

RefinementFindings random_findings(RefinementScene& scene, const Chain& chain, std::mt19937_64& random, bool fading) {
    RefinementSetting s{.texels_per_post = chain.texels_per_post, .chain = chain.factors, .edge_px = chain.edge_px};
    if (fading) s.fade_from_m = 3, s.fade_to_m = 12;
    place(scene, s, random, 0.6);
    const std::int32_t fits =
        scene.size() / (chain.texels_per_post * 2);  // posts of the mesh before the window repeats
    return check_refinement(scene, s, random_mesh(random, fits >= 65 ? 4 : 1));
}

// V3: the eight patterns, every pair of neighbours, both windings, every first corner; factors and mixed factors.
TEST_F(GeometryGlTest, SharedEdgesAreTheSameToTheBit) {
    RefinementScene scene;
    std::mt19937_64 random(11);
    RefinementFindings all;
    for (std::uint64_t drawing = 0; drawing < drawings(2); ++drawing) {
        roughen(scene, random);
        for (const Chain& chain : chains()) {
            SCOPED_TRACE(chain.name);
            const RefinementFindings found = random_findings(scene, chain, random, drawing % 2 != 0);
            EXPECT_EQ(found.miscounted, 0u);
            EXPECT_EQ(found.unequal_bits, 0u);
            EXPECT_EQ(found.open_edges, 0u);
            EXPECT_EQ(found.changed_corners, 0u);
            EXPECT_EQ(found.unlike_plain, 0u);
            EXPECT_GT(found.edges, 3000u);
            all += found;
        }
    }
    EXPECT_EQ(all.cases.size(), 8u * 8u * 2u * 3u) << "patterns, patterns across the edges, windings, first corners";
    std::printf("  %llu edges, %llu points, %llu triangles of %llu\n", static_cast<unsigned long long>(all.edges),
                static_cast<unsigned long long>(all.points), static_cast<unsigned long long>(all.primitives),
                static_cast<unsigned long long>(all.parents));
}

TEST_F(GeometryGlTest, PatternsFillTheirTriangleOnTheContractSurface) {
    RefinementScene scene;
    std::mt19937_64 random(12);
    roughen(scene, random);
    for (const Chain& chain : chains()) {
        SCOPED_TRACE(chain.name);
        const RefinementFindings found = random_findings(scene, chain, random, true);
        EXPECT_EQ(found.miscounted, 0u);
        EXPECT_EQ(found.nameless, 0u);
        EXPECT_EQ(found.turned, 0u);
        EXPECT_EQ(found.untiled, 0u);
        EXPECT_EQ(found.off_surface, 0u) << found.worst_of_tolerance << " tolerances";
        EXPECT_GT(found.worst_of_tolerance, 0.01) << "a tolerance that nothing comes near";
    }
}

// The renderer's own blocks and marks: nodes of two posts and more, here and there.
TEST_F(GeometryGlTest, BlocksOfTheRenderer) {
    RefinementScene scene;
    std::mt19937_64 random(13);
    roughen(scene, random);
    const struct {
        std::int32_t texels_per_post, mark_level;
        std::vector<std::int32_t> chain;
        double edge_px;
    } cases[] = {{3, 2, {1, 3}, 0}, {16, 4, {1, 2, 4, 8}, 10}, {11, 4, {1}, 0}, {40, 5, {1, 2, 4, 8}, 20}};
    for (const auto& c : cases) {
        RefinementSetting s{.texels_per_post = c.texels_per_post,
                            .chain = c.chain,
                            .edge_px = c.edge_px,
                            .fade_from_m = 4,
                            .fade_to_m = 9,
                            .base_post = {40, 40},
                            .base_texel = {77, 1001}};
        scene.set_presence(c.mark_level, [&](Texel) { return random() % 6 == 0; });
        const RefinementFindings found = check_refinement(
            scene, s, {.level = 0, .corners = block_triangles(), .blocks = {{10, 14}, {42, 14}, {10, 46}, {42, 46}}});
        EXPECT_EQ(found.miscounted + found.nameless + found.turned + found.untiled + found.unequal_bits +
                      found.open_edges + found.changed_corners + found.unlike_plain + found.off_surface,
                  0u)
            << c.texels_per_post << " texels a post";
        if (c.chain.size() > 1) {
            EXPECT_GT(found.primitives, found.parents) << "some are split";
        }
    }
}

// Each count of marks by itself, and none: what GL counts is what was drawn.
TEST_F(GeometryGlTest, UntouchedGroundPassesThrough) {
    RefinementScene scene;
    std::mt19937_64 random(14);
    roughen(scene, random);
    const RefinementMesh mesh{.corners = block_triangles(), .blocks = {{10, 14}, {42, 14}}};
    const RefinementSetting s{.texels_per_post = 8, .chain = {1, 2, 4, 8}};
    scene.set_presence(3, [](Texel) { return false; });
    std::uint64_t primitives = 0;
    const auto out = scene.capture(RefinementScene::Stages::Refined, s, mesh, 5000, &primitives);
    EXPECT_EQ(primitives, 2u * 2048u);
    const auto plain = scene.capture(RefinementScene::Stages::Plain, s, mesh, 5000);
    ASSERT_EQ(out.size(), plain.size());
    for (std::size_t i = 0; i < out.size(); ++i) EXPECT_TRUE(out[i] == plain[i]) << "triangle " << i;

    scene.set_presence(3, [](Texel) { return true; });
    for (const std::int32_t f : {1, 2, 4, 8}) {
        const RefinementSetting one{.texels_per_post = 8, .chain = {1, f}};
        static_cast<void>(scene.capture(RefinementScene::Stages::Refined, one, mesh, 300000, &primitives));
        EXPECT_EQ(primitives, 2u * 2048u * static_cast<std::uint64_t>(f * f));
    }
}

// Vertices beyond the end of a smaller block fall together: no point of theirs is worth a triangle.
TEST_F(GeometryGlTest, CollapsedTrianglesAreNotSplit) {
    RefinementScene scene;
    scene.set_ground([](Texel) { return 0.0; });
    scene.set_detail([](Texel) { return 0.1f; });
    scene.set_presence(3, [](Texel) { return true; });
    const RefinementSetting s{.texels_per_post = 4, .chain = {1, 2, 4}};
    std::uint64_t primitives = 0;
    const RefinementMesh mesh{.corners = block_triangles(), .blocks = {{30, 30}}, .quads = 8};
    static_cast<void>(scene.capture(RefinementScene::Stages::Refined, s, mesh, 10000, &primitives));
    EXPECT_EQ(primitives, 2u * 64u * 16u + (2048u - 128u));
}

// What factors that do not divide the texels a post would ask for: the surface between texels, on cells split along the
// diagonal from the low to the high corner.
TEST_F(GeometryGlTest, PointsBetweenTexelsLieOnTheContractSurface) {
    RefinementScene scene;
    std::mt19937_64 random(15);
    roughen(scene, random);
    constexpr std::int32_t side = 64;
    for (const std::int32_t texels_per_post : {1, 3, 8, 64}) {
        for (const std::int32_t parts : {1, 3, 5, 7, 16}) {
            const RefinementSetting s{.texels_per_post = texels_per_post, .base_texel = {3, 1020}};
            const std::vector<float> points = scene.relief_points(s, side, parts);
            double worst = 0;
            for (std::int32_t i = 0; i < side * side; ++i) {
                const double x = double(i % side - side / 2) * texels_per_post / parts;
                const double z = double(i / side - side / 2) * texels_per_post / parts;
                const auto x0 = static_cast<std::int32_t>(std::floor(x)), z0 = static_cast<std::int32_t>(std::floor(z));
                const auto h = [&](std::int32_t dx, std::int32_t dz) {
                    return scene.detail_at_m(x0 + dx, z0 + dz, texels_per_post, s);
                };
                const double u = x - x0, v = z - z0;
                const double height = u >= v ? (1 - u) * h(0, 0) + (u - v) * h(1, 0) + v * h(1, 1)
                                             : (1 - v) * h(0, 0) + (v - u) * h(0, 1) + u * h(1, 1);
                worst = std::max(worst, std::abs(double{points[static_cast<std::size_t>(i)]} - height));
            }
            // Of heights up to 0.5 m, a weight's rounding times their difference and four sums.
            EXPECT_LE(worst, 6 * std::ldexp(1.0, -24)) << texels_per_post << " texels a post, " << parts << " parts";
        }
    }
}

// SCIENCE 1.2: 16 texels a post; errors of the mesh against all texels.
TEST_F(GeometryGlTest, ConvergesAtTheRateOfTheShape) {
    struct Shape {
        const char* name;
        std::function<double(double)> profile;  ///< of the square of distance / radius
        std::array<double, 4> science_rms, science_max;
        std::array<double, 2> ratio;  ///< of rms from factor to factor
        bool max_converges;
    };
    const Shape shapes[] = {{"smooth",
                             [](double d2) { return std::exp(-2 * d2); },
                             {8.06, 2.71, 0.76, 0.19},
                             {126, 58, 22, 6},
                             {2.5, 4.4},
                             true},
                            {"kinked",
                             [](double d2) { return std::max(1 - d2, 0.0); },
                             {10.6, 4.3, 1.56, 0.54},
                             {108, 66, 32, 18},
                             {2.1, 3.3},
                             true},
                            {"stepped",
                             [](double d2) { return d2 < 1 ? 1.0 : 0.0; },
                             {22.7, 15.8, 11.2, 7.5},
                             {202, 194, 183, 120},
                             {1.25, 1.65},
                             false}};
    RefinementScene scene;
    scene.set_ground([](Texel post) { return 0.05 * post.x - 0.03 * post.z; });
    scene.set_presence(4, [](Texel) { return true; });
    const std::vector<std::vector<std::int32_t>> factors{{1}, {1, 2}, {1, 2, 4}, {1, 2, 4, 8}};
    std::printf("  rms / max mm          t = 1           2               4               8     (model in brackets)\n");
    for (const Shape& shape : shapes) {
        const std::vector<float> field = stamped_field(scene.size(), 5, shape.profile);
        scene.set_detail([&](Texel t) { return field[static_cast<std::size_t>(t.z * scene.size() + t.x)]; });
        std::array<MeshError, 4> errors{};
        std::printf("  %-8s", shape.name);
        for (std::size_t i = 0; i < 4; ++i) {
            errors[i] = error_of_mesh(scene, factors[i]);
            std::printf("  %.2f/%.0f (%.2f/%.0f)", errors[i].rms_m * 1e3, errors[i].max_m * 1e3, shape.science_rms[i],
                        shape.science_max[i]);
            // Other stamps at random places, some 250 in place of 400: a few times 1 / sqrt(250).
            EXPECT_NEAR(errors[i].rms_m * 1e3 / shape.science_rms[i], 1, 0.25) << shape.name << " by " << (1 << i);
        }
        std::printf("\n");
        for (std::size_t i = 0; i < 3; ++i) {
            const double ratio = errors[i].rms_m / errors[i + 1].rms_m;
            EXPECT_GT(ratio, shape.ratio[0]) << shape.name << " from " << (1 << i);
            EXPECT_LT(ratio, shape.ratio[1]) << shape.name << " from " << (1 << i);
        }
        if (shape.max_converges) {
            EXPECT_LT(errors[3].max_m, 0.25 * errors[0].max_m) << shape.name;
        } else {
            EXPECT_GT(errors[3].max_m, 0.5 * errors[0].max_m)
                << "a step of 120 mm is missed until every texel is there";
        }
    }
}

}  // namespace
}  // namespace tilth::test
