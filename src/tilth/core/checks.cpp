#include "tilth/core/checks.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <mutex>

namespace tilth {
namespace {

struct Handler {
    AssertCallback callback = nullptr;
    void* user = nullptr;
};

std::mutex& handler_mutex() {
    static std::mutex mutex;
    return mutex;
}

Handler& handler() {
    static Handler current;
    return current;
}

}  // namespace

void set_assert_callback(AssertCallback callback, void* user) {
    const std::lock_guard lock(handler_mutex());
    handler() = {callback, user};
}

namespace detail {

void check_failed(const char* file, int line, const char* what, std::string_view why) {
    Handler current;
    {
        const std::lock_guard lock(handler_mutex());
        current = handler();
    }
    if (current.callback != nullptr)
        current.callback(file, line, what, why, current.user);
    else
        std::fprintf(stderr, "%s:%d: check failed: %s: %.*s\n", file, line, what, static_cast<int>(why.size()),
                     why.data());
    std::abort();
}

}  // namespace detail
}  // namespace tilth
