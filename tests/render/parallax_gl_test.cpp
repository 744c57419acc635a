// Parallax' tracers against a ray cast in double precision over the same triangles: error, cost, bounds, seams,
// shadows.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "render/support/relief_raycast.h"
#include "support/gl_context.h"
#include "tilth/gl/state_guard.h"
#include "tilth/gl/texel_pass.h"
#include "tilth/pool/relief_window.h"
#include "tilth/render/backends/backend_plan.h"

namespace tilth {
namespace {

using test::ReliefField;
using test::ReliefRay;
using test::Surface;

constexpr int kRaysWide = 80, kRaysHigh = 75, kRays = kRaysWide * kRaysHigh;

struct Range {
    float highest = 0, lowest = 0;
    friend bool operator==(const Range&, const Range&) = default;
};

/// (highest, lowest) of nodes of 2^(level + 1) cells, straight from the heights.
std::vector<Range> nodes_of(const ReliefField& field, int level) {
    const int cells = 2 << level, nodes = field.size / cells;
    std::vector<Range> ranges;
    for (int z = 0; z < nodes; ++z)
        for (int x = 0; x < nodes; ++x) {
            Range range{-std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
            for (int j = 0; j <= cells; ++j)
                for (int i = 0; i <= cells; ++i) {
                    const float h = field.heights[field.index(x * cells + i, z * cells + j)];
                    range = {std::max(range.highest, h), std::min(range.lowest, h)};
                }
            ranges.push_back(range);
        }
    return ranges;
}

/// Of 3 x 3 nodes of the coarsest level.
std::vector<Range> ranges_of(const ReliefField& field) {
    const std::vector<Range> nodes = nodes_of(field, ReliefWindow::kLevels - 1);
    const int side = field.size / ReliefWindow::kTopCells;
    std::vector<Range> ranges;
    for (int z = 0; z < side; ++z)
        for (int x = 0; x < side; ++x) {
            Range range = nodes[static_cast<std::size_t>(z * side + x)];
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i) {
                    const int at = (z + j + side) % side * side + (x + i + side) % side;
                    const Range& node = nodes[static_cast<std::size_t>(at)];
                    range = {std::max(range.highest, node.highest), std::min(range.lowest, node.lowest)};
                }
            ranges.push_back(range);
        }
    return ranges;
}

gl::Texture2D texture(gl::Device& device, const gl::TextureSpec& spec) {
    return test::value(gl::Texture2D::create(device, "test relief", spec));
}

/// A field in the textures of a relief window. Metres are heights / texels_per_m.
struct Relief {
    Relief(gl::Device& device, const ReliefField& field)
        : size(field.size),
          extremes{*std::max_element(field.heights.begin(), field.heights.end()),
                   *std::min_element(field.heights.begin(), field.heights.end())},
          heights(texture(device, {gl::Format::R32F, size, size, 1, gl::Filter::Linear, gl::Wrap::Repeat})),
          pyramid(texture(device, {gl::Format::Rg32F, size / 2, size / 2, ReliefWindow::kLevels,
                                   gl::Filter::NearestMipNearest, gl::Wrap::Repeat})),
          range(texture(device, {gl::Format::Rg32F, size / 64, size / 64, 1, gl::Filter::Linear, gl::Wrap::Repeat})) {
        heights.upload(0, heights.bounds(), field.heights.data());
        for (int level = 0; level < ReliefWindow::kLevels; ++level)
            pyramid.upload(level, pyramid.bounds(level), nodes_of(field, level).data());
        range.upload(0, range.bounds(), ranges_of(field).data());
    }
    void bind(gl::Program& program) const {
        int unit = 0;
        for (const auto& [name, map] : {std::pair{"u_relief_heights", &heights},
                                        std::pair{"u_relief_pyramid", &pyramid}, std::pair{"u_relief_range", &range}}) {
            map->bind(unit);
            program.sampler(name, unit++);
        }
        program.set(program.uniform("u_relief_size"), size);
    }
    int size;
    Range extremes;
    gl::Texture2D heights, pyramid, range;
};

struct Found {
    float x = 0, z = 0, height = 0, fetches = 0;  ///< or light
};

struct Search {
    double highest = 0, lowest = -test::kReliefDepth;
    int steps = 16;
    float share = 1, texels_per_m = 1;
    int shadow_steps = 0;
    float light_shift_x = 0, light_shift_z = 0;
};

class ParallaxTest : public test::GlTest {
protected:
    gl::TexelPass& pass(const std::string& fragment, const gl::Features& features) {
        std::string key = fragment;
        for (const auto& [name, setting] : features) key += " " + name + "=" + setting;
        const auto found = passes_.find(key);
        if (found != passes_.end()) return found->second;
        gl::ShaderLibrary library = shaders();
        return passes_
            .emplace(key, test::value(gl::TexelPass::create(device(), library, fragment,
                                                            "../tests/render/shaders/" + fragment, features)))
            .first->second;
    }

    /// Each ray's hit, by the method that the feature names.
    std::vector<Found> trace(const char* method, const Relief& relief, const std::vector<ReliefRay>& rays,
                             const Search& search = {}) {
        const gl::StateGuard guard(device());
        gl::Features features{{method, "1"}};
        if (search.shadow_steps > 0) features.emplace_back("LIGHT", "1");
        const int rows = static_cast<int>(rays.size()) / kRaysWide;
        EXPECT_EQ(static_cast<std::size_t>(rows * kRaysWide), rays.size());
        gl::Texture2D input = texture(device(), {gl::Format::Rgba32F, kRaysWide, rows});
        input.upload(0, input.bounds(), rays.data());
        const gl::Texture2D output = texture(device(), {gl::Format::Rgba32F, kRaysWide, rows});
        const gl::Texture2D* targets[] = {&output};
        const gl::PassRect whole[] = {{0, 0, kRaysWide, rows}};
        gl::StageStats stats;
        pass("trace_rays.frag", features).run(targets, 0, whole, stats, [&](gl::Program& program) {
            relief.bind(program);
            input.bind(3);
            program.sampler("u_rays", 3);
            program.set(program.uniform("u_relief_texels_per_m"), search.texels_per_m);
            program.set(program.uniform("u_parallax_steps"), search.steps);
            program.set(program.uniform("u_share"), search.share);
            program.set(program.uniform("u_highest"), static_cast<float>(search.highest));
            program.set(program.uniform("u_lowest"), static_cast<float>(search.lowest));
            program.set(program.uniform("u_parallax_shadow_steps"), search.shadow_steps);
            program.set(program.uniform("u_light_shift"), search.light_shift_x, search.light_shift_z);
        });
        std::vector<Found> found(rays.size());
        output.read(0, found.data());
        return found;
    }

private:
    std::map<std::string, gl::TexelPass> passes_;
};

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Spread over a field at one elevation, every azimuth.
std::vector<ReliefRay> rays_at(double elevation_deg, unsigned seed = 9, float size = 256) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    const double across = 1 / std::tan(radians(elevation_deg));
    std::vector<ReliefRay> rays(kRays);
    for (ReliefRay& ray : rays) {
        const double azimuth = 2 * std::numbers::pi * static_cast<double>(unit(random));
        ray.x = unit(random) * size;
        ray.z = unit(random) * size;
        ray.shift_x = static_cast<float>(across * std::cos(azimuth));
        ray.shift_z = static_cast<float>(across * std::sin(azimuth));
    }
    return rays;
}

struct Errors {
    double rms = 0, p99 = 0, wrong = 0, fetches = 0, most_fetches = 0, bilinear_rms = 0;
};

/// Texels along the ground between what was found and the first hit; wrong: more than one texel.
Errors errors_of(const ReliefField& field, const std::vector<ReliefRay>& rays, const std::vector<Found>& found,
                 const Search& search = {}) {
    Errors errors;
    std::vector<double> offsets;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto offset = [&](Surface surface) {
            const auto p = rays[i].on(test::raycast(field, rays[i], search.highest, search.lowest, surface));
            return std::hypot(static_cast<double>(found[i].x) - p[0], static_cast<double>(found[i].z) - p[1]);
        };
        offsets.push_back(offset(Surface::Split));
        errors.rms += offsets.back() * offsets.back();
        errors.bilinear_rms += std::pow(offset(Surface::Bilinear), 2);
        errors.wrong += offsets.back() > 1 ? 1 : 0;
        errors.fetches += static_cast<double>(found[i].fetches);
        errors.most_fetches = std::max(errors.most_fetches, static_cast<double>(found[i].fetches));
    }
    std::sort(offsets.begin(), offsets.end());
    const auto count = static_cast<double>(rays.size());
    errors.rms = std::sqrt(errors.rms / count);
    errors.bilinear_rms = std::sqrt(errors.bilinear_rms / count);
    errors.p99 = offsets[offsets.size() * 99 / 100];
    errors.wrong /= count;
    errors.fetches /= count;
    return errors;
}

/// The methods at one angle. The reference table's share of the first two: 256 x 256 texels, 6 000 rays an angle.
struct Angle {
    const char* field;
    double elevation_deg, iterative_rms, secant_rms;  ///< texels; a negative one is not in the table
};
constexpr Angle kAngles[] = {{"soft", 60, -1, -1},      {"soft", 30, 0.51, 0.006}, {"soft", 15, 2.72, 0.18},
                             {"soft", 8, 6.73, 0.74},   {"soft", 4, -1, -1},       {"sharp", 60, -1, -1},
                             {"sharp", 30, 1.87, 1.04}, {"sharp", 15, 5.50, 2.37}, {"sharp", 8, 12.4, 4.36},
                             {"sharp", 4, -1, -1}};

ReliefField field_called(const std::string& name) {
    return name == "sharp" ? test::sharp_treads() : test::soft_footprints();
}

/// Every hit of the exact method is the first one. Where rounding decides whether a ray that grazes a crest meets it,
/// the two may differ: then the crest must be no more than `graze` texels in the way. Returns how many such rays there
/// were.
int expect_exact(const ReliefField& field, const std::vector<ReliefRay>& rays, const std::vector<Found>& found,
                 const Search& search, double graze) {
    int grazing = 0, shown = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const double expected = test::raycast(field, rays[i], search.highest, search.lowest, Surface::Split);
        const auto p = rays[i].on(expected);
        const double below = -static_cast<double>(found[i].height);
        const double offset =
            std::hypot(static_cast<double>(found[i].x) - p[0], static_cast<double>(found[i].z) - p[1]);
        if (offset <= 1e-2) continue;
        ++grazing;
        const bool early = below < expected;
        const double depth = early ? test::over_surface(field, rays[i], below, Surface::Split)
                                   : test::deepest_between(field, rays[i], expected, below);
        if (std::abs(depth) <= graze || ++shown > 5) continue;
        ADD_FAILURE() << "ray " << i << " from (" << rays[i].x << ", " << rays[i].z << ") found at " << below
                      << " texels below the plane, first hit at " << expected << ": " << offset << " texels off, "
                      << (early ? "above the ground by " : "through the ground, deepest ") << depth;
    }
    EXPECT_LE(grazing, static_cast<int>(rays.size()) / 500);
    return grazing;
}

TEST_F(ParallaxTest, the_default_is_near_and_the_exact_method_is_exact) {
    for (const Angle& angle : kAngles) {
        SCOPED_TRACE(std::string(angle.field) + " at " + std::to_string(angle.elevation_deg) + " degrees");
        const ReliefField field = field_called(angle.field);
        const Relief relief(device(), field);
        const std::vector<ReliefRay> rays = rays_at(angle.elevation_deg);
        const auto row = [&](const char* method, const Search& search, const std::vector<Found>& found) {
            const Errors e = errors_of(field, rays, found, search);
            std::printf(
                "%-5s %2.0f deg  %-18s %3d  rms %8.4f  p99 %8.4f  over 1 texel %5.2f %%  fetches %5.2f, most %3.0f"
                "  (rms against bilinear %7.4f)\n",
                angle.field, angle.elevation_deg, method, search.steps, e.rms, e.p99, 100 * e.wrong, e.fetches,
                e.most_fetches, e.bilinear_rms);
            return e;
        };
        const Search four{.steps = 4};
        const Errors iterative = row("PARALLAX_ITERATIVE", four, trace("PARALLAX_ITERATIVE", relief, rays, four));
        EXPECT_EQ(iterative.fetches, 4);
        if (angle.iterative_rms > 0) {
            EXPECT_NEAR(iterative.rms, angle.iterative_rms, 0.1 * angle.iterative_rms);
        }

        double before = std::numeric_limits<double>::infinity();
        for (const int steps : {8, 16, 32, 64}) {
            const Search search{.steps = steps};
            const Errors secant = row("PARALLAX_SECANT", search, trace("PARALLAX_SECANT", relief, rays, search));
            EXPECT_LT(secant.rms, before) << "more steps, less error";
            EXPECT_LE(secant.most_fetches, steps + 1);
            before = secant.rms;
            if (steps != 16) continue;
            EXPECT_LT(secant.rms, iterative.rms);
            // The table is against the bilinear surface.
            if (angle.secant_rms > 0) {
                EXPECT_NEAR(secant.bilinear_rms, angle.secant_rms, 0.1 * angle.secant_rms);
            }
            if (std::string(angle.field) == "soft" && angle.elevation_deg == 15) {
                EXPECT_LE(secant.rms, 0.2);
                EXPECT_LE(secant.fetches, 4.2);
            }
        }
        const Search exactly;
        const std::vector<Found> found = trace("PARALLAX_EXACT", relief, rays, exactly);
        const Errors exact = row("PARALLAX_EXACT", exactly, found);
        const int grazing = expect_exact(field, rays, found, exactly, 1e-4);
        std::printf("          exact: %d rays decided by rounding\n", grazing);
        EXPECT_LE(exact.fetches, 17);
    }
}

TEST_F(ParallaxTest, a_share_of_relief_in_metres_is_traced_as_such) {
    // 32.5 texels a metre and half of the relief shown; search of a part of what there is.
    ReliefField field = test::soft_footprints(), shown = field;
    for (float& h : shown.heights) h = 0.5f * (h + 3);
    for (float& h : field.heights) h = (h + 3) / 32.5f;
    const Relief relief(device(), field);
    const std::vector<ReliefRay> rays = rays_at(15, 77);
    for (const Search& search :
         {Search{.highest = shown.highest(), .lowest = shown.lowest(), .share = 0.5f, .texels_per_m = 32.5f},
          Search{.highest = 0.5, .lowest = -1, .share = 0.5f, .texels_per_m = 32.5f}}) {
        ReliefField clamped = shown;
        for (float& h : clamped.heights)
            h = std::clamp(h, static_cast<float>(search.lowest), static_cast<float>(search.highest));
        // The first range takes all, so the surface is as it is; the second cuts it, between texels too, which the
        // exact method does where the ray is and the reference by the range of its search.
        expect_exact(shown, rays, trace("PARALLAX_EXACT", relief, rays, search), search, 1e-4);
        for (const char* method : {"PARALLAX_ITERATIVE", "PARALLAX_SECANT"})
            for (const Found& f : trace(method, relief, rays, search)) {
                EXPECT_LE(static_cast<double>(f.height), search.highest + 1e-4);
                EXPECT_GE(static_cast<double>(f.height), search.lowest - 1e-4);
            }
        EXPECT_LT(errors_of(clamped, rays, trace("PARALLAX_SECANT", relief, rays, search), search).rms, 0.1);
    }
}

constexpr const char* kMethods[] = {"PARALLAX_ITERATIVE", "PARALLAX_SECANT", "PARALLAX_EXACT"};

TEST_F(ParallaxTest, straight_down_stays_where_it_is) {
    const Relief relief(device(), test::sharp_treads());
    std::vector<ReliefRay> rays = rays_at(45);
    for (ReliefRay& ray : rays) ray.shift_x = ray.shift_z = 0;
    for (std::size_t i = 0; i < rays.size(); i += 2)
        rays[i].x = std::floor(rays[i].x), rays[i].z = std::floor(rays[i].z);
    for (const char* method : kMethods) {
        SCOPED_TRACE(method);
        const std::vector<Found> found = trace(method, relief, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(found[i].x, rays[i].x);
            ASSERT_EQ(found[i].z, rays[i].z);
        }
    }
    const ReliefField field = test::sharp_treads();
    for (const Found& f : trace("PARALLAX_EXACT", relief, rays))
        ASSERT_NEAR(static_cast<double>(f.height), field.split(static_cast<double>(f.x), static_cast<double>(f.z)),
                    1e-4);
}

TEST_F(ParallaxTest, untouched_ground_is_not_moved_at_all) {
    const Relief relief(device(), ReliefField(256, 0));
    for (const double elevation : {60., 4., 0.1}) {
        const std::vector<ReliefRay> rays = rays_at(elevation);
        for (const char* method : kMethods)
            for (const double lowest : {0.0, -test::kReliefDepth}) {
                SCOPED_TRACE(method);
                const std::vector<Found> found = trace(method, relief, rays, {.lowest = lowest});
                for (std::size_t i = 0; i < rays.size(); ++i) {
                    ASSERT_EQ(found[i].x, rays[i].x);
                    ASSERT_EQ(found[i].z, rays[i].z);
                    ASSERT_EQ(found[i].height, 0);
                    if (lowest == 0) {
                        ASSERT_EQ(found[i].fetches, 0) << "there is nothing to search";
                    }
                }
            }
    }
}

TEST_F(ParallaxTest, iterations_leave_what_the_law_says_over_a_flat_floor) {
    const Relief relief(device(), ReliefField(256, -static_cast<float>(test::kReliefDepth)));
    for (const double elevation : {60., 30., 15., 8., 4.})
        for (const int steps : {1, 2, 4, 8}) {
            const std::vector<ReliefRay> rays = rays_at(elevation);
            const double all = test::kReliefDepth / std::tan(radians(elevation));
            const double left = std::pow(1 - std::sin(radians(elevation)), steps);
            const std::vector<Found> found = trace("PARALLAX_ITERATIVE", relief, rays, {.steps = steps});
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const double moved = std::hypot(static_cast<double>(found[i].x - rays[i].x),
                                                static_cast<double>(found[i].z - rays[i].z));
                ASSERT_NEAR(1 - moved / all, left, 0.01 * left + 1e-4) << elevation << " degrees, " << steps;
            }
        }
}

TEST_F(ParallaxTest, grazing_rays_are_finite_and_bounded) {
    for (const char* name : {"soft", "sharp"}) {
        const ReliefField field = field_called(name);
        const Relief relief(device(), field);
        for (const double elevation : {0.001, 0.1, 0.5, 1., 2., 4.}) {
            const std::vector<ReliefRay> rays = rays_at(elevation);
            for (const char* method : kMethods) {
                SCOPED_TRACE(std::string(name) + " " + method + " at " + std::to_string(elevation));
                const std::vector<Found> found = trace(method, relief, rays);
                const double farthest = test::kReliefDepth / std::tan(radians(elevation));
                double most = 0, mean = 0;
                for (std::size_t i = 0; i < rays.size(); ++i) {
                    const Found& f = found[i];
                    ASSERT_TRUE(std::isfinite(f.x) && std::isfinite(f.z) && std::isfinite(f.height)) << i;
                    const double moved =
                        std::hypot(static_cast<double>(f.x - rays[i].x), static_cast<double>(f.z - rays[i].z));
                    ASSERT_LE(moved, farthest * (1 + 1e-5) + 1e-3) << i;
                    most = std::max(most, static_cast<double>(f.fetches));
                    mean += static_cast<double>(f.fetches) / kRays;
                }
                std::printf("%-5s %5.3f deg  %-18s fetches %6.2f, most %4.0f\n", name, elevation, method, mean, most);
                const std::string exact = "PARALLAX_EXACT";
                // 4096 is the tracer's guard, which takes a ray of hundreds of turns around the window.
                EXPECT_LE(most, method != exact ? 17 : elevation >= 0.1 ? 512 : 4096);
                // At a thousandth of a degree a float of the way is half a texel.
                if (method == exact && elevation >= 0.1) expect_exact(field, rays, found, {}, 2e-3);
            }
        }
    }
}

TEST_F(ParallaxTest, rays_cross_the_border_of_the_window_like_any_other_place) {
    const ReliefField field = test::soft_footprints();
    ReliefField moved(field.size, 0);
    for (int z = 0; z < 256; ++z)
        for (int x = 0; x < 256; ++x) moved.at(x + 128, z + 96) = field.heights[field.index(x, z)];
    const Relief relief(device(), field), moved_relief(device(), moved);
    // About the corner of the window: from the last texels of one side to the first of the other, and beyond both.
    std::vector<ReliefRay> rays = rays_at(30, 3, 16), others;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        rays[i].x += i % 3 == 0 ? -8.0f : 248.0f;
        rays[i].z += i % 2 == 0 ? -8.0f : 248.0f;
        others.push_back({rays[i].x + (i % 3 == 0 ? 128.0f : -128.0f), rays[i].z + (i % 2 == 0 ? 96.0f : -160.0f),
                          rays[i].shift_x, rays[i].shift_z});
    }
    for (const char* method : kMethods) {
        SCOPED_TRACE(method);
        const std::vector<Found> here = trace(method, relief, rays), there = trace(method, moved_relief, others);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_NEAR(here[i].x - rays[i].x, there[i].x - others[i].x, 2e-3f) << i;
            ASSERT_NEAR(here[i].z - rays[i].z, there[i].z - others[i].z, 2e-3f) << i;
            ASSERT_NEAR(here[i].height, there[i].height, 1e-3f) << i;
        }
    }
    expect_exact(field, rays, trace("PARALLAX_EXACT", relief, rays), {}, 1e-4);
}

/// Light at a point of the ground, in double precision: the same steps over the bilinear surface.
double light_reference(const ReliefField& field, const Found& at, const Search& search, int steps) {
    double worst = 0;
    const double height = static_cast<double>(at.height), shift_x = static_cast<double>(search.light_shift_x),
                 shift_z = static_cast<double>(search.light_shift_z);
    const double room = search.highest - height, way = std::sqrt(1 + shift_x * shift_x + shift_z * shift_z);
    for (int i = 1; i <= steps && room > 0; ++i) {
        const double up = room * i / steps;
        const double over =
            field.bilinear(static_cast<double>(at.x) + shift_x * up, static_cast<double>(at.z) + shift_z * up) -
            height - up;
        worst = std::max(worst, over / (way * up));
    }
    return std::clamp(1 - worst / 0.1, 0.0, 1.0);
}

TEST_F(ParallaxTest, shadows_fall_behind_a_wall_and_nowhere_else) {
    // A wall of height 4 along z, upright from x = 128 to 160 but for the cells at its foot.
    ReliefField field(256, 0);
    for (int z = 0; z < 256; ++z)
        for (int x = 128; x <= 160; ++x) field.at(x, z) = 4;
    const Relief relief(device(), field);
    std::vector<ReliefRay> down = rays_at(45);
    for (ReliefRay& ray : down) ray.shift_x = ray.shift_z = 0;
    Search search{.highest = 4, .lowest = -1, .steps = 64, .shadow_steps = 64};
    search.light_shift_x = static_cast<float>(1 / std::tan(radians(30)));  // the sun stands over +x
    const std::vector<Found> found = trace("PARALLAX_SECANT", relief, down, search);
    int dark = 0;
    for (const Found& f : found) {
        ASSERT_NEAR(static_cast<double>(f.fetches), light_reference(field, f, search, 64), 2e-3);
        const double before_wall = 128 - static_cast<double>(f.x), shade = 4 / std::tan(radians(30));
        // Full shade is where the wall stands a tenth over the way: 4 - up >= 0.1 * 2 up. Steps are 1/64 of the height.
        if (before_wall > 1 && before_wall < shade * (1 / 1.2 - 1.0 / 64)) {
            ASSERT_EQ(f.fetches, 0) << f.x;
            ++dark;
        } else if (before_wall > shade + 1 || before_wall < -33.1 || (before_wall < -0.5 && before_wall > -31.9)) {
            ASSERT_EQ(f.fetches, 1) << f.x;  // before the shade, behind the wall on the sun's side, on its top
        }
    }
    EXPECT_GT(dark, 80);

    search.light_shift_x = 0;  // in the zenith
    for (const Found& f : trace("PARALLAX_SECANT", relief, down, search)) ASSERT_EQ(f.fetches, 1);

    const ReliefField flat(256, -3);
    const Relief flat_relief(device(), flat);
    search.light_shift_x = 500;
    search.highest = 0, search.lowest = -test::kReliefDepth;
    for (const char* method : {"PARALLAX_SECANT", "PARALLAX_EXACT"})
        for (const Found& f : trace(method, flat_relief, rays_at(15), search)) ASSERT_EQ(f.fetches, 1);
}

TEST_F(ParallaxTest, what_has_a_free_way_to_the_light_is_lit_whole) {
    const ReliefField field = test::soft_footprints();
    const Relief relief(device(), field);
    std::vector<ReliefRay> down = rays_at(45);
    for (ReliefRay& ray : down) ray.shift_x = ray.shift_z = 0;
    Search search{.steps = 64, .shadow_steps = 16, .light_shift_x = 4, .light_shift_z = -3};
    int shaded = 0, lit = 0;
    for (const Found& f : trace("PARALLAX_SECANT", relief, down, search)) {
        ASSERT_NEAR(static_cast<double>(f.fetches), light_reference(field, f, search, 16), 2e-3);
        // The way to the light is a ray the other way round.
        double worst = 0;
        const double height = static_cast<double>(f.height);
        for (double up = 1.0 / 32; up < -height; up += 1.0 / 32)
            worst =
                std::max(worst, field.bilinear(static_cast<double>(f.x) + 4 * up, static_cast<double>(f.z) - 3 * up) -
                                    height - up);
        if (worst < 1e-6) {
            ASSERT_GE(f.fetches, 1 - 1e-4f);
            ++lit;
        }
        if (f.fetches < 0.5f) ++shaded;
    }
    EXPECT_GT(lit, 1000);
    EXPECT_GT(shaded, 200);
}

// --- A fragment: render/parallax/parallax.glsl ----------------------------------------------------------------------

struct Fragment {
    float x = 0, y = 0, z = 0, unused = 0;
};
struct Told {
    float highest_m = 0, lowest_m = 0, light = 0, error_texels = 0;
};
struct Shown {
    std::vector<Found> found;  ///< x, y, z, fetches or depth
    std::vector<Told> told;
};
struct Scene {
    float texels_per_m = 32, slope_x = 0, slope_z = 0, fraction_x = 0, fraction_z = 0, least_tangent = 0.035f;
    int base_x = 0, base_z = 0;
    std::array<float, 4> fade_m{-2, -1, 500, 600};
    std::array<float, 2> range_m{0, 0};
    std::array<float, 16> clip{};  ///< column-major
    std::array<float, 3> to_light{0, 1, 0};
    int shadow_steps = 0, steps = 16;
};

class ParallaxPixelTest : public ParallaxTest {
protected:
    Shown show(const gl::Features& features, const Relief& relief, const std::vector<Fragment>& fragments,
               const Scene& scene) {
        const gl::StateGuard guard(device());
        const int rows = static_cast<int>(fragments.size()) / kRaysWide;
        gl::Texture2D input = texture(device(), {gl::Format::Rgba32F, kRaysWide, rows});
        input.upload(0, input.bounds(), fragments.data());
        const gl::Texture2D shown = texture(device(), {gl::Format::Rgba32F, kRaysWide, rows});
        const gl::Texture2D told = texture(device(), {gl::Format::Rgba32F, kRaysWide, rows});
        const gl::Texture2D* targets[] = {&shown, &told};
        const gl::PassRect whole[] = {{0, 0, kRaysWide, rows}};
        gl::StageStats stats;
        pass("trace_pixels.frag", features).run(targets, 0, whole, stats, [&](gl::Program& program) {
            relief.bind(program);
            input.bind(3);
            program.sampler("u_fragments", 3);
            program.set(program.uniform("u_relief_texels_per_m"), scene.texels_per_m);
            program.set(program.uniform("u_relief_base_texel"), scene.base_x, scene.base_z);
            program.set(program.uniform("u_relief_fade_m"), scene.fade_m[0], scene.fade_m[1], scene.fade_m[2],
                        scene.fade_m[3]);
            program.set(program.uniform("u_parallax_steps"), scene.steps);
            program.set(program.uniform("u_parallax_shadow_steps"), scene.shadow_steps);
            program.set(program.uniform("u_parallax_least_tangent"), scene.least_tangent);
            program.set(program.uniform("u_parallax_range_m"), scene.range_m[0], scene.range_m[1]);
            program.set(program.uniform("u_relief_extremes_m"), relief.extremes.highest, relief.extremes.lowest);
            program.set(program.uniform("u_to_light"), scene.to_light[0], scene.to_light[1], scene.to_light[2]);
            program.set(program.uniform("u_coarse_slope"), scene.slope_x, scene.slope_z);
            program.set(program.uniform("u_fraction_m"), scene.fraction_x, scene.fraction_z);
            program.set_mat4(program.uniform("u_clip_from_relative"), scene.clip.data());
        });
        Shown result;
        result.found.resize(fragments.size());
        result.told.resize(fragments.size());
        shown.read(0, result.found.data());
        told.read(0, result.told.data());
        return result;
    }

    /// Of the plane `above` metres under the eye, as far as `reach_m`.
    static std::vector<Fragment> ground(const Scene& scene, float above, float reach_m) {
        std::mt19937 random(21);
        std::uniform_real_distribution<float> unit(-1, 1);
        std::vector<Fragment> fragments(kRays);
        for (Fragment& f : fragments) {
            f.x = reach_m * unit(random);
            f.z = reach_m * unit(random);
            f.y = scene.slope_x * f.x + scene.slope_z * f.z - above;
        }
        return fragments;
    }
};

ReliefField in_metres(ReliefField field, float texels_per_m) {
    for (float& h : field.heights) h /= texels_per_m;
    return field;
}

TEST_F(ParallaxPixelTest, shows_what_is_on_the_line_of_sight) {
    const ReliefField field = test::soft_footprints();
    const Relief relief(device(), in_metres(field, 32));
    Scene scene;
    scene.slope_x = 0.2f, scene.slope_z = -0.1f, scene.fraction_x = 0.4f, scene.fraction_z = 0.9f;
    scene.base_x = 201, scene.base_z = 17;
    const std::vector<Fragment> fragments = ground(scene, 1.7f, 5);
    const gl::Features features{{"PARALLAX_EXACT", "1"}, {"PARALLAX_RANGE", "1"}, {"DEBUG_VIEW", "1"}};
    scene.range_m = {0, static_cast<float>(-test::kReliefDepth) / 32};
    const Shown shown = show(features, relief, fragments, scene);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const Fragment& f = fragments[i];
        const Found& p = shown.found[i];  // height is y, z is z of GL's third component: x, y, z
        const double x = static_cast<double>(p.x), y = static_cast<double>(p.z), z = static_cast<double>(p.height);
        // The eye, the fragment and what it shows are in line.
        const double t = x * static_cast<double>(f.x) + y * static_cast<double>(f.y) + z * static_cast<double>(f.z);
        const double s =
            t / (static_cast<double>(f.x * f.x) + static_cast<double>(f.y * f.y) + static_cast<double>(f.z * f.z));
        ASSERT_NEAR(x, s * static_cast<double>(f.x), 2e-5);
        ASSERT_NEAR(y, s * static_cast<double>(f.y), 2e-5);
        ASSERT_NEAR(z, s * static_cast<double>(f.z), 2e-5);
        // It is the first place of that line that is on the ground.
        const ReliefRay ray{(f.x + 0.4f) * 32 + 201, (f.z + 0.9f) * 32 + 17, f.x / 1.7f, f.z / 1.7f};
        const double below = test::raycast(field, ray, 0, -test::kReliefDepth, Surface::Split);
        ASSERT_NEAR(s, 1 + below / 32 / 1.7, 2e-3 / 32 / 1.7) << i;
        ASSERT_EQ(shown.told[i].error_texels, 0);
    }
}

TEST_F(ParallaxPixelTest, the_error_told_is_the_distance_to_the_exact_hit) {
    const Relief relief(device(), in_metres(test::sharp_treads(), 32));
    Scene scene;
    scene.range_m = {0, static_cast<float>(-test::kReliefDepth) / 32};
    const std::vector<Fragment> fragments = ground(scene, 1.7f, 5);
    const Shown exact = show({{"PARALLAX_EXACT", "1"}, {"PARALLAX_RANGE", "1"}}, relief, fragments, scene);
    const Shown secant =
        show({{"PARALLAX_SECANT", "1"}, {"PARALLAX_RANGE", "1"}, {"DEBUG_VIEW", "1"}}, relief, fragments, scene);
    int wrong = 0;
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const float expected =
            32 * std::hypot(exact.found[i].x - secant.found[i].x, exact.found[i].height - secant.found[i].height);
        ASSERT_NEAR(secant.told[i].error_texels, expected, 2e-3f);
        if (expected > 0.1f) ++wrong;
    }
    EXPECT_GT(wrong, 50);
}

TEST_F(ParallaxPixelTest, searches_what_the_nodes_about_it_hold) {
    // One bowl and one heap, each within one node of 64 cells.
    ReliefField field(1024, 0);
    test::add_print(field, 480, 480, 20, [](float d) { return d < 20 ? -5 + d / 4 : 0.0f; });
    test::add_print(field, 800, 224, 10, [](float d) { return d < 10 ? 2 - d / 5 : 0.0f; });
    const Relief relief(device(), in_metres(field, 32));
    const std::vector<Range> ranges = ranges_of(field);
    const Scene scene;
    std::vector<Fragment> fragments;
    std::mt19937 random(4);
    std::uniform_real_distribution<float> unit(0, 1024);
    for (int i = 0; i < kRays; ++i) fragments.push_back({unit(random) / 32, -1, unit(random) / 32});
    for (std::size_t i = 0; i < 256; ++i)  // the middles of all nodes
        fragments[i] = {2 * static_cast<float>(i % 16) + 1, -1, 2 * static_cast<float>(i / 16) + 1};
    const Shown shown = show({{"PARALLAX_SECANT", "1"}}, relief, fragments, scene);
    for (std::size_t i = 0; i < 256; ++i) {
        ASSERT_NEAR(shown.told[i].highest_m * 32, ranges[i].highest, 1e-5) << i;
        ASSERT_NEAR(shown.told[i].lowest_m * 32, ranges[i].lowest, 1e-5) << i;
    }
    int moved = 0;
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        // Linear between the middles; and never less than what is within 32 texels.
        const float x = fragments[i].x * 32, z = fragments[i].z * 32;
        const float u = (x - 32) / 64, v = (z - 32) / 64, a = u - std::floor(u), b = v - std::floor(v);
        const auto range = [&](int di, int dj) {
            const int k = (static_cast<int>(std::floor(u)) + di + 16) % 16,
                      l = (static_cast<int>(std::floor(v)) + dj + 16) % 16;
            return ranges[static_cast<std::size_t>(l * 16 + k)];
        };
        const float low = (1 - b) * ((1 - a) * range(0, 0).lowest + a * range(1, 0).lowest) +
                          b * ((1 - a) * range(0, 1).lowest + a * range(1, 1).lowest);
        ASSERT_NEAR(shown.told[i].lowest_m * 32, low, 0.03f) << x << " " << z;
        float within = 0;
        for (int dz = -31; dz <= 31; dz += 2)
            for (int dx = -31; dx <= 31; dx += 2)
                within = std::min(within, static_cast<float>(field.at(static_cast<int>(std::lround(x)) + dx,
                                                                      static_cast<int>(std::lround(z)) + dz)));
        if (i % 10 == 0) {
            ASSERT_LE(shown.told[i].lowest_m * 32, within + 1e-4f);
        }
        // Where its ray is flat enough to meet what is farther off, that is searched too.
        const float beyond_m = -fragments[i].y / std::hypot(fragments[i].x, fragments[i].z);  // 32 texels off
        const bool near_alone = relief.extremes.highest <= beyond_m;
        if (shown.told[i].lowest_m == 0 && shown.told[i].highest_m == 0 && near_alone) {
            ASSERT_EQ(shown.found[i].fetches, 0);
            ASSERT_EQ(shown.found[i].x, fragments[i].x);
            ASSERT_EQ(shown.found[i].z, fragments[i].y);
        } else {
            ++moved;
        }
    }
    EXPECT_GT(moved, 200);
}

TEST_F(ParallaxPixelTest, no_pixel_moves_by_more_than_depth_over_the_least_tangent) {
    const float depth_m = static_cast<float>(test::kReliefDepth) / 32;
    const Relief relief(device(), in_metres(test::soft_footprints(), 32));
    for (const char* method : kMethods)
        for (const float above : {2.0f, 0.05f, 0.0f, -0.5f})
            for (const float tangent : {0.035f, 0.2f, 0.0f}) {
                SCOPED_TRACE(std::string(method) + " eye " + std::to_string(above) + " m over the ground, limit " +
                             std::to_string(tangent));
                Scene scene;
                scene.slope_x = 0.3f;
                scene.least_tangent = tangent;
                scene.range_m = {0, -depth_m};
                std::vector<Fragment> fragments = ground(scene, above, 40);
                fragments[0] = {0, -above, 0};  // straight below
                const Shown shown = show({{method, "1"}, {"PARALLAX_RANGE", "1"}}, relief, fragments, scene);
                double most = 0;
                for (std::size_t i = 0; i < fragments.size(); ++i) {
                    const Found& f = shown.found[i];
                    ASSERT_TRUE(std::isfinite(f.x) && std::isfinite(f.z) && std::isfinite(f.height)) << i;
                    most = std::max(most,
                                    static_cast<double>(std::hypot(f.x - fragments[i].x, f.height - fragments[i].z)));
                    ASSERT_LE(f.fetches, 4096);
                }
                if (tangent > 0) {
                    EXPECT_LE(most, static_cast<double>(depth_m / tangent) * (1 + 1e-4));
                }
                // It is the limit that holds them back: most rays are flatter than that.
                if (tangent == 0 && above <= 0.05f && method != kMethods[0]) {
                    EXPECT_GT(most, static_cast<double>(depth_m) / 0.035);
                }
            }
}

TEST_F(ParallaxPixelTest, nothing_behind_the_eye_is_shown) {
    // Heaps higher than the eye, 0.3 m over the coarse ground.
    ReliefField field = test::soft_footprints();
    for (float& h : field.heights) h += static_cast<float>(test::kReliefDepth);
    const Relief relief(device(), in_metres(field, 8));
    Scene scene;
    scene.texels_per_m = 8;
    for (const char* method : kMethods) {
        const std::vector<Fragment> fragments = ground(scene, 0.3f, 8);
        const Shown shown = show({{method, "1"}}, relief, fragments, scene);
        int nearer = 0;
        for (std::size_t i = 0; i < fragments.size(); ++i) {
            const Fragment& f = fragments[i];
            const Found& p = shown.found[i];
            ASSERT_GE(p.x * f.x + p.z * f.y + p.height * f.z, -1e-3f);
            if (p.z > f.y + 0.01f) ++nearer;
        }
        EXPECT_GT(nearer, 1000) << "what is searched does stand above the ground";
    }
}

TEST_F(ParallaxPixelTest, shows_its_share_of_the_relief) {
    // Whole up to 2 m, gone from 4 m on.
    const ReliefField flat(256, -0.1f);
    const Relief relief(device(), flat);
    Scene scene;
    scene.fade_m = {-2, -1, 2, 4};
    const std::vector<Fragment> fragments = ground(scene, 1, 6);
    const Shown shown = show({{"PARALLAX_EXACT", "1"}}, relief, fragments, scene);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const Fragment& f = fragments[i];
        const double distance =
            std::hypot(static_cast<double>(f.x), static_cast<double>(f.y), static_cast<double>(f.z));
        const double t = std::clamp((4 - distance) / 2, 0.0, 1.0), share = t * t * (3 - 2 * t);
        ASSERT_NEAR(static_cast<double>(shown.found[i].z), -1 - 0.1 * share, 1e-4);
        if (share == 0) {
            ASSERT_EQ(shown.found[i].fetches, 0);
        }
    }
}

TEST_F(ParallaxPixelTest, light_comes_from_where_the_sun_is) {
    // The wall of the shadow test on a slope that the sun stands 30 degrees over, and a sun below the ground.
    ReliefField field(256, 0);
    for (int z = 0; z < 256; ++z)
        for (int x = 128; x <= 160; ++x) field.at(x, z) = 4;
    const Relief relief(device(), in_metres(field, 32));
    Scene scene;
    scene.slope_x = 0.25f, scene.base_x = 120, scene.base_z = 128, scene.shadow_steps = 64;
    scene.range_m = {4.0f / 32, 0};
    scene.steps = 64;
    const double rise = std::tan(radians(30)), across = 1 / std::hypot(1.0, rise + 0.25);
    scene.to_light = {static_cast<float>(across), static_cast<float>(across * (rise + 0.25)), 0};
    const std::vector<Fragment> fragments = ground(scene, 30, 2);  // from far above: hardly any parallax
    const gl::Features features{{"PARALLAX_SECANT", "1"}, {"PARALLAX_RANGE", "1"}, {"PARALLAX_SHADOWS", "1"}};
    const Shown shown = show(features, relief, fragments, scene);
    int dark = 0;
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const double x = 120 + 32 * static_cast<double>(shown.found[i].x), before_wall = 128 - x;
        const double shade = 4 / rise;
        if (x < 60 || x > 250) continue;
        if (before_wall > 1.2 && before_wall < shade * (1 / 1.2 - 1.0 / 64) - 0.1) {
            ASSERT_EQ(shown.told[i].light, 0) << x;
            ++dark;
        } else if (before_wall > shade + 1.1 || before_wall < -33.2) {
            ASSERT_EQ(shown.told[i].light, 1) << x;
        }
    }
    EXPECT_GT(dark, 50);
    scene.to_light = {1, 0, 0};
    for (const Told& told : show(features, relief, fragments, scene).told)
        ASSERT_TRUE(told.light >= 0 && told.light <= 1);
}

TEST_F(ParallaxPixelTest, depth_is_that_of_the_position) {
    const Relief relief(device(), in_metres(test::soft_footprints(), 32));
    Scene scene;
    scene.range_m = {0, static_cast<float>(-test::kReliefDepth) / 32};
    std::vector<Fragment> fragments = ground(scene, 1.7f, 5);
    for (Fragment& f : fragments) f.z = -std::abs(f.z) - 1;  // before the eye, which looks along -z
    const gl::Features traced{{"PARALLAX_EXACT", "1"}, {"PARALLAX_RANGE", "1"}};
    const auto with = [&](std::initializer_list<const char*> more) {
        gl::Features features = traced;
        for (const char* name : more) features.emplace_back(name, "1");
        return show(features, relief, fragments, scene).found;
    };
    const double near_m = 0.5, far_m = 40;
    scene.clip = {1,
                  0,
                  0,
                  0,
                  0,
                  1,
                  0,
                  0,
                  0,
                  0,
                  static_cast<float>(-(far_m + near_m) / (far_m - near_m)),
                  -1,
                  0,
                  0,
                  static_cast<float>(-2 * far_m * near_m / (far_m - near_m)),
                  0};
    const std::vector<Found> places = show(traced, relief, fragments, scene).found;
    const std::vector<Found> standard = with({"PARALLAX_DEPTH"});
    const std::vector<Found> behind = with({"PARALLAX_DEPTH", "DEPTH_ONE_SIDED"});
    scene.clip[10] = 0, scene.clip[14] = static_cast<float>(near_m);
    const std::vector<Found> reversed = with({"PARALLAX_DEPTH", "REVERSED_DEPTH"});
    const std::vector<Found> reversed_behind = with({"PARALLAX_DEPTH", "REVERSED_DEPTH", "DEPTH_ONE_SIDED"});
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const double ahead = -static_cast<double>(places[i].height);
        const double expected = far_m / (far_m - near_m) * (1 - near_m / ahead);
        ASSERT_NEAR(static_cast<double>(standard[i].fetches), expected, 2e-6);
        ASSERT_NEAR(static_cast<double>(reversed[i].fetches), near_m / ahead, 2e-6);
        // The fragments of this pass have depth 0.5.
        ASSERT_EQ(behind[i].fetches, std::max(standard[i].fetches, 0.5f));
        ASSERT_EQ(reversed_behind[i].fetches, std::min(reversed[i].fetches, 0.5f));
    }
}

TEST_F(ParallaxTest, every_set_of_options_is_a_program_of_the_ground) {
    gl::ShaderLibrary library = shaders();
    DetailSettings settings;
    for (const ParallaxMethod method : {ParallaxMethod::Iterative, ParallaxMethod::Secant, ParallaxMethod::Exact})
        for (const bool range : {false, true})
            for (const bool depth : {false, true})
                for (const bool debug : {false, true}) {
                    settings.parallax.method = method;
                    settings.parallax.depth = depth;
                    settings.parallax.shadow_steps = debug ? 0 : 8;
                    settings.parallax.range.reset();
                    if (range) settings.parallax.range = ParallaxSettings::Range{-0.2, 0};
                    gl::Features features =
                        parallax_features({.settings = settings, .reach_m = 30, .reversed_depth = debug});
                    features.insert(features.end(), {{"DETAIL", "1"}, {"RELIEF", "1"}});
                    if (debug) features.emplace_back("DEBUG_VIEW", "1");
                    const auto program =
                        library.program("test parallax", "render/terrain.vert", "render/terrain.frag", features);
                    EXPECT_TRUE(program.ok()) << program.error().message;
                }
}

// --- The plan -------------------------------------------------------------------------------------------------------

std::string names_of(const gl::Features& features) {
    std::string names;
    for (const auto& [name, setting] : features) names += name + " ";
    return names;
}

TEST(ParallaxPlan, features_follow_the_settings) {
    DetailSettings settings;
    const auto features = [&](bool reversed) {
        return names_of(parallax_features({.settings = settings, .reach_m = 30, .reversed_depth = reversed}));
    };
    EXPECT_EQ(features(false), "PARALLAX PARALLAX_SECANT ");
    settings.parallax.method = ParallaxMethod::Exact;
    settings.parallax.shadow_steps = 8;
    EXPECT_EQ(features(true), "PARALLAX PARALLAX_EXACT PARALLAX_SHADOWS ");
    settings.parallax.method = ParallaxMethod::Iterative;
    settings.parallax.shadow_steps = 0;
    settings.parallax.range = {-0.2, 0.0};
    EXPECT_EQ(features(false), "PARALLAX PARALLAX_ITERATIVE PARALLAX_RANGE ");
    settings.parallax.depth = true;
    EXPECT_EQ(features(false), "PARALLAX PARALLAX_ITERATIVE PARALLAX_RANGE PARALLAX_DEPTH DEPTH_ONE_SIDED ");
    EXPECT_EQ(features(true),
              "PARALLAX PARALLAX_ITERATIVE PARALLAX_RANGE PARALLAX_DEPTH REVERSED_DEPTH DEPTH_ONE_SIDED ");
    settings.parallax.range = {-0.2, 0.01};
    EXPECT_EQ(features(false), "PARALLAX PARALLAX_ITERATIVE PARALLAX_RANGE PARALLAX_DEPTH ");
}

TEST(ParallaxPlan, one_recipe_traces_all_there_is) {
    DetailSettings settings;
    settings.backend = DetailBackend::Parallax;
    const BackendPlan plan = plan_parallax({.settings = settings, .reach_m = 40});
    ASSERT_EQ(plan.recipes.size(), 1u);
    EXPECT_EQ(names_of(plan.recipes[0].features), names_of(parallax_features({.settings = settings, .reach_m = 40})));
    EXPECT_FALSE(plan.recipes[0].patches);
    EXPECT_FALSE(plan.recipes[0].displaces);
    EXPECT_TRUE(plan.recipes[0].stages.geometry.empty() && plan.recipes[0].stages.tess_evaluation.empty());
    for (const double nearest : {0.0, 3.0, 39.0}) EXPECT_EQ(plan.recipe_of(nearest, nearest + 30), 0u);
    EXPECT_LT(plan.displaced.to_m, 0) << "the mesh shows none of it at any distance";
    EXPECT_FLOAT_EQ(plan.all.from_m, 30);
    EXPECT_FLOAT_EQ(plan.all.to_m, 40);
}

}  // namespace
}  // namespace tilth
