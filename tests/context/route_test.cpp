#include <gtest/gtest.h>

#include "tilth/context/offscreen_context.h"

namespace tilth::context {
namespace {

TEST(Route, names_go_both_ways) {
    for (Route route : {Route::Egl, Route::Osmesa}) {
        const auto back = route_of(name_of(route));
        ASSERT_TRUE(back.ok());
        EXPECT_EQ(*back, route);
    }
    const auto wrong = route_of("glx");
    ASSERT_FALSE(wrong.ok());
    EXPECT_EQ(wrong.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(wrong.error().message.find("egl"), std::string::npos);
    EXPECT_NE(wrong.error().message.find("osmesa"), std::string::npos);
}

TEST(OffscreenContext, refuses_a_size_that_is_none) {
    for (Route route : {Route::Egl, Route::Osmesa}) {
        const auto made = OffscreenContext::create(route, {.width = 0, .height = 5});
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(made.error().message.find("0 x 5"), std::string::npos);
    }
}

}  // namespace
}  // namespace tilth::context
