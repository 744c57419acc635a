// How fine detail is shown: which backend, and its knobs. Plain data, no GL.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "tilth/core/result.h"

namespace tilth {

enum class DetailBackend : std::uint8_t {
    None,          ///< slopes alone: detail is light and shade, and costs no more than that
    Parallax,      ///< each pixel follows its ray into the relief; silhouettes stay those of the coarse ground
    Geometry,      ///< a geometry shader splits triangles where there is detail under them
    Tessellation,  ///< the same by the tessellator; needs GL 4.0
    Hybrid,        ///< tessellated close by, parallax in a ring about it; needs GL 4.0
};

enum class ParallaxMethod : std::uint8_t {
    Iterative,  ///< `steps` times offset limiting (Premecz 2006, the reference paper's way): underestimates at grazing
                ///< angles by (1 - sin e)^steps
    Secant,     ///< `steps` linear steps, up to four times as many where they would be longer than two texels, with
                ///< early exit, then one secant step; error falls as 1 / steps where features are thinner than a step,
                ///< much faster elsewhere
    Exact,      ///< max-mip traversal (Tevs, Ihrke, Seidel 2008) to the triangle of the cell: on even coarse ground no
                ///< error and no steps; every method takes bent ground for its tangent plane
};

struct ParallaxSettings {
    ParallaxMethod method = ParallaxMethod::Secant;
    std::int32_t steps = 16;  ///< 1..256; Exact has none
    /// The relief that is searched, metres from the coarse ground; what leaves it is clamped. Empty: what there is
    /// about the pixel, as far as its ray can meet it. The paper's: 0.004 tile widths deep, and nothing above.
    struct Range {
        double lowest_m = 0, highest_m = 0;
        friend bool operator==(const Range&, const Range&) = default;
    };
    std::optional<Range> range;
    /// Rays flatter than this against the ground are followed as if they were as steep, so that no pixel moves by more
    /// than depth / tan of it; 0.1 to 45 degrees.
    double least_elevation_rad = 0.035;
    bool depth = false;             ///< writes the depth of what is seen: other objects sink into prints; costs early z
    std::int32_t shadow_steps = 0;  ///< linear steps towards the light, 0..64; 0: no self-shadowing
    friend bool operator==(const ParallaxSettings&, const ParallaxSettings&) = default;
};

/// Of backends that make triangles.
struct RefinementSettings {
    /// Most parts an edge between two posts is split in, 1..64; never more than the texels a post, and by `Geometry` at
    /// most 8 (what a geometry shader may emit), if possible a divisor of the texels a post.
    std::int32_t most_factor = 16;
    /// Edges are split until their parts are about this long on the screen, 0.5..64 pixels; 0: always `most_factor`.
    /// Factors are whole numbers: where one changes, relief moves by what the edge's parts had left out.
    double edge_px = 4;
    friend bool operator==(const RefinementSettings&, const RefinementSettings&) = default;
};

/// Curved triangles (Boubekeur & Alexa, Phong Tessellation, 2008) on all levels, or with a backend other than None on
/// all but the finest, whose relief meets it: rounds the piecewise linear silhouettes of smooth hills. Needs GL 4.0.
/// Rough rings are then not refined (`ClipmapSettings::refine_above_px` has no effect).
struct PhongSettings {
    bool on = false;
    double shape = 0.5;            ///< 0 flat .. 1; 0.5 is exact on parabolas
    std::int32_t most_factor = 4;  ///< 1..16
    double edge_px = 8;            ///< as above
    friend bool operator==(const PhongSettings&, const PhongSettings&) = default;
};

/// What a picture tells in place of its colours.
enum class DebugView : std::uint8_t {
    Off,
    Wireframe,  ///< triangles as they are rasterised
    Level,      ///< clipmap level
    Tile,       ///< detail tile
    Backend,    ///< who shows the pixel: displaced, traced, slopes only
    Fetches,    ///< heights read by parallax: 0 black, 32 and more white
    Error,      ///< shown relief against the exact surface, texels: 0 black, 4 and more white
};

struct DetailSettings {
    DetailBackend backend = DetailBackend::None;
    ParallaxSettings parallax;
    RefinementSettings refinement;
    PhongSettings phong;
    /// Share of the finest level's unmorphed part in which relief is shown, 0.05..1, as far as active tiles reach (half
    /// a tile less half the band); it fades over the last quarter.
    double reach = 1.0;
    /// Hybrid: share of that in which triangles alone show it, 0.05..0.9, and width of the blend to parallax,
    /// 0.02..0.5.
    double tessellated = 0.35, blend = 0.15;
    DebugView debug_view = DebugView::Off;
    friend bool operator==(const DetailSettings&, const DetailSettings&) = default;
};

/// Quality by name: method and parameters of every backend.
///   low     iterative parallax, 4 steps; edges of 8 px; reach 0.6
///   medium  secant parallax, 16 steps; edges of 4 px
///   high    secant parallax, 32 steps, depth, shadows; edges of 2 px
///   exact   exact parallax, depth; every texel a vertex: for `Geometry` up to 8 texels a post, for the tessellator on
///           edges (within triangles it has a pattern of its own)
enum class DetailPreset : std::uint8_t { Low, Medium, High, Exact };
DetailSettings detail_preset(DetailBackend backend, DetailPreset preset);

/// The paper's parallax: offset limiting, bias -0.004 and scale 0.004 in tile widths, 4 iterations.
ParallaxSettings paper_parallax(double tile_width_m);

/// Fails with InvalidArgument naming the field.
Result<void> check_detail(const DetailSettings& settings);

/// Names as in scenario files: "none", "parallax", ... and "low", ...
std::string_view name_of(DetailBackend backend);
std::string_view name_of(DetailPreset preset);

}  // namespace tilth
