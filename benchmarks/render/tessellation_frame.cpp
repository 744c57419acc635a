// What does the tessellator cost? Rows of the table (relief_rows.h): edges of 4 pixels; all levels 1, where it only
// hands triangles on: the floor of having one.
#include "render/relief_rows.h"

namespace tilth::bench {
namespace {

DetailSettings tessellation(const RefinementSettings& refinement) {
    DetailSettings settings = detail_preset(DetailBackend::Tessellation, DetailPreset::Medium);
    settings.refinement = refinement;
    return settings;
}

const bool kAdded = add_relief_row({.name = "tessellation", .settings = tessellation({})}) &&
                    add_relief_row({.name = "floor_tessellation_of_1", .settings = tessellation({.most_factor = 1})});

}  // namespace
}  // namespace tilth::bench
