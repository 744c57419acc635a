#include "tilth/render/detail_settings.h"

#include <cmath>
#include <numbers>

namespace tilth {
namespace {

Error out_of_range(std::string_view field, double value, std::string_view allowed) {
    return {ErrorCode::InvalidArgument, text("detail.", field, " is ", value, "; allowed are ", allowed)};
}

bool is_within(double value, double least, double most) { return value >= least && value <= most; }  // false for NaN

/// A number that names none of an enumeration's values, the last of which is `last`.
template <class Value>
Result<void> check_named(std::string_view field, Value value, Value last) {
    if (value <= last) return {};
    return Error{ErrorCode::InvalidArgument, text("detail.", field, " is ", static_cast<int>(value),
                                                  ", which names nothing; allowed are 0 to ", static_cast<int>(last))};
}

Result<void> check(const ParallaxSettings& p) {
    constexpr double degree = std::numbers::pi / 180;
    if (const Result<void> named = check_named("parallax.method", p.method, ParallaxMethod::Exact); !named)
        return named;
    if (!is_within(p.steps, 1, 256)) return out_of_range("parallax.steps", p.steps, "1 to 256");
    if (!is_within(p.shadow_steps, 0, 64)) return out_of_range("parallax.shadow_steps", p.shadow_steps, "0 to 64");
    if (!is_within(p.least_elevation_rad, 0.0999 * degree, 45.001 * degree))
        return out_of_range("parallax.least_elevation_rad", p.least_elevation_rad, "0.1 to 45 degrees, in radians");
    if (p.range) {
        if (!is_within(p.range->lowest_m, -8, 0))
            return out_of_range("parallax.range.lowest_m", p.range->lowest_m, "-8 to 0 metres");
        if (!is_within(p.range->highest_m, 0, 8))
            return out_of_range("parallax.range.highest_m", p.range->highest_m, "0 to 8 metres");
    }
    return {};
}

}  // namespace

DetailSettings detail_preset(DetailBackend backend, DetailPreset preset) {
    DetailSettings made{.backend = backend};
    ParallaxSettings& parallax = made.parallax;
    switch (preset) {
        case DetailPreset::Low:
            parallax = {.method = ParallaxMethod::Iterative, .steps = 4};
            made.refinement.edge_px = 8;
            made.reach = 0.6;
            break;
        case DetailPreset::Medium:
            break;
        case DetailPreset::High:
            parallax.steps = 32;
            parallax.depth = true;
            parallax.shadow_steps = 8;
            made.refinement.edge_px = 2;
            made.tessellated = 0.5;
            break;
        case DetailPreset::Exact:
            parallax.method = ParallaxMethod::Exact;
            parallax.least_elevation_rad = 1.0 * std::numbers::pi / 180;
            parallax.depth = true;
            made.refinement = {.most_factor = 64, .edge_px = 0};
            made.tessellated = 0.5;
            break;
    }
    return made;
}

ParallaxSettings paper_parallax(double tile_width_m) {
    return {.method = ParallaxMethod::Iterative,
            .steps = 4,
            .range = ParallaxSettings::Range{.lowest_m = -0.004 * tile_width_m, .highest_m = 0}};
}

Result<void> check_detail(const DetailSettings& s) {
    if (const Result<void> named = check_named("backend", s.backend, DetailBackend::Hybrid); !named) return named;
    if (const Result<void> named = check_named("debug_view", s.debug_view, DebugView::Error); !named) return named;
    if (const Result<void> checked = check(s.parallax); !checked) return checked.error();
    if (!is_within(s.refinement.most_factor, 1, 64))
        return out_of_range("refinement.most_factor", s.refinement.most_factor, "1 to 64");
    if (s.refinement.edge_px != 0 && !is_within(s.refinement.edge_px, 0.5, 64))
        return out_of_range("refinement.edge_px", s.refinement.edge_px, "0 (always split), or 0.5 to 64 pixels");
    if (!is_within(s.phong.shape, 0, 1)) return out_of_range("phong.shape", s.phong.shape, "0 to 1");
    if (!is_within(s.phong.most_factor, 1, 16))
        return out_of_range("phong.most_factor", s.phong.most_factor, "1 to 16");
    if (!is_within(s.phong.edge_px, 0.5, 64)) return out_of_range("phong.edge_px", s.phong.edge_px, "0.5 to 64 pixels");
    if (!is_within(s.reach, 0.05, 1)) return out_of_range("reach", s.reach, "0.05 to 1");
    if (!is_within(s.tessellated, 0.05, 0.9)) return out_of_range("tessellated", s.tessellated, "0.05 to 0.9");
    if (!is_within(s.blend, 0.02, 0.5)) return out_of_range("blend", s.blend, "0.02 to 0.5");
    return {};
}

std::string_view name_of(DetailBackend backend) {
    switch (backend) {
        case DetailBackend::None:
            return "none";
        case DetailBackend::Parallax:
            return "parallax";
        case DetailBackend::Geometry:
            return "geometry";
        case DetailBackend::Tessellation:
            return "tessellation";
        case DetailBackend::Hybrid:
            return "hybrid";
    }
    return "";
}

std::string_view name_of(DetailPreset preset) {
    switch (preset) {
        case DetailPreset::Low:
            return "low";
        case DetailPreset::Medium:
            return "medium";
        case DetailPreset::High:
            return "high";
        case DetailPreset::Exact:
            return "exact";
    }
    return "";
}

}  // namespace tilth
