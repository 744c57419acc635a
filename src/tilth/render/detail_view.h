// The detail tiles that a frame samples, as the renderer sees them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "tilth/gl/objects.h"
#include "tilth/ground/code_range.h"
#include "tilth/pool/relief_window.h"
#include "tilth/pool/slope_map.h"
#include "tilth/render/detail_settings.h"
#include "tilth/world/tile_grid.h"

namespace tilth {

/// Where there is detail, and how high it can be.
class ReliefBounds {
public:
    virtual ~ReliefBounds() = default;
    /// Holds every code in `rect` (texels of the map) that the relief window shows: never narrower than the truth.
    /// {kMidCode, kMidCode} on ground that nobody touched.
    [[nodiscard]] virtual CodeRange query(const TexelRect& rect) const = 0;
};

/// Fine detail about the eye as relief.
struct ReliefView {
    const ReliefWindow* window = nullptr;
    const ReliefBounds* bounds = nullptr;
    TexelRect square;                        ///< texels of the map that the window shows
    double code_quantum_m = 0;               ///< of detail codes
    CodeRange extremes{kMidCode, kMidCode};  ///< of all that the window shows
};

/// The active tiles of one view: one, two or four, in a window of at most 2 x 2. Slopes of a tile lie in a texture of
/// stored_size^2 texels in the format of the map's own slopes, level 0 only, linear filtering, clamped to the edge:
/// texel (i, j) of it is texel stored(tile).min + (i, j) of the detail map, the slope there in metres per metre of the
/// detail height alone. The apron is 1 texel or more, or a line shows where two tiles meet.
struct DetailView {
    TileGrid grid;
    double spacing_m = 0;  ///< between detail texels: a whole number of them makes the spacing of the map's posts
    TileWindow window;     ///< tiles of the textures below
    /// At (row of the window) * 2 + (column). Nullptr: untouched, or not resident: it adds nothing.
    std::array<const gl::Texture2D*, 4> slopes{};
    /// Horizontal distance from the eye by which detail has faded out, metres; it is whole up to half of that. Beyond
    /// the window there is no detail, so that its border shows where it lies nearer than this. 0 or less: no detail.
    double reach_m = 0;
    /// How it is shown; with a backend `relief` must be there, or slopes alone are shown.
    DetailSettings settings;
    std::optional<ReliefView> relief;

    [[nodiscard]] bool empty() const {
        for (const gl::Texture2D* texture : slopes)
            if (texture != nullptr) return false;
        return true;
    }
};

}  // namespace tilth
