#include "demo/overlay/residency_map.h"

#include <algorithm>

namespace tilth::demo {

namespace {

constexpr Vec3f kBoard{0.05f, 0.05f, 0.07f}, kUntouched{0.17f, 0.17f, 0.18f}, kAbsent{0.26f, 0.32f, 0.46f},
    kLoading{0.90f, 0.80f, 0.15f}, kUploading{0.95f, 0.55f, 0.10f}, kResident{0.15f, 0.55f, 0.22f},
    kSaving{0.62f, 0.25f, 0.75f}, kActive{0.35f, 0.95f, 0.95f}, kDirty{0.85f, 0.10f, 0.10f}, kViewer{1, 1, 1},
    kFurtherViewer{0.65f, 0.65f, 0.65f};

constexpr std::int32_t kMostTiles = 15;  // a side: more are too small to tell apart
constexpr int kMargin = 8, kLeastSide = 64, kMostCell = 24;

Vec3f fill_of(TileState state) {
    switch (state) {
        case TileState::Absent:
            return kAbsent;
        case TileState::Loading:
            return kLoading;
        case TileState::Uploading:
            return kUploading;
        case TileState::Resident:
            return kResident;
        case TileState::Saving:
            return kSaving;
    }
    return kUntouched;
}

/// First of `most` (or all) tiles along one axis of `count`, with `viewer` in the middle where there is room.
std::int32_t first_shown(std::int32_t viewer, std::int32_t count, std::int32_t most) {
    return count <= most ? 0 : std::clamp(viewer - most / 2, 0, count - most);
}

PixelRect shrunk(const PixelRect& r, int by) { return {r.x0 + by, r.y0 + by, r.x1 - by, r.y1 - by}; }

const TileReport* find(std::span<const TileReport> tiles, TileIndex tile) {
    const auto at = std::lower_bound(tiles.begin(), tiles.end(), tile,
                                     [](const TileReport& report, TileIndex index) { return report.tile < index; });
    return at != tiles.end() && at->tile == tile ? &*at : nullptr;
}

/// Where tile cells and places lie in the picture.
struct Layout {
    TileWindow shown;
    int cell = 0, left = 0, top = 0;

    [[nodiscard]] PixelRect board() const {
        return {left - 2, top - 2, left + shown.columns() * cell + 2, top + shown.rows() * cell + 2};
    }
    [[nodiscard]] PixelRect cell_of(TileIndex t) const {
        const int x = left + (t.x - shown.min.x) * cell, y = top + (t.z - shown.min.z) * cell;
        return {x, y, x + cell, y + cell};
    }
    /// A square of 2 `half` pixels about a place in tiles, within the map.
    [[nodiscard]] PixelRect mark(const PostPos& tiles, int half) const {
        const double most_x = shown.columns(), most_z = shown.rows();
        const int x = left + int(std::clamp(tiles.x - shown.min.x, 0.0, most_x) * cell),
                  y = top + int(std::clamp(tiles.z - shown.min.z, 0.0, most_z) * cell);
        return {x - half, y - half, x + half, y + half};
    }
};

void paint_cell(const Layout& layout, TileIndex tile, const CellLook& look, std::vector<ColouredRect>& out) {
    const PixelRect inside = shrunk(layout.cell_of(tile), layout.cell >= 4 ? 1 : 0);
    const int line = std::max(1, layout.cell / 8);
    if (look.frame) out.push_back({inside, *look.frame});
    out.push_back({look.frame ? shrunk(inside, line) : inside, look.fill});
    if (look.dot) out.push_back({shrunk(inside, (inside.x1 - inside.x0 - layout.cell / 3) / 2), *look.dot});
}

}  // namespace

CellLook look_of(const TileReport* tile) {
    if (tile == nullptr) return {kUntouched, {}, {}};
    CellLook look{fill_of(tile->state), {}, {}};
    if (tile->interest == Interest::Active) look.frame = kActive;
    if (tile->modified) look.dot = kDirty;
    return look;
}

TileWindow shown_tiles(const TileGrid& grid, TileIndex viewer, std::int32_t most) {
    const std::int32_t columns = (grid.map.max.x - 1) / grid.size + 1, rows = (grid.map.max.z - 1) / grid.size + 1;
    const TileIndex first{first_shown(viewer.x, columns, most), first_shown(viewer.z, rows, most)};
    return {first, {first.x + std::min(most, columns) - 1, first.z + std::min(most, rows) - 1}};
}

std::vector<ColouredRect> residency_map(const ResidencyPlaces& places, int width, int height) {
    if (width < kLeastSide || height < kLeastSide || places.viewers.empty()) return {};
    const auto in_tiles = [&](WorldPos at) {
        const PostPos texels = places.texels.posts(at);
        return PostPos{texels.x / places.grid.size, texels.z / places.grid.size};
    };
    const PlaceInTile own = place_in_tile(places.grid, places.texels.posts(places.viewers[0]));
    Layout layout{.shown = shown_tiles(places.grid, own.tile, kMostTiles)};
    const int room = std::min(width, height) * 2 / 5, most = std::max(layout.shown.columns(), layout.shown.rows());
    layout.cell = std::clamp(room / most, 1, kMostCell);
    layout.left = width - kMargin - layout.shown.columns() * layout.cell, layout.top = kMargin;

    std::vector<ColouredRect> out{{layout.board(), kBoard}};
    for (std::int32_t z = layout.shown.min.z; z <= layout.shown.max.z; ++z)
        for (std::int32_t x = layout.shown.min.x; x <= layout.shown.max.x; ++x)
            paint_cell(layout, {x, z}, look_of(find(places.tiles, {x, z})), out);
    const int half = std::max(1, layout.cell / 6);
    for (std::size_t i = places.viewers.size(); i-- > 0;)  // the camera's own on top
        out.push_back({layout.mark(in_tiles(places.viewers[i]), half), i == 0 ? kViewer : kFurtherViewer});
    return out;
}

std::vector<ColouredRect> residency_map(const Terrain& terrain, std::span<const WorldPos> viewers, int width,
                                        int height) {
    const std::vector<TileReport> tiles = terrain.tiles();
    return residency_map({terrain.tile_grid(), terrain.ground().map(MapKind::Detail).grid, tiles, viewers}, width,
                         height);
}

}  // namespace tilth::demo
