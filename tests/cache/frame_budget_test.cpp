// The budget of transfers: what the rest of the frame leaves, and never nothing.
#include "tilth/cache/frame_budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kSlice = 256 << 10;

TEST(FrameBudget, TakesWhatTheFrameLeaves) {
    const BudgetSettings settings{.frame_target_ms = 16, .most_ms = 100};
    SplitMix64 random{1};
    for (int i = 0; i < 2000; ++i) {
        FrameBudget budget(settings);
        const double rest_ms = random.unit() * 30;
        budget.begin_frame(rest_ms);
        const double expected = rest_ms < 16 ? 16 - rest_ms : std::max(0.25, 0.05 * rest_ms);  // Tu = T - Tr
        EXPECT_DOUBLE_EQ(budget.allowed_ms(), expected);
    }
}

TEST(FrameBudget, NeverMoreThanTheLastFrameLeft) {
    const BudgetSettings settings;
    FrameBudget budget(settings);
    SplitMix64 random{2};
    int bound = 0;
    for (int i = 0; i < 20000; ++i) {
        const double rest_ms = 12 + 4.6 * random.unit();  // always something left
        budget.begin_frame(rest_ms);
        ASSERT_LE(budget.allowed_ms(), settings.frame_target_ms - rest_ms) << i;
        ASSERT_LE(budget.allowed_ms(), settings.most_ms);
        ASSERT_GT(budget.allowed_ms(), 0);
        bound += budget.allowed_ms() > 0.01;
    }
    EXPECT_GT(bound, 10000);
}

TEST(FrameBudget, SlowFramesCountAtOnceFastOnesByAndBy) {
    FrameBudget budget({.frame_target_ms = 20, .most_ms = 20});
    budget.begin_frame(4);
    EXPECT_DOUBLE_EQ(budget.allowed_ms(), 16);
    budget.begin_frame(12);
    EXPECT_DOUBLE_EQ(budget.allowed_ms(), 8);
    budget.begin_frame(4);
    EXPECT_DOUBLE_EQ(budget.allowed_ms(), 9);  // an eighth of the way from 12 to 4
    for (int i = 0; i < 100; ++i) budget.begin_frame(4);
    EXPECT_NEAR(budget.allowed_ms(), 16, 1e-4);
}

TEST(FrameBudget, TimesThatAreNoneChangeNothing) {
    FrameBudget budget({.frame_target_ms = 20, .most_ms = 20});
    budget.begin_frame(kNan);
    EXPECT_DOUBLE_EQ(budget.allowed_ms(), 0.25);  // nothing is known: the least
    budget.begin_frame(5);
    for (const double rest_ms : {kNan, kInfinity, -kInfinity, -1.0}) {
        budget.begin_frame(rest_ms);
        EXPECT_DOUBLE_EQ(budget.allowed_ms(), 15) << rest_ms;
    }
    for (const double ms : {kNan, kInfinity, -3.0}) budget.spend(kSlice, ms);
    EXPECT_EQ(budget.spent_ms(), 0);
    EXPECT_EQ(budget.spent_bytes(), 3 * kSlice);
    budget.spend(0, 1);  // no bytes, no rate
    EXPECT_TRUE(budget.allows(kSlice));
}

TEST(FrameBudget, OneSliceIsAlwaysAllowed) {
    FrameBudget budget({.frame_target_ms = 1, .most_bytes = 10});
    for (const double rest_ms : {0.0, 1.0, 5000.0}) {
        budget.begin_frame(rest_ms);
        EXPECT_TRUE(budget.allows(std::uint64_t{1} << 40));
        budget.spend(1 << 20, 900);
        EXPECT_FALSE(budget.allows(1));
    }
}

// What is allowed by estimate: the sum over a frame stays under both bounds if slices take what slices took.
TEST(FrameBudget, SlicesStayWithinTheBounds) {
    SplitMix64 random{3};
    for (int i = 0; i < 300; ++i) {
        const double ms_per_slice = 0.01 + random.unit();
        const BudgetSettings settings{.most_ms = 4, .most_bytes = (1 + random.next() % 40) * kSlice};
        FrameBudget budget(settings);
        for (int frame = 0; frame < 5; ++frame) {
            budget.begin_frame(8 * random.unit());
            int slices = 0;
            for (; budget.allows(kSlice); ++slices) budget.spend(kSlice, ms_per_slice);
            ASSERT_GE(slices, 1);
            ASSERT_LE(budget.spent_bytes(), settings.most_bytes);
            ASSERT_TRUE(slices == 1 || budget.spent_ms() <= settings.most_ms + 1e-9);
            // And not much less: one more would have been too many.
            const bool time_is_up = (slices + 1) * ms_per_slice > budget.allowed_ms() - 1e-9;
            ASSERT_TRUE(time_is_up || (static_cast<std::uint64_t>(slices) + 1) * kSlice > settings.most_bytes);
        }
    }
}

TEST(FrameBudget, ATurnForTheWorseShowsInTheEstimate) {
    FrameBudget budget({.frame_target_ms = 20, .most_ms = 20, .most_bytes = ~std::uint64_t{0}});
    budget.begin_frame(10);
    budget.spend(kSlice, 1);
    EXPECT_TRUE(budget.allows(9 * kSlice));
    EXPECT_FALSE(budget.allows(10 * kSlice));
    EXPECT_FALSE(budget.allows(~std::uint64_t{0}));  // does not wrap
    for (int i = 0; i < 60; ++i) budget.begin_frame(10), budget.spend(kSlice, 5);
    budget.begin_frame(10);
    budget.spend(kSlice, 5);
    EXPECT_FALSE(budget.allows(2 * kSlice));
}

}  // namespace
}  // namespace tilth
