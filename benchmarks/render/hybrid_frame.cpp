// Is the hybrid cheaper than geometry at a smaller error? Rows of the table (relief_rows.h): the presets.
#include "render/relief_rows.h"

namespace tilth::bench {
namespace {

const bool kAdded =
    add_relief_row({.name = "hybrid",
                    .settings = detail_preset(DetailBackend::Hybrid, DetailPreset::Medium),
                    .by_resolution = true}) &&
    add_relief_row({.name = "hybrid_low", .settings = detail_preset(DetailBackend::Hybrid, DetailPreset::Low)});

}  // namespace
}  // namespace tilth::bench
