#include "tilth/store/world_repair.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <utility>

#include "tilth/ground/before_image.h"
#include "tilth/ground/detail_field.h"
#include "tilth/ground/prepared_stamp.h"
#include "tilth/store/rebuild.h"
#include "tilth/store/shape_files.h"

namespace tilth {
namespace {

constexpr std::uint64_t kBlockEdits = 1u << 15;  // 2 MiB of journal

WorldRepair::Strokes strokes_of(std::span<const Edit> edits) {
    WorldRepair::Strokes strokes;
    const auto move_last = [](auto& from, auto& to) {
        if (from.empty()) return;
        to.push_back(std::move(from.back()));
        from.pop_back();
    };
    for (const Edit& edit : edits) switch (edit.kind) {
            case EditKind::Stamp:
                strokes.undone.clear();
                if (edit.begins_stroke || strokes.done.empty()) strokes.done.emplace_back();
                strokes.done.back().push_back(edit.record);
                break;
            case EditKind::Undo:
                move_last(strokes.done, strokes.undone);
                break;
            case EditKind::Redo:
                move_last(strokes.undone, strokes.done);
                break;
        }
    return strokes;
}

/// What waits for a tile is the last that was stamped there. Empty: these stamps were never made.
std::optional<std::vector<StampRecord>> without(std::span<const StampRecord> stamps,
                                                std::span<const WaitingStamp> waiting) {
    std::vector<StampRecord> left;
    left.reserve(stamps.size());
    for (auto stamp = stamps.rbegin(); stamp != stamps.rend(); ++stamp) {
        if (!waiting.empty() && waiting.back().record == *stamp)
            waiting = waiting.first(waiting.size() - 1);
        else
            left.push_back(*stamp);
    }
    if (!waiting.empty()) return std::nullopt;
    std::reverse(left.begin(), left.end());
    return left;
}

}  // namespace

Result<void> WorldRepair::know(std::uint64_t edits) {
    if (known_ && known_->edits == edits) return {};
    known_.reset();
    if (edits > 0 && journal_.first() != 1)
        return Error{ErrorCode::NotFound, text("the journal begins at edit ", journal_.first(),
                                               ", and repairs need it from edit 1 on; take the world from a backup")};
    Known known{.edits = edits};
    std::vector<Edit> all;
    for (std::uint64_t first = 1; first <= edits; first += kBlockEdits) {
        auto block = journal_.read(first, std::min(edits, first + kBlockEdits - 1));
        if (!block) return block.error();
        std::move(block->begin(), block->end(), std::back_inserter(all));
    }
    const auto shapes = read_shapes(*place_.files, place_.folder, place_.salt, known.shapes);
    if (!shapes) return shapes.error();
    for (const Edit& edit : all) {
        if (edit.kind != EditKind::Stamp) continue;
        const StampRecord& record = edit.record;
        if (record.shape >= known.shapes.size() || known.shapes.shape({record.shape}).hash != record.shape_hash)
            return Error{ErrorCode::NotFound,
                         text("shape ", record.shape, " of stamp ", record.sequence, " is not in the world's folder")};
        known.last_sequence = std::max(known.last_sequence, record.sequence);
    }
    known.in_effect = stamps_in_effect(all);
    known.strokes = strokes_of(all);
    known_.emplace(std::move(known));
    return {};
}

std::vector<Page> WorldRepair::rebuilt(MapKind map, const std::set<PageIndex>& pages,
                                       std::span<const StampRecord> stamps) const {
    const auto original = map == MapKind::Coarse ? place_.original : [](Texel) { return kMidCode; };
    return rebuild_pages(pages, stamps, map_of(map), known_->shapes, original);
}

Result<std::vector<Page>> WorldRepair::pages(std::uint64_t edits, MapKind map, const std::set<PageIndex>& pages,
                                             std::span<const WaitingStamp> waiting) {
    if (const Result<void> known = know(edits); !known) return known.error();
    const auto applied = without(known_->in_effect, waiting);
    if (!applied) return Error{ErrorCode::FileFormat, "the journal lacks stamps that wait for a tile"};
    return rebuilt(map, pages, *applied);
}

Result<std::set<PageIndex>> WorldRepair::written(std::uint64_t edits, MapKind map) {
    if (const Result<void> known = know(edits); !known) return known.error();
    std::set<PageIndex> pages;
    for (const StampRecord& record : known_->in_effect)
        if (record.map == map)
            for_each_page(pages_of(reach_of(record, map_of(map), known_->shapes)),
                          [&](PageIndex page) { pages.insert(page); });
    return pages;
}

Result<std::uint64_t> WorldRepair::last_sequence(std::uint64_t edits) {
    if (const Result<void> known = know(edits); !known) return known.error();
    return known_->last_sequence;
}

Result<WorldRepair::Strokes> WorldRepair::strokes(std::uint64_t edits) {
    if (const Result<void> known = know(edits); !known) return known.error();
    return known_->strokes;
}

Result<bool> WorldRepair::reaches(std::uint64_t edits, const Stroke& stroke, const std::set<TileIndex>& tiles) {
    if (tiles.empty()) return false;
    if (const Result<void> known = know(edits); !known) return known.error();
    bool found = false;
    for (const StampRecord& record : stroke.records) {
        if (record.map != MapKind::Detail) continue;
        if (record.shape >= known_->shapes.size()) return true;  // it is not what it should be
        for_each_tile(tiles_of(place_.tiles, reach_of(record, place_.detail, known_->shapes)),
                      [&](TileIndex tile) { found = found || tiles.contains(tile); });
    }
    return found;
}

Result<void> WorldRepair::add_images(const Strokes& strokes, std::size_t place, Stroke& stroke,
                                     const std::map<TileIndex, std::vector<WaitingStamp>>& waiting) {
    TILTH_ASSERT(known_.has_value(), "strokes come from this object");
    std::vector<StampRecord> before;
    for (std::size_t i = 0; i < place; ++i) before.insert(before.end(), strokes.done[i].begin(), strokes.done[i].end());

    std::map<TileIndex, std::size_t> applied;  // stamps of the stroke on each tile that did not wait for it
    std::set<PageIndex> coarse, detail;
    for (const StampRecord& record : stroke.records) {
        const TexelRect reach = reach_of(record, map_of(record.map), known_->shapes);
        for_each_page(pages_of(reach),
                      [&](PageIndex page) { (record.map == MapKind::Coarse ? coarse : detail).insert(page); });
        if (record.map == MapKind::Detail)
            for_each_tile(tiles_of(place_.tiles, prepare(record, place_.detail, known_->shapes).rect()),
                          [&](TileIndex tile) { ++applied[tile]; });
    }
    for (const auto& [tile, stamps] : waiting)
        for (const WaitingStamp& stamp : stamps)
            if (const auto found = applied.find(tile); stamp.stroke == stroke.number && found != applied.end())
                --found->second;
    std::erase_if(detail, [&](PageIndex page) {
        const auto found = applied.find(place_.tiles.tile_of(texels_of(page).min));
        return found == applied.end() || found->second == 0;
    });

    for (Page& page : rebuilt(MapKind::Coarse, coarse, before)) stroke.coarse[page.index] = std::move(page.codes);
    for (Page& page : rebuilt(MapKind::Detail, detail, before))
        stroke.detail[page.index] = is_untouched(*page.codes) ? nullptr : std::move(page.codes);
    return {};
}

}  // namespace tilth
