// What does parallax cost by method, and how much of it are the fetches? Rows of the table (relief_rows.h): the
// reference paper's method, secant with 16 steps, exact; floors: programs that make so many linear fetches of heights
// at the fragment's own place and otherwise shade as `none` does.
#include "render/relief_rows.h"
#include "render/relief_scene.h"

namespace tilth::bench {
namespace {

DetailSettings parallax(const ParallaxSettings& method) {
    DetailSettings settings = detail_preset(DetailBackend::Parallax, DetailPreset::Medium);
    settings.parallax = method;
    return settings;
}
bool add_floor(const char* name, int fetches) {
    return add_relief_row({.name = name,
                           .settings = parallax({.method = ParallaxMethod::Iterative, .steps = fetches}),
                           .shaders = RowShaders::PlainFetches});
}

const bool kAdded =
    add_relief_row(
        {.name = "parallax_paper", .settings = parallax(paper_parallax(kTileWidth_m)), .by_resolution = true}) &&
    add_relief_row({.name = "parallax_secant16", .settings = parallax({})}) &&
    add_relief_row({.name = "parallax_exact", .settings = parallax({.method = ParallaxMethod::Exact})}) &&
    add_floor("floor_1_fetch", 1) && add_floor("floor_4_fetches", 4) && add_floor("floor_16_fetches", 16);

}  // namespace
}  // namespace tilth::bench
