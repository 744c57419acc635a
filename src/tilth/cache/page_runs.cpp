#include "tilth/cache/page_runs.h"

namespace tilth {

void add_pages(std::set<PageIndex>& pages, const TexelRect& rect) {
    for_each_page(pages_of(rect), [&](PageIndex page) { pages.insert(page); });
}

std::vector<TexelRect> rects_of(const std::set<PageIndex>& pages, const TexelRect& clip) {
    std::vector<TexelRect> runs;
    for (auto page = pages.begin(); page != pages.end();) {
        const PageIndex first = *page;
        std::int32_t end = first.z;
        while (page != pages.end() && page->x == first.x && page->z == end) ++end, ++page;
        const TexelRect run =
            intersection({texels_of(first).min, {(first.x + 1) * kPageTexels, end * kPageTexels}}, clip);
        if (run.empty()) continue;
        bool joined = false;
        for (TexelRect& before : runs)
            if (before.max.x == run.min.x && before.min.z == run.min.z && before.max.z == run.max.z) {
                before.max.x = run.max.x;
                joined = true;
                break;
            }
        if (!joined) runs.push_back(run);
    }
    return runs;
}

TexelRect take_run(std::set<PageIndex>& pages, std::int32_t most, const TexelRect& clip) {
    const PageIndex first = *pages.begin();
    std::int32_t end = first.z;
    while (!pages.empty() && end - first.z < most && pages.begin()->x == first.x && pages.begin()->z == end) {
        pages.erase(pages.begin());
        ++end;
    }
    return intersection({texels_of(first).min, {(first.x + 1) * kPageTexels, end * kPageTexels}}, clip);
}

}  // namespace tilth
