// Where the library's messages go: one callback, owned by the host.
#pragma once

#include <string_view>

namespace tilth {

enum class LogLevel { Info, Warning, Error };

/// Receives every message. May be called from any thread that uses the library, one call at a time. It must not call
/// `log` or `set_log_callback` itself.
using LogCallback = void (*)(LogLevel level, std::string_view message, void* user);

/// Replaces the log callback; `nullptr` restores the default (warnings and errors to stderr, info dropped).
/// Thread-safe: when it returns, the old callback is no longer running.
void set_log_callback(LogCallback callback, void* user);

/// Sends one message to the callback. Thread-safe.
void log(LogLevel level, std::string_view message);

}  // namespace tilth
