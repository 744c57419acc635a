// Result<T>: what the world does wrong (a file, a driver, bad input) comes back as a value; nothing throws.
#pragma once

#include <sstream>
#include <string>
#include <utility>
#include <variant>

#include "tilth/core/checks.h"

namespace tilth {

/// What kind of thing went wrong. The message of an `Error` says what, where and what to do.
enum class ErrorCode {
    InvalidArgument,  ///< a value that the caller passed on from its user is not allowed; the message names the field
    NotFound,         ///< a file, shape or scenario that does not exist
    FileFormat,       ///< a file whose content is not what it claims to be
    FileRead,         ///< a file that could not be read
    FileWrite,        ///< a file that could not be written: the disk is full, or it is not ours to write
    Locked,           ///< another process, or another object of this one, has it open
    Unsupported,      ///< this build, driver or context cannot do it; the message says why
    ShaderCompile,    ///< the message is the driver's log with our file names and lines
    OutOfMemory,      ///< an allocation of the stated size was refused
    GlContext,        ///< no context, or one below GL 3.3 core
};

/// An error to be read by a person: `message` names the file or field and says what is allowed.
struct Error {
    ErrorCode code = ErrorCode::InvalidArgument;
    std::string message;
};

/// Joins its arguments into one string, as a stream would print them. For error messages, not for hot code.
template <class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream out;
    out.precision(17);
    (out << ... << parts);
    return out.str();
}

/// A `T` or an `Error`. Check with `if (!result)`, then use `*result`, `result->` or `result.error()`.
/// Reading the value of a failed result is the caller's mistake and stops the program in every build.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    [[nodiscard]] bool ok() const { return state_.index() == 0; }
    explicit operator bool() const { return ok(); }

    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(value()); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    [[nodiscard]] const Error& error() const {
        TILTH_ASSERT(!ok(), "error() of a Result that holds a value");
        return *std::get_if<1>(&state_);
    }

private:
    T& value() {
        TILTH_ASSERT(ok(), std::get_if<1>(&state_)->message);
        return *std::get_if<0>(&state_);
    }
    const T& value() const {
        TILTH_ASSERT(ok(), std::get_if<1>(&state_)->message);
        return *std::get_if<0>(&state_);
    }
    std::variant<T, Error> state_;
};

/// The result of something that yields nothing but may fail: `return {};` is success.
template <>
class [[nodiscard]] Result<void> {
public:
    Result() = default;
    Result(Error error) : error_(std::move(error)), ok_(false) {}

    [[nodiscard]] bool ok() const { return ok_; }
    explicit operator bool() const { return ok_; }

    [[nodiscard]] const Error& error() const {
        TILTH_ASSERT(!ok_, "error() of a Result that holds no error");
        return error_;
    }

private:
    Error error_;
    bool ok_ = true;
};

}  // namespace tilth
