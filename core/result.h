#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/check.h"

namespace floatstage {

/// What kind of thing went wrong. apps/terminal/exit_codes.h gives each one its documented exit code.
enum class ErrorCode {
  InvalidArgument,  ///< the caller asked for something impossible (bad option, unequal sizes, unknown name)
  NotFound,         ///< a file, camera, frame or take that should be there is not
  AlreadyExists,    ///< an output is in the way; nothing is ever overwritten
  BadData,          ///< a file or message was read and does not make sense (truncated, NaN, wrong type)
  Unsupported,      ///< it makes sense, but this build or machine cannot do it
  Io,               ///< the operating system refused (disk full, permission, broken pipe)
  Timeout,          ///< nothing arrived in time; an outcome, the stream may go on
  Disconnected,     ///< the device or peer is gone
  EndOfStream,      ///< a recording has been played to its end; an outcome, not a fault
  Cancelled,        ///< the user interrupted
};

/// The stable lower-case name of a code ("bad-data"), for logs and JSON.
const char* name_of(ErrorCode code);

/// An expected failure: a code, and one sentence that names the file or camera, what is wrong and what to do.
struct Error {
  ErrorCode code = ErrorCode::InvalidArgument;
  std::string message;
};

/// Wraps an Error so that it converts to any Result<T>. Spelled as std::unexpected<Error> will be.
struct Unexpected {
  Error error_value;
};

inline Unexpected fail(ErrorCode code, std::string message) { return {{code, std::move(message)}}; }

/// A value or an Error, with the names of std::expected (which does not compile with clang-tidy 14 on
/// libstdc++ 12). Reading the side that is not there is our bug and throws CheckFailure.
template <class T>
class [[nodiscard]] Result {
 public:
  using value_type = T;

  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}               // NOLINT(*-explicit-*)
  Result(Unexpected u) : state_(std::in_place_index<1>, std::move(u.error_value)) {}  // NOLINT(*-explicit-*)

  bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  T& value() & {
    require_value();
    return *std::get_if<0>(&state_);
  }
  const T& value() const& {
    require_value();
    return *std::get_if<0>(&state_);
  }
  T&& value() && {
    require_value();
    return std::move(*std::get_if<0>(&state_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const {
    FLOATSTAGE_CHECK(!has_value(), "Result::error() on a value");
    return *std::get_if<1>(&state_);
  }

 private:
  void require_value() const {
    if (const Error* e = std::get_if<1>(&state_))
      FLOATSTAGE_CHECK(false, "Result::value() on an error: " + e->message);
  }
  std::variant<T, Error> state_;
};

/// Success without a value, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  using value_type = void;

  Result() = default;
  Result(Unexpected u) : error_(std::move(u.error_value)) {}  // NOLINT(*-explicit-*)

  bool has_value() const { return !error_; }
  explicit operator bool() const { return has_value(); }
  const Error& error() const {
    FLOATSTAGE_CHECK(error_.has_value(), "Result::error() on a value");
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

/// Passes the error of one Result on as the error of another: `if (!r) return forward(r);`
template <class T>
Unexpected forward(const Result<T>& failed) {
  return {failed.error()};
}

}  // namespace floatstage
