// The planner puts every stamp into exactly one pass, in order, and draws every texel of it once.
#include "tilth/deform/stamp_batches.h"

#include <gtest/gtest.h>

#include <map>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

std::vector<StampTraits> random_traits(std::uint64_t seed, std::size_t count, std::int32_t map, std::int32_t largest) {
    SplitMix64 random{seed};
    std::vector<StampTraits> traits;
    const TexelRect whole{{0, 0}, {map, map}};
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = [&](std::uint64_t span) { return static_cast<std::int32_t>(random.next() % span); };
        const Texel min{at(map + 40u) - 20, at(map + 40u) - 20};
        traits.push_back(
            {intersection({min, {min.x + at(largest), min.z + at(largest)}}, whole), random.next() % 10 != 0});
    }
    return traits;
}

TEST(StampBatches, EveryTexelOfEveryStampIsInOneBlockThatListsItInOrder) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const std::vector<StampTraits> traits = random_traits(seed, 200, 300, 150);
        std::vector<std::int64_t> covered(traits.size(), 0);
        std::size_t last_end = 0;
        for (const StampBatch& batch : plan_batches(traits, {.stamps = 50, .entries = 400, .blocks = 60})) {
            EXPECT_GE(batch.first, last_end);
            last_end = batch.first + batch.count;
            for (std::size_t i = 0; i < batch.blocks.size(); ++i) {
                const StampBlock& block = batch.blocks[i];
                for (std::size_t j = 0; j < i; ++j) EXPECT_TRUE(intersection(block.rect, batch.blocks[j].rect).empty());
                for (std::uint32_t k = 0; k < block.count; ++k) {
                    const std::uint32_t number = batch.order[block.first + k];
                    EXPECT_TRUE(k == 0 || number > batch.order[block.first + k - 1]);
                    covered[batch.first + number] +=
                        intersection(block.rect, traits[batch.first + number].rect).count();
                }
            }
        }
        for (std::size_t i = 0; i < traits.size(); ++i) EXPECT_EQ(covered[i], traits[i].rect.count()) << "stamp " << i;
    }
}

TEST(StampBatches, AStampThatCannotShareIsAloneInItsPass) {
    for (const StampBatch& batch : plan_batches(random_traits(3, 300, 500, 40))) {
        const std::vector<StampTraits> traits = random_traits(3, 300, 500, 40);
        for (std::size_t i = 0; i < batch.count; ++i)
            EXPECT_TRUE(traits[batch.first + i].shares_pass || batch.count == 1u);
    }
}

TEST(StampBatches, ALargeStampAloneIsOneBlock) {
    const StampTraits large[] = {{{{3, 5}, {4000, 3900}}, true}};
    const std::vector<StampBatch> batches = plan_batches(large);
    ASSERT_EQ(batches.size(), 1u);
    ASSERT_EQ(batches[0].blocks.size(), 1u);
    EXPECT_EQ(batches[0].blocks[0].rect, large[0].rect);
}

TEST(StampBatches, StampsOffTheMapMakeNoPass) {
    const StampTraits none[] = {{{}, true}, {{}, false}};
    EXPECT_TRUE(plan_batches(none).empty());
    EXPECT_TRUE(plan_batches({}).empty());
}

TEST(StampBatches, LimitsOfOnePassAreKept) {
    const BatchLimits limits{.stamps = 7, .entries = 30, .blocks = 12};
    for (const StampBatch& batch : plan_batches(random_traits(8, 400, 300, 120), limits)) {
        EXPECT_LE(batch.count, limits.stamps);
        if (batch.blocks.size() == 1) continue;
        EXPECT_LE(batch.blocks.size(), limits.blocks);
        EXPECT_LE(batch.order.size(), limits.entries);
    }
}

}  // namespace
}  // namespace tilth
