// Checks for mistakes in code: the caller's (TILTH_EXPECTS) and our own (TILTH_ASSERT).
#pragma once

#include <string_view>

namespace tilth {

/// Called when a check fails, before the program stops. `what` is the failed condition, `why` the message.
using AssertCallback = void (*)(const char* file, int line, const char* what, std::string_view why, void* user);

/// Replaces the handler of failed checks (default: print to stderr). After the handler returns, the program aborts.
/// Thread-safe; the pointers must stay valid until replaced.
void set_assert_callback(AssertCallback callback, void* user);

namespace detail {
[[noreturn]] void check_failed(const char* file, int line, const char* what, std::string_view why);
}

}  // namespace tilth

/// Our own mistake. Checked in every build: it guards memory, and costs one predictable branch.
#define TILTH_ASSERT(condition, why) \
    ((condition) ? static_cast<void>(0) : ::tilth::detail::check_failed(__FILE__, __LINE__, #condition, why))

/// The caller's mistake. Checked in debug builds only; `why` may build a message with values in it.
#ifdef NDEBUG
#define TILTH_EXPECTS(condition, why) static_cast<void>(0)
#else
#define TILTH_EXPECTS(condition, why) TILTH_ASSERT(condition, why)
#endif
