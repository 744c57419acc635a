#include "tilth/ground/apply_edit.h"

#include <algorithm>

#include "tilth/ground/before_image.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/prepared_stamp.h"

namespace tilth {
namespace {

ApplyResult apply(Ground& ground, const PreparedStamp& stamp, const MapGeometry& map) {
    if (map.kind == MapKind::Detail) return apply_stamp(stamp, ground.mutable_detail(), map.grid.rect());
    return apply_stamp(stamp, ground.mutable_coarse());
}

ApplyResult apply_new(Ground& ground, const GroundEdit& edit) {
    const MapGeometry& map = ground.map(edit.record.map);
    const PreparedStamp stamp = prepare(edit.record, map, ground.shapes());
    if (map.kind == MapKind::Detail)
        keep_images(edit, stamp, map.grid.rect(), ground.detail(), map, ground.shapes());
    else
        keep_images(edit, stamp, ground.coarse(), map, ground.shapes());
    return apply(ground, stamp, map);
}

ApplyResult take_back(Ground& ground, MapKind kind, const Stroke& stroke) {
    TILTH_ASSERT(!stroke.forgotten, "a forgotten stroke cannot be undone");
    const MapGeometry& map = ground.map(kind);
    ApplyResult sum;
    for (const StampRecord& record : undoing_records(stroke))
        if (record.map == kind) sum += apply(ground, prepare(record, map, ground.shapes()), map);
    for (const auto& [page, image] : stroke.images(kind)) {
        if (kind == MapKind::Coarse) {
            put_page(ground.mutable_coarse(), page, *image);
            sum.rect = bounds_of(sum.rect, intersection(texels_of(page), ground.coarse().rect()));
        } else {
            put_image(ground.mutable_detail(), page, image);
            sum.rect = bounds_of(sum.rect, intersection(texels_of(page), map.grid.rect()));
        }
    }
    return sum;
}

}  // namespace

ApplyResult apply_edit(Ground& ground, MapKind map, const GroundEdit& edit) {
    if (edit.kind == GroundEdit::Kind::Undo) return take_back(ground, map, *edit.stroke);
    return edit.record.map == map ? apply_new(ground, edit) : ApplyResult{};
}

ApplyResult apply_edit(Ground& ground, const GroundEdit& edit) {
    ApplyResult sum = apply_edit(ground, MapKind::Coarse, edit);
    if (edit.kind == GroundEdit::Kind::Undo || edit.record.map == MapKind::Detail) sum.rect = {};
    sum += apply_edit(ground, MapKind::Detail, edit);
    return sum;
}

bool concerns(const GroundEdit& edit, MapKind map) {
    if (edit.kind == GroundEdit::Kind::Stamp) return edit.record.map == map;
    const std::vector<StampRecord>& records = edit.stroke->records;
    return std::any_of(records.begin(), records.end(), [&](const StampRecord& record) { return record.map == map; });
}

std::vector<ChangedRect> changed_by(const Ground& ground, const GroundEdit& edit) {
    std::vector<ChangedRect> changed;
    const auto note = [&](const StampRecord& record) {
        const TexelRect rect = prepare(record, ground.map(record.map), ground.shapes()).rect();
        if (!rect.empty()) changed.push_back({record.map, rect, record.sequence});
    };
    if (edit.kind == GroundEdit::Kind::Stamp)
        note(edit.record);
    else
        for (const StampRecord& record : edit.stroke->records) note(record);
    return changed;
}

}  // namespace tilth
