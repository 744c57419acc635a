#include "tilth/deform/stamp_batches.h"

#include <map>
#include <utility>

namespace tilth {
namespace {

/// The lists of a pass while stamps are added to it.
class Builder {
public:
    Builder(std::size_t first, const BatchLimits& limits) : first_(first), limits_(limits) {}

    /// False if the pass would outgrow its limits; it is then unchanged.
    bool add(const TexelRect& rect) {
        if (count_ == limits_.stamps) return false;
        const Texel low{rect.min.x / kBlockTexels, rect.min.z / kBlockTexels};
        const Texel high{(rect.max.x - 1) / kBlockTexels, (rect.max.z - 1) / kBlockTexels};
        const std::size_t touched =
            static_cast<std::size_t>(high.x - low.x + 1) * static_cast<std::size_t>(high.z - low.z + 1);
        if (rect.empty()) {
            ++count_;
            return true;
        }
        if (entries_ + touched > limits_.entries || blocks_.size() + touched > limits_.blocks) return false;
        for (std::int32_t z = low.z; z <= high.z; ++z)
            for (std::int32_t x = low.x; x <= high.x; ++x) {
                const Texel corner{x * kBlockTexels, z * kBlockTexels};
                Block& block = blocks_[{z, x}];
                block.rect = bounds_of(
                    block.rect, intersection(rect, {corner, {corner.x + kBlockTexels, corner.z + kBlockTexels}}));
                block.stamps.push_back(static_cast<std::uint32_t>(count_));
            }
        entries_ += touched;
        only_ = rect;
        touching_ += 1;
        ++count_;
        return true;
    }

    [[nodiscard]] StampBatch take() {
        StampBatch batch{.first = first_, .count = count_};
        if (touching_ == 1) return alone(batch, only_, blocks_.begin()->second.stamps.front());
        for (const auto& [place, block] : blocks_) {
            batch.blocks.push_back({block.rect, static_cast<std::uint32_t>(batch.order.size()),
                                    static_cast<std::uint32_t>(block.stamps.size())});
            batch.order.insert(batch.order.end(), block.stamps.begin(), block.stamps.end());
        }
        return batch;
    }

    static StampBatch alone(StampBatch batch, const TexelRect& rect, std::uint32_t number) {
        batch.blocks = {{rect, 0, 1}};
        batch.order = {number};
        return batch;
    }

private:
    struct Block {
        TexelRect rect;
        std::vector<std::uint32_t> stamps;
    };
    std::size_t first_, count_ = 0, entries_ = 0, touching_ = 0;
    BatchLimits limits_;
    std::map<std::pair<std::int32_t, std::int32_t>, Block> blocks_;
    TexelRect only_;
};

}  // namespace

std::vector<StampBatch> plan_batches(std::span<const StampTraits> stamps, const BatchLimits& limits) {
    std::vector<StampBatch> batches;
    const auto finish = [&](StampBatch batch) {
        if (!batch.blocks.empty()) batches.push_back(std::move(batch));
    };
    for (std::size_t next = 0; next < stamps.size();) {
        Builder builder(next, limits);
        std::size_t end = next;
        while (end < stamps.size() && stamps[end].shares_pass && builder.add(stamps[end].rect)) ++end;
        if (end > next) {
            finish(builder.take());
        } else {  // it cannot share a pass, or is too large for one with others
            if (!stamps[end].rect.empty()) finish(Builder::alone({.first = end, .count = 1}, stamps[end].rect, 0));
            ++end;
        }
        next = end;
    }
    return batches;
}

}  // namespace tilth
