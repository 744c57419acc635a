#include "tilth/core/result.h"

#include <gtest/gtest.h>

#include <memory>

namespace tilth {
namespace {

Result<int> half_of(int value) {
    if (value % 2 != 0) return Error{ErrorCode::InvalidArgument, text("value: ", value, " is odd")};
    return value / 2;
}

TEST(Result, HoldsAValueOrAnError) {
    const Result<int> good = half_of(8), bad = half_of(7);
    ASSERT_TRUE(good);
    EXPECT_EQ(*good, 4);
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(bad.error().message, "value: 7 is odd");
}

TEST(Result, MovesWhatCannotBeCopied) {
    Result<std::unique_ptr<int>> result = std::make_unique<int>(5);
    const std::unique_ptr<int> taken = *std::move(result);
    EXPECT_EQ(*taken, 5);
}

TEST(Result, VoidIsSuccessUnlessGivenAnError) {
    const Result<void> good, bad = Error{ErrorCode::NotFound, "gone"};
    EXPECT_TRUE(good.ok());
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.error().code, ErrorCode::NotFound);
}

TEST(ResultDeathTest, ReadingWhatIsNotThereStopsTheProgramWithTheMessage) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_DEATH(static_cast<void>(*half_of(7)), "value: 7 is odd");
    EXPECT_DEATH(static_cast<void>(half_of(8).error()), "holds a value");
}

TEST(Text, PrintsDoublesSoThatTheyCanBeReadBack) { EXPECT_EQ(text("a ", 0.1, ' ', 3), "a 0.10000000000000001 3"); }

}  // namespace
}  // namespace tilth
