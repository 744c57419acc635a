#include "tilth/core/log.h"

#include <cstdio>
#include <mutex>

namespace tilth {
namespace {

void default_log(LogLevel level, std::string_view message, void* /*user*/) {
    if (level == LogLevel::Info) return;
    std::fprintf(stderr, "tilth: %s: %.*s\n", level == LogLevel::Error ? "error" : "warning",
                 static_cast<int>(message.size()), message.data());
}

struct Sink {
    std::mutex mutex;
    LogCallback callback = default_log;
    void* user = nullptr;
};

Sink& sink() {
    static Sink current;
    return current;
}

}  // namespace

void set_log_callback(LogCallback callback, void* user) {
    Sink& current = sink();
    const std::lock_guard lock(current.mutex);
    current.callback = callback != nullptr ? callback : default_log;
    current.user = user;
}

void log(LogLevel level, std::string_view message) {
    Sink& current = sink();
    const std::lock_guard lock(current.mutex);
    current.callback(level, message, current.user);
}

}  // namespace tilth
