#include "tilth/store/rebuild.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "tilth/ground/before_image.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/detail_field.h"
#include "tilth/ground/prepared_stamp.h"

namespace tilth {
namespace {

/// The pages that must be right, each until a stamp: those before it are applied to the page, from it on nobody reads
/// the page any more.
using Region = std::map<PageIndex, std::size_t>;
constexpr std::size_t kToTheEnd = std::numeric_limits<std::size_t>::max();

/// Pages of `region` in `rect` that are still needed after stamp `number`.
std::vector<PageIndex> pages_needed(const Region& region, const PageRect& rect, std::size_t number) {
    std::vector<PageIndex> found;
    auto page = region.lower_bound(rect.min);
    while (page != region.end() && page->first.x < rect.max.x) {
        const PageIndex at = page->first;
        if (at.z < rect.min.z) {
            page = region.lower_bound({at.x, rect.min.z});
        } else if (at.z >= rect.max.z) {
            page = region.lower_bound({at.x + 1, rect.min.z});
        } else {
            if (page->second > number) found.push_back(at);
            ++page;
        }
    }
    return found;
}

/// Texels that a stamp may change or, with `smooth`, read for what it changes on a page.
TexelRect read_by(const TexelRect& changed, const MapGeometry& map) {
    return intersection(expanded(changed, 1), map.grid.rect());
}

class Rebuilding {
public:
    Rebuilding(const std::set<PageIndex>& pages, std::span<const StampRecord> stamps, const MapGeometry& map,
               const ShapeLibrary& shapes)
        : stamps_(stamps), map_(map), shapes_(shapes) {
        for (const PageIndex page : pages) region_[page] = kToTheEnd;
        find_what_is_needed();
    }

    void run(const std::function<std::uint32_t(Texel)>& original) {
        fill(original);
        for (auto number = needed_.rbegin(); number != needed_.rend(); ++number) apply(*number);
    }

    /// A copy of its own.
    [[nodiscard]] Page page(PageIndex at) const { return {at, std::make_shared<PageCodes>(*field_.find(at))}; }

private:
    /// From the last stamp to the first: which ones meet the region, and what the region must hold for them.
    void find_what_is_needed() {
        for (std::size_t number = stamps_.size(); number-- > 0;) {
            const StampRecord& record = stamps_[number];
            if (record.map != map_.kind) continue;
            const TexelRect reach = reach_of(record, map_, shapes_);
            const std::vector<PageIndex> changed = pages_needed(region_, pages_of(reach), number);
            if (changed.empty()) continue;
            needed_.push_back(number);
            if (record.rule != StampRule::Smooth) continue;
            for (const PageIndex at : changed)
                for_each_page(pages_of(read_by(intersection(reach, texels_of(at)), map_)),
                              [&](PageIndex read) { region_.try_emplace(read, number); });
        }
    }

    void fill(const std::function<std::uint32_t(Texel)>& original) {
        for (const auto& [at, until] : region_) {
            PageCodes& codes = field_.touch(at);
            const TexelRect whole = texels_of(at), part = intersection(whole, map_.grid.rect());
            for (std::int32_t z = part.min.z; z < part.max.z; ++z)
                for (std::int32_t x = part.min.x; x < part.max.x; ++x)
                    codes[static_cast<std::size_t>((z - whole.min.z) * kPageTexels + (x - whole.min.x))] =
                        original({x, z});
        }
    }

    void apply(std::size_t number) {
        const PreparedStamp stamp = prepare(stamps_[number], map_, shapes_);
        const std::vector<PageIndex> changed = pages_needed(region_, pages_of(stamp.rect()), number);
        if (stamp.reads_own_texel_only()) {
            for (const PageIndex at : changed)
                apply_stamp(stamp, field_, intersection(texels_of(at), map_.grid.rect()));
            return;
        }
        // All pages read what was there before, so the results come in when all are made.
        std::vector<Page> results;
        for (const PageIndex at : changed) results.push_back({at, smoothed(stamp, at)});
        for (Page& result : results) field_.put(std::move(result));
    }

    /// The page after a smooth stamp. Its surroundings are copies: a ring of one texel around the page, which is wrong
    /// afterwards, for it is smoothed as if the map ended behind it. Where the map does end there is no ring, and its
    /// border is repeated as it must be.
    std::shared_ptr<PageCodes> smoothed(const PreparedStamp& stamp, PageIndex at) {
        const TexelRect clip = read_by(texels_of(at), map_);
        DetailField copies;
        const PageRect around = pages_of(clip);
        for (Page& page : field_.pages_in(around)) copies.put(std::move(page));
        apply_stamp(stamp, copies, clip);
        return std::make_shared<PageCodes>(*copies.find(at));
    }

    std::span<const StampRecord> stamps_;
    const MapGeometry& map_;
    const ShapeLibrary& shapes_;
    Region region_;
    std::vector<std::size_t> needed_;  ///< stamps that meet the region, the last first
    DetailField field_;
};

}  // namespace

std::vector<StampRecord> stamps_in_effect(std::span<const Edit> edits) {
    std::vector<StampRecord> stamps;
    std::vector<std::size_t> begins;  // of each stroke that is in effect
    std::vector<std::vector<StampRecord>> undone;
    for (const Edit& edit : edits) switch (edit.kind) {
            case EditKind::Stamp:
                undone.clear();
                if (edit.begins_stroke || begins.empty()) begins.push_back(stamps.size());
                stamps.push_back(edit.record);
                break;
            case EditKind::Undo: {
                if (begins.empty()) break;  // no editor issues this
                const auto first = stamps.begin() + static_cast<std::ptrdiff_t>(begins.back());
                undone.emplace_back(first, stamps.end());
                stamps.erase(first, stamps.end());
                begins.pop_back();
                break;
            }
            case EditKind::Redo:
                if (undone.empty()) break;
                begins.push_back(stamps.size());
                stamps.insert(stamps.end(), undone.back().begin(), undone.back().end());
                undone.pop_back();
                break;
        }
    return stamps;
}

std::vector<Page> rebuild_pages(const std::set<PageIndex>& pages, std::span<const StampRecord> stamps,
                                const MapGeometry& map, const ShapeLibrary& shapes,
                                const std::function<std::uint32_t(Texel)>& original) {
    Rebuilding rebuilding(pages, stamps, map, shapes);
    rebuilding.run(original);
    std::vector<Page> rebuilt;
    rebuilt.reserve(pages.size());
    for (const PageIndex page : pages) rebuilt.push_back(rebuilding.page(page));
    return rebuilt;
}

}  // namespace tilth
