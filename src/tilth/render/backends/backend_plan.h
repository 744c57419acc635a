// What a detail backend is to the renderer: the programs it draws relief with, which of them a block takes, and where
// relief fades. Pure: each backend is one function that fills this in; the renderer does the drawing for all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tilth/gl/shader_library.h"
#include "tilth/render/detail_settings.h"

namespace tilth {

/// A program for blocks of relief, beside `render/terrain.vert` and `render/terrain.frag`.
struct ReliefRecipe {
    const char* name = "";
    gl::Features features;      ///< beyond those that the map and the block's kind ask for
    gl::ProgramOptions stages;  ///< geometry or tessellation shaders; empty: none
    bool patches = false;       ///< triangles are patches of three vertices
    bool displaces = false;     ///< moves the surface out of the coarse ground's bounds
};

/// Distances from the eye, metres, between which something fades from whole to nothing, smoothly.
struct FadeRange {
    float from_m = 0, to_m = 0;
};

struct BackendPlan {
    std::vector<ReliefRecipe> recipes;
    /// Zones by distance, nearest first: a block takes the first whose [from, to] holds all of it, else `mixed`.
    struct Zone {
        double from_m = 0, to_m = 0;
        std::size_t recipe = 0;
    };
    std::vector<Zone> zones;
    std::size_t mixed = 0;
    FadeRange displaced;  ///< what the mesh shows of the relief
    FadeRange all;        ///< what is shown at all; parallax takes what the mesh leaves

    [[nodiscard]] bool empty() const { return recipes.empty(); }
    /// The recipe of a block whose points lie between these distances from the eye.
    [[nodiscard]] std::size_t recipe_of(double nearest_m, double farthest_m) const;
};

/// What a plan is made for.
struct PlanInput {
    const DetailSettings& settings;  ///< checked
    double reach_m = 0;              ///< relief is gone from here on
    std::int32_t texels_per_post = 1;
    bool reversed_depth = false;
};

BackendPlan plan_parallax(const PlanInput& input);
BackendPlan plan_geometry(const PlanInput& input);
BackendPlan plan_tessellation(const PlanInput& input);
BackendPlan plan_hybrid(const PlanInput& input);
/// Of the backend that the settings name; empty for None.
BackendPlan plan_backend(const PlanInput& input);

/// Features that select parallax' method and options; shared by the backends that trace.
gl::Features parallax_features(const PlanInput& input);

}  // namespace tilth
