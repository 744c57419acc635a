#include "tilth/core/log.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tilth/core/checks.h"

namespace tilth {
namespace {

struct Seen {
    std::vector<std::pair<LogLevel, std::string>> messages;
    static void receive(LogLevel level, std::string_view message, void* user) {
        static_cast<Seen*>(user)->messages.emplace_back(level, message);
    }
};

TEST(Log, GoesToTheCallbackAndBackToStderr) {
    Seen seen;
    set_log_callback(Seen::receive, &seen);
    log(LogLevel::Info, "one");
    log(LogLevel::Error, "two");
    set_log_callback(nullptr, nullptr);
    testing::internal::CaptureStderr();
    log(LogLevel::Info, "dropped");
    log(LogLevel::Warning, "kept");
    const std::string printed = testing::internal::GetCapturedStderr();
    ASSERT_EQ(seen.messages.size(), 2u);
    EXPECT_EQ(seen.messages[0], std::pair(LogLevel::Info, std::string("one")));
    EXPECT_EQ(seen.messages[1], std::pair(LogLevel::Error, std::string("two")));
    EXPECT_EQ(printed.find("dropped"), std::string::npos);
    EXPECT_NE(printed.find("warning: kept"), std::string::npos);
}

TEST(ChecksDeathTest, TheHandlerIsToldWhatAndWhy) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_DEATH(TILTH_ASSERT(1 + 1 == 3, "arithmetic is broken"), "1 \\+ 1 == 3.*arithmetic is broken");
    EXPECT_DEATH(
        {
            set_assert_callback(
                [](const char*, int, const char* what, std::string_view why, void*) {
                    std::fprintf(stderr, "mine: %s because %.*s", what, static_cast<int>(why.size()), why.data());
                },
                nullptr);
            TILTH_ASSERT(false, "told");
        },
        "mine: false because told");
}

}  // namespace
}  // namespace tilth
