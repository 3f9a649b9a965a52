/// A value, or the reason why the world did not allow it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/ensure.h"

namespace partscribe::core {

/// What kind of bad news an Error carries; the number is the program's exit code.
enum class ErrorKind : int {
  usage = 2,            ///< the request makes no sense
  bad_input = 3,        ///< a file cannot be used
  missing_program = 4,  ///< a needed program is not installed
  stopped = 5,          ///< cancelled, or a time or memory limit was reached
};

/// One line for the user: what was expected, what was found, where.
struct Error {
  std::string message;
  ErrorKind kind = ErrorKind::bad_input;
};

/// Either a T or an Error. Ask `ok()` before `value()`.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & {
    ensure(ok(), "value() of a failed result");
    return std::get<0>(state_);
  }
  const T& value() const& {
    ensure(ok(), "value() of a failed result");
    return std::get<0>(state_);
  }
  T&& value() && {
    ensure(ok(), "value() of a failed result");
    return std::get<0>(std::move(state_));
  }
  const Error& error() const {
    ensure(!ok(), "error() of a good result");
    return std::get<1>(state_);
  }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }

 private:
  std::variant<T, Error> state_;
};

/// A result without a value.
struct Done {};

inline Error bad_input(std::string message) { return {std::move(message), ErrorKind::bad_input}; }
inline Error usage_error(std::string message) { return {std::move(message), ErrorKind::usage}; }

}  // namespace partscribe::core
