// What does a geometry shader cost that splits triangles, and how much of it that there is one at all? Rows of the
// table (relief_rows.h): every texel a vertex, as the reference paper has it; edges of 4 pixels. Floors: a shader that
// passes each triangle of the same blocks through, declared for as many vertices, and for three.
#include "render/relief_rows.h"

namespace tilth::bench {
namespace {

DetailSettings geometry(const RefinementSettings& refinement) {
    DetailSettings settings = detail_preset(DetailBackend::Geometry, DetailPreset::Medium);
    settings.refinement = refinement;
    return settings;
}

const bool kAdded =
    add_relief_row({.name = "geometry", .settings = geometry({}), .by_resolution = true}) &&
    add_relief_row({.name = "geometry_all_texels", .settings = geometry({.edge_px = 0})}) &&
    add_relief_row({.name = "floor_pass_through", .settings = geometry({}), .shaders = RowShaders::PassThrough}) &&
    add_relief_row({.name = "floor_pass_through_3_vertices",
                    .settings = geometry({.most_factor = 1}),
                    .shaders = RowShaders::PassThrough});

}  // namespace
}  // namespace tilth::bench
