#include "tilth/ground/cpu_executor.h"

#include <algorithm>
#include <vector>

namespace tilth {
namespace {

/// A copy of the texels that smooth reads: the rectangle and one texel around it, the map's border repeated.
class Before {
public:
    template <class CodeAt>
    Before(const TexelRect& rect, const TexelRect& map, const CodeAt& code_at)
        : origin_{rect.min.x - 1, rect.min.z - 1}, width_(rect.width() + 2) {
        codes_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(rect.depth() + 2));
        for (std::int32_t z = rect.min.z - 1; z <= rect.max.z; ++z)
            for (std::int32_t x = rect.min.x - 1; x <= rect.max.x; ++x)
                codes_.push_back(
                    code_at(Texel{std::clamp(x, map.min.x, map.max.x - 1), std::clamp(z, map.min.z, map.max.z - 1)}));
    }

    void attach(RowTask& task) const {
        for (std::int32_t row = 0; row < 3; ++row)
            task.before[row] =
                codes_.data() +
                static_cast<std::size_t>(task.z - 1 + row - origin_.z) * static_cast<std::size_t>(width_) +
                static_cast<std::size_t>(task.x - 1 - origin_.x);
    }

private:
    Texel origin_;
    std::int32_t width_;
    std::vector<std::uint32_t> codes_;
};

/// Runs the kernel over one part of the stamp's rectangle that lies in one piece of memory.
std::uint64_t apply_rows(const PreparedStamp& stamp, const TexelRect& part, const CpuKernels& kernels,
                         const Before* before, auto&& row_codes) {
    RowTask task{.stamp = &stamp.params, .weights = stamp.shape->weights.data()};
    std::uint64_t saturated = 0;
    for (task.z = part.min.z; task.z < part.max.z; ++task.z)
        for (task.x = part.min.x; task.x < part.max.x; task.x += kKernelTexels) {
            task.count = std::min(kKernelTexels, part.max.x - task.x);
            task.codes = row_codes(Texel{task.x, task.z});
            if (before != nullptr) before->attach(task);
            saturated += kernels.apply_row(task);
        }
    return saturated;
}

}  // namespace

ApplyResult apply_stamp(const PreparedStamp& stamp, HeightField& field, const CpuKernels& kernels) {
    const TexelRect rect = intersection(stamp.rect(), field.rect());
    if (rect.empty()) return {};
    const auto row_codes = [&](Texel t) { return field.row(t.z) + t.x; };
    ApplyResult result{.rect = rect, .texels = static_cast<std::uint64_t>(rect.count())};
    if (stamp.reads_own_texel_only()) {
        result.saturated = apply_rows(stamp, rect, kernels, nullptr, row_codes);
    } else {
        const Before before(rect, field.rect(), [&](Texel t) { return field.code(t); });
        result.saturated = apply_rows(stamp, rect, kernels, &before, row_codes);
    }
    return result;
}

ApplyResult apply_stamp(const PreparedStamp& stamp, DetailField& field, const TexelRect& map,
                        const CpuKernels& kernels) {
    const TexelRect rect = intersection(stamp.rect(), map);
    if (rect.empty()) return {};
    ApplyResult result{.rect = rect, .texels = static_cast<std::uint64_t>(rect.count())};
    std::vector<Before> before;  // one or none
    if (!stamp.reads_own_texel_only()) before.emplace_back(rect, map, [&](Texel t) { return field.code(t); });
    for_each_page(pages_of(rect), [&](PageIndex at) {
        PageCodes& page = field.touch(at);
        const TexelRect whole = texels_of(at);
        result.saturated +=
            apply_rows(stamp, intersection(rect, whole), kernels, before.empty() ? nullptr : before.data(),
                       [&](Texel t) { return page.data() + (t.z - whole.min.z) * kPageTexels + (t.x - whole.min.x); });
    });
    return result;
}

}  // namespace tilth
